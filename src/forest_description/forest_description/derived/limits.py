"""How far the crane goes: joint angles from the cylinders' strokes, and the workspace that follows from them.

Symbols:
    q2, q3  boom and stick angle [rad]
    r       distance of the tip from the swing axis, negative behind it [m]
    z       height of the tip above the boom pivot [m]
"""

import math
from typing import NamedTuple

from forest_description.geometry.kinematics import Links, inverse_kinematics, tip_position
from forest_description.machine import Machine
from forest_description.types import AXES, Vec3

Interval = tuple[float, float]
THESIS_START: Vec3 = (5.5, 0.0, 1.0)
"""Where the sessions of Thesis section 5.2 begin, the tip [m]."""


class WorkspaceLimits(NamedTuple):
    """Extremes of the tip over all allowed joint angles [m]."""

    reach_min: float
    reach_max: float
    height_min: float
    height_max: float


def joint_limits(machine: Machine) -> tuple[Interval, Interval, Interval]:
    """Return ((lower, upper), …) of swing, boom, stick [rad]; boom and stick at their strokes' ends."""
    return (
        (machine.swing.lower_limit, machine.swing.upper_limit),
        machine.boom.angles,
        machine.stick.angles,
    )


def pose_at(tip: Vec3, machine: Machine) -> Vec3:
    """Return the joint angles (swing, boom, stick) [rad] that put the tip at a place.

    Args:
        tip: Tip position (x, y, z) [m].
        machine: Whose links and limits count.

    Raises:
        ValueError: The tip is out of reach, or a joint would have to leave its limits; the text
            says which.
    """
    angles = inverse_kinematics(tip, machine.manipulator.links)
    for name, angle, limits in zip(AXES, angles, joint_limits(machine), strict=True):
        if not limits[0] <= angle <= limits[1]:
            needed, low, high = (f"{math.degrees(a):.1f}" for a in (angle, *limits))
            raise ValueError(f"it needs the {name} at {needed} deg; allowed: {low} .. {high} deg")
    return angles


def start_tip(machine: Machine) -> Vec3:
    """Return where a session begins unless somebody says otherwise, the tip [m].

    That is the start of Thesis section 5.2 if the machine reaches it, or else where boom and stick
    are in the middle of their ranges (of the stick's, what is folded) and the swing is straight
    ahead, or as near to that as it goes.
    """
    try:
        pose_at(THESIS_START, machine)
    except ValueError:
        (right, left), boom, (low, high) = joint_limits(machine)
        ahead, folded = max(right, min(left, 0.0)), 0.5 * (max(low, -math.pi) + min(high, 0.0))
        return tip_position((ahead, 0.5 * sum(boom), folded), machine.manipulator.links)
    return THESIS_START


def workspace_limits(machine: Machine) -> WorkspaceLimits:
    """Return the least and greatest reach r and height z of the tip within the joint limits.

    Exact: r and z are sines of q2 and q3, so their extremes lie at corners of the box of angles or
    where a derivative along an edge (or both, with the stick straight or folded flat) is zero; all
    these angles are tried. The ground is not known here: the least reach of the c180 belongs to a
    tip folded back under the boom, 4.1 m below its pivot.
    """
    links = machine.manipulator.links
    _, boom, stick = joint_limits(machine)
    poses = [(q2, q3) for q2 in boom for q3 in [*stick, *_quarter_turns(-q2, stick)]]
    for q3 in [*stick, *_quarter_turns(0.0, stick)]:
        poses += [(q2, q3) for q2 in _quarter_turns(-_tip_direction(q3, links), boom)]
    tips = [tip_position((0.0, q2, q3), links) for q2, q3 in poses]
    reaches, heights = [tip[0] for tip in tips], [tip[2] for tip in tips]
    return WorkspaceLimits(min(reaches), max(reaches), min(heights), max(heights))


def _tip_direction(q3: float, links: Links) -> float:
    """Return the angle at the boom pivot between the boom and the line to the tip [rad]."""
    return math.atan2(links.stick * math.sin(q3), links.boom + links.stick * math.cos(q3))


def _quarter_turns(start: float, interval: Interval) -> list[float]:
    """Return all start + k π/2 inside an interval [rad]."""
    quarter = 0.5 * math.pi
    first = math.ceil((interval[0] - start) / quarter)
    last = math.floor((interval[1] - start) / quarter)
    return [start + k * quarter for k in range(first, last + 1)]
