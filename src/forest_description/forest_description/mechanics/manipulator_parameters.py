"""The links of the crane: masses, inertias, lengths, and what the head holds. Thesis App. B."""

from dataclasses import dataclass

from forest_description.config.parameter import MachineError, ParameterSet, choice, parameter
from forest_description.geometry.kinematics import Links
from forest_description.mechanics.inertia import require_rigid
from forest_description.mechanics.load import Log, Pendulum, RotatorAndGrapple


@dataclass(frozen=True)
class Manipulator(ParameterSet):
    """Links of the crane, each symmetric about the crane's plane. Thesis App. B.

    Link frames: x along the link from its joint, z the joint axis, y across, upwards when the link
    points forward. Boom and stick inertias are about the centre of mass, the base's about the swing
    axis frame's own; a product I_xy is the integral of x y dm. The head is a point at the tip, or
    hangs from it.
    """

    log: Log | None
    pendulum: Pendulum | RotatorAndGrapple | None
    gravity: float = parameter("m/s2", 0.0, 30.0, "acceleration of gravity g")
    platform_tilt: float = parameter("rad", -1.0, 1.0, "tilt λ of the platform about its x axis")
    base_mass: float = parameter("kg", 0.0, 1e6, "mass of the swing base m1")
    boom_mass: float = parameter("kg", 0.0, 1e6, "mass of the boom m2")
    stick_mass: float = parameter("kg", 0.0, 1e6, "mass of the stick without head m3s")
    head_mass: float = parameter("kg", 0.0, 1e6, "mass of the head m4, a point at the stick's tip")
    base_offset: float = parameter("m", 0.0, 10.0, "swing axis to boom pivot l1, horizontal")
    boom_length: float = parameter("m", 0.1, 50.0, "boom pivot to stick pivot l2")
    stick_length: float = parameter("m", 0.1, 50.0, "stick pivot to tip l3")
    base_x: float = parameter("m", -10.0, 10.0, "base's centre of mass, along x1")
    boom_x: float = parameter("m", -50.0, 50.0, "boom's centre of mass, along the boom x2")
    boom_y: float = parameter("m", -10.0, 10.0, "boom's centre of mass, across y2")
    stick_x: float = parameter("m", -50.0, 50.0, "stick's centre of mass without head, along the stick x3s")
    stick_y: float = parameter("m", -10.0, 10.0, "stick's centre of mass without head, across y3s")
    base_zz: float = parameter("kg*m2", 0.0, 1e7, "base's inertia about the vertical I1zz")
    boom_xx: float = parameter("kg*m2", 0.0, 1e7, "boom's inertia about its x axis I2xx")
    boom_yy: float = parameter("kg*m2", 0.0, 1e7, "boom's inertia about its y axis I2yy")
    boom_zz: float = parameter("kg*m2", 0.0, 1e7, "boom's inertia about the joint direction I2zz")
    boom_xy: float = parameter("kg*m2", -1e7, 1e7, "boom's product of inertia I2xy")
    stick_xx: float = parameter("kg*m2", 0.0, 1e7, "stick's inertia about its x axis I3xxs")
    stick_yy: float = parameter("kg*m2", 0.0, 1e7, "stick's inertia about its y axis I3yys")
    stick_zz: float = parameter("kg*m2", 0.0, 1e7, "stick's inertia about the joint direction I3zzs")
    stick_xy: float = parameter("kg*m2", -1e7, 1e7, "stick's product of inertia I3xys")
    head_folding: str = choice(
        "thesis",
        "full",
        doc="whether the head gives the stick its share of I3xx and I3xy; thesis: it gives none, and an I_xx "
        "of 0 means that it is not told (App. B)",
    )

    def __post_init__(self) -> None:
        """Check ranges, that links are bodies, that the stick resists, and how a head hangs."""
        super().__post_init__()
        boom, stick = (
            (self.boom_xx, self.boom_yy, self.boom_zz),
            (self.stick_xx, self.stick_yy, self.stick_zz),
        )
        require_rigid("boom", self.boom_mass, boom, self.boom_xy, self.head_folding == "thesis")
        require_rigid("stick", self.stick_mass, stick, self.stick_xy, self.head_folding == "thesis")
        about_joint = self.stick_zz + self.stick_mass * (self.stick_x**2 + self.stick_y**2)
        if about_joint + (self.head_mass if self.pendulum is None else 0.0) <= 0.0:
            raise MachineError(
                "stick_mass: nothing resists the stick's acceleration; allowed: a mass off its joint, an "
                "inertia, or a head that does not hang"
            )
        if self.pendulum is None:
            return
        if self.head_mass <= 0.0:
            raise MachineError("head_mass: a head that hangs (pendulum) needs a mass above 0 kg")
        self.pendulum.require_compact(self.head_mass)
        if self.log is not None and (self.log.x < 0.0 or self.log.y != 0.0):
            raise MachineError(
                f"log: ({self.log.x:g}, {self.log.y:g}) m: in a head that hangs (pendulum) its centre must "
                f"lie on the head's axis, x at least 0 m and y 0 m"
            )

    @property
    def links(self) -> Links:
        """The constants of ``kinematics.py``'s functions."""
        return Links(self.base_offset, self.boom_length, self.stick_length)
