"""The column that twists, boom and stick that bend: their roots between actuators and links.

An actuator, its cylinder's geometry and the joint's sensors are the root's; the masses are the
link's. A machine whose links are rigid has none of this: `PlantParameters.elastic.present` is 0.
"""

from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.mechanics.elasticity import RIGID, ElasticLink, elastic_torque


class RootState(NamedTuple):
    """A link's root; also holds its time derivative. All 0 where the link is rigid."""

    angle: float  # [rad]
    rate: float  # [rad/s]


class Roots(NamedTuple):
    """The roots of all links."""

    swing: RootState
    boom: RootState
    stick: RootState


class ElasticLaws(NamedTuple):
    """How the links give way."""

    present: int  # 0: all are rigid
    swing: ElasticLink
    boom: ElasticLink
    stick: ElasticLink

    @property
    def links(self) -> tuple[ElasticLink, ElasticLink, ElasticLink]:
        """The laws in the order of `AXES`."""
        return (self.swing, self.boom, self.stick)


class Bent(NamedTuple):
    """What elastic links make of their actuators' torques."""

    torques: Vec3  # on the links [N m]
    rates: Roots  # time derivatives


class BendingPower(NamedTuple):
    """What an elastic link takes of its actuator's power [W]."""

    lost: float
    elastic: float  # stored in link and root


NO_ROOT = RootState(0.0, 0.0)
RIGID_ROOTS = Roots(NO_ROOT, NO_ROOT, NO_ROOT)
RIGID_LINKS = ElasticLaws(0, RIGID, RIGID, RIGID)
NO_BENDING = BendingPower(0.0, 0.0)


def bent(roots: Roots, angles: Vec3, rates: Vec3, torques: Vec3, laws: ElasticLaws) -> Bent:
    """Return the torques on the links and the roots' derivatives.

    Args:
        roots: their state.
        angles: of the links [rad].
        rates: of the links [rad/s].
        torques: of the actuators on the roots [N m].
        laws: the constants.
    """
    swing = _through(roots.swing, angles[0], rates[0], torques[0], laws.swing)
    boom = _through(roots.boom, angles[1], rates[1], torques[1], laws.boom)
    stick = _through(roots.stick, angles[2], rates[2], torques[2], laws.stick)
    return Bent((swing[0], boom[0], stick[0]), Roots(swing[1], boom[1], stick[1]))


def _through(
    root: RootState, angle: float, rate: float, torque: float, link: ElasticLink
) -> tuple[float, RootState]:
    if link.inertia == 0.0:
        return torque, NO_ROOT
    passed = elastic_torque(root.angle - angle, root.rate - rate, link)
    return passed, RootState(root.rate, (torque - passed) / link.inertia)


def bending_power(
    root: RootState, angle: float, rate: float, torque: float, link: ElasticLink
) -> BendingPower:
    """Return what a link takes of its actuator's power.

    Args:
        root: its state.
        angle: of the link [rad].
        rate: of the link [rad/s].
        torque: of the actuator on the root [N m].
        link: the constants.
    """
    if link.inertia == 0.0:
        return NO_BENDING
    deflection, speed = root.angle - angle, root.rate - rate
    passed = elastic_torque(deflection, speed, link)
    stored = link.stiffness * deflection * speed + root.rate * (torque - passed)
    return BendingPower(link.damping * speed * speed, stored)


def bending_energy(root: RootState, angle: float, link: ElasticLink) -> float:
    """Return the energy [J] in a link's bending and in its root, at an angle of the link [rad]."""
    if link.inertia == 0.0:
        return 0.0
    deflection = root.angle - angle
    return 0.5 * (link.inertia * root.rate**2 + link.stiffness * deflection**2)
