"""What hangs on the stick's tip besides the head's bare mass: a log in it, a joint that lets it swing.

Both are optional sections of the manipulator. A log sits still in the head. Without a pendulum,
head and log are rigid parts of the stick; with one, both hang from a passive joint with two axes at
the tip. The hanging head is told as one body, or by its parts: a rotator, and a grapple or
processing head under it.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

from forest_description.config.parameter import (
    MachineError,
    ParameterSet,
    optional_parameter,
    parameter,
    require_order,
)

WIDEST = 3.0  # [m] of a head's mass from its centre; the longest processing heads have 2 m


@dataclass(frozen=True)
class Log(ParameterSet):
    """A log in the head; without a length it is a point at its centre of mass."""

    mass: float = parameter("kg", 0.0, 1e5, "mass of the log")
    x: float = parameter(
        "m", -20.0, 20.0, "log's centre from the tip, along the stick; along the head if that is a pendulum"
    )
    y: float = parameter("m", -20.0, 20.0, "log's centre from the tip, across the stick; 0 with a pendulum")
    length: float | None = optional_parameter(
        "m", 0.0, 50.0, "log's length: a slender rod in the crane's plane, across a head that hangs"
    )

    @property
    def inertia(self) -> float:
        """Inertia about the centre, across the log [kg m^2]: m l^2/12."""
        return self.mass * (self.length or 0.0) ** 2 / 12.0


@dataclass(frozen=True)
class Pendulum(ParameterSet):
    """Passive 2-DOF joint at the tip from which the head hangs, a body of revolution. Thesis section 4.4.

    Differs: the thesis had one on its machine and a point mass in its model.
    """

    length: float = parameter("m", 0.01, 20.0, "joint to the head's centre of mass")
    inertia: float = parameter("kg*m2", 0.0, 1e6, "head's inertia about its centre, across its axis")
    damping: float = parameter("N*m*s/rad", 0.0, 1e6, "viscous damping of each of the joint's axes")

    def require_compact(self, head_mass: float) -> None:
        """Check that the head's mass [kg] need not lie far from its centre.

        Raises:
            MachineError: it must.
        """
        _require_compact("inertia", self.inertia, head_mass)


@dataclass(frozen=True)
class RotatorAndGrapple(ParameterSet):
    """The same joint, and under it a rotator and a grapple or processing head: head_mass is both.

    What `Pendulum` tells follows from the parts (`derived.bodies.hanging_body`).
    """

    kind: ClassVar[str] = "grapple"
    rotator_mass: float = parameter("kg", 0.0, 1e5, "link and rotator; the grapple is the rest of head_mass")
    rotator_centre: float = parameter("m", 0.0, 20.0, "joint to their centre of mass, where they are a point")
    rotator_length: float = parameter("m", 0.01, 20.0, "joint to the grapple's upper end")
    grapple_centre: float = parameter("m", 0.0, 20.0, "grapple's upper end to its centre of mass")
    grapple_inertia: float = parameter(
        "kg*m2", 0.0, 1e6, "grapple's inertia about its centre, across its axis"
    )
    grip: float = parameter("m", 0.0, 5.0, "grapple's upper end to the centre of a log that it holds")
    damping: float = parameter("N*m*s/rad", 0.0, 1e6, "viscous damping of each of the joint's axes")

    def __post_init__(self) -> None:
        """Check ranges, and that the rotator's centre is within the rotator."""
        super().__post_init__()
        require_order("rotator_centre", self.rotator_centre, "rotator_length", self.rotator_length, "m")

    def require_compact(self, head_mass: float) -> None:
        """Check that the rotator is lighter than the head [kg], and that the grapple's mass lies within it.

        Raises:
            MachineError: otherwise.
        """
        if self.rotator_mass >= head_mass:
            raise MachineError(
                f"pendulum.rotator_mass ({self.rotator_mass:g} kg) must be smaller than head_mass "
                f"({head_mass:g} kg): the head is rotator and grapple together"
            )
        _require_compact("grapple_inertia", self.grapple_inertia, head_mass - self.rotator_mass)


def _require_compact(name: str, inertia: float, mass: float) -> None:
    radius, most = math.sqrt(inertia / mass), mass * WIDEST * WIDEST
    if radius > WIDEST:
        raise MachineError(
            f"pendulum.{name} ({inertia:g} kg*m2): {mass:g} kg would lie {radius:.3g} m from their centre; "
            f"allowed: at most {most:g} kg*m2, {WIDEST:g} m"
        )
