"""Joints that nothing drives: where the cylinders lie, for drawing, and how a head hangs from the stick.

The thesis gives a cylinder's linkage by two distances and an angle, and no drawing of it is left:
its two pivots may be turned about the joint together. Assumed: the rod's eye lies on the driven
link's own axis, and the whole angle φ is on the parent's side. Appendix A splits the boom's into
delta (platform, likely) and si2 (boom): the boom's eye is then drawn 10 mm too low, and nothing
else depends on it. So the boom's cylinder stands in front of the column, and the stick's lies under
the boom.

| symbol | name | unit |
|---|---|---|
| a, b | pivot_to_base, pivot_to_rod: from the joint to barrel's pivot, to rod's eye | m |
| φ | angle_offset | rad |
| q | joint angle | rad |

In the parent's frame at the joint, x along the parent and z up: barrel's pivot a (cos φ, -sin φ),
rod's eye b (cos q, sin q).
"""

import math
from typing import NamedTuple

import numpy as np

from forest_description.derived.limits import Interval, joint_limits
from forest_description.geometry.linkage import Linkage, cylinder_length
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3

CYLINDER_JOINTS = ("boom_cylinder_pivot", "boom_cylinder_rod", "stick_cylinder_pivot", "stick_cylinder_rod")
"""Joints of the URDF in the order of `cylinder_joint_positions`."""
HEAD_JOINTS = ("head_in_plane", "head_out_of_plane")
"""Joints of the URDF in the order of `head_joint_positions`; only with a pendulum."""


class Follower(NamedTuple):
    """A joint that moves with a driven one about as offset + multiplier q; it stays within the range."""

    offset: float
    multiplier: float
    interval: Interval


def barrel_pivot(linkage: Linkage) -> tuple[float, float]:
    """Return the barrel's pivot (along the parent, up) from the joint [m]. Thesis App. A."""
    a, offset = linkage.pivot_to_base, linkage.angle_offset
    return a * math.cos(offset), -a * math.sin(offset)


def cylinder_joint_positions(q: Vec3, machine: Machine) -> tuple[float, float, float, float]:
    """Return barrel angle [rad] and rod extension [m] of boom and stick, in the order of `CYLINDER_JOINTS`.

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        machine: For linkages and retracted lengths.
    """
    boom, stick = machine.boom, machine.stick
    return (
        _barrel_angle(q[1], boom.linkage),
        cylinder_length(q[1], boom.linkage) - boom.retracted_length,
        _barrel_angle(q[2], stick.linkage),
        cylinder_length(q[2], stick.linkage) - stick.retracted_length,
    )


def head_joint_positions(q: Vec3, angles: tuple[float, float]) -> tuple[float, float]:
    """Return the hanging head's joints [rad], in the order of `HEAD_JOINTS`; zero is along the stick's -z.

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        angles: α, β of the head from the platform's vertical [rad], as in
            ``forest_sim.mechanics.pendulum``.
    """
    return angles[0] - q[1] - q[2], angles[1]


def cylinder_followers(machine: Machine) -> tuple[Follower, Follower, Follower, Follower]:
    """Return the straight lines that come nearest to `cylinder_joint_positions` over the strokes.

    For viewers that know only swing, boom and stick: URDF can let a joint follow another one only
    linearly.
    """
    _, boom, stick = joint_limits(machine)
    boom_line = np.linspace(*boom, 101)
    stick_line = np.linspace(*stick, 101)
    positions = np.array(
        [
            cylinder_joint_positions((0.0, q2, q3), machine)
            for q2, q3 in zip(boom_line.tolist(), stick_line.tolist(), strict=True)
        ]
    )
    angles = (boom_line, boom_line, stick_line, stick_line)
    first, second, third, fourth = (_follower(x, y) for x, y in zip(angles, positions.T, strict=True))
    return first, second, third, fourth


def _follower(angle: Floats, position: Floats) -> Follower:
    """Return the least-squares line and what both it and the true position stay within."""
    multiplier, offset = np.polyfit(angle, position, 1)
    reached = np.concatenate([position, offset + multiplier * angle])
    return Follower(float(offset), float(multiplier), (float(reached.min()), float(reached.max())))


def _barrel_angle(angle: float, linkage: Linkage) -> float:
    """Return the cylinder's direction in the parent's frame, upwards positive [rad]."""
    x, z = barrel_pivot(linkage)
    b = linkage.pivot_to_rod
    return math.atan2(b * math.sin(angle) - z, b * math.cos(angle) - x)
