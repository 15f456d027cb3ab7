"""How far the vehicle is from tipping over, by the weights alone.

About each line through its wheels or legs the weights' moments are summed, of the vehicle, the crane and
what it carries. A margin is what holds less what tips, over what holds: 1 if nothing tips, 0 where the
wheels at the other side lift. The head hangs straight under the tip. Accelerations are left out: a load
that is let down and caught tips up to twice as much as one that rests.

A weight m g at r tips about a line at the distance d, whose outward normal is n, by

    m g [cos(lambda) (r . n - d) - sin(lambda) n_y h]

with lambda the platform's tilt about x, and h the height above the ground.
"""

import math
from typing import NamedTuple

from forest_description.mechanics.chassis import Chassis
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_description.types import Vec3

Pair = tuple[float, float]


class Margins(NamedTuple):
    """Of the lines ahead of the swing axis, at its left, behind it and at its right [1]."""

    ahead: float
    left: float
    behind: float
    right: float


class Weight(NamedTuple):
    """A part's mass [kg] and centre: ahead, to the left, above the ground [m]."""

    mass: float
    x: float
    y: float
    height: float


def tip_over_margins(chassis: Chassis, m: Manipulator, angles: Vec3, log: float) -> Margins:
    """Return the margins of a vehicle.

    Args:
        chassis: vehicle.
        m: the crane on it; a log that it holds counts as `log` says.
        angles: of swing, boom and stick [rad].
        log: mass in the head [kg].
    """
    vehicle = Weight(chassis.mass, chassis.centre_ahead, 0.0, chassis.centre_height)
    weights = vehicle, *_crane(chassis.pivot_height, m, angles, log)
    down, across = math.cos(m.platform_tilt), math.sin(m.platform_tilt)
    return Margins(
        ahead=_margin(weights, (1.0, 0.0), chassis.ahead, down, across),
        left=_margin(weights, (0.0, 1.0), chassis.half_width, down, across),
        behind=_margin(weights, (-1.0, 0.0), chassis.behind, down, across),
        right=_margin(weights, (0.0, -1.0), chassis.half_width, down, across),
    )


def _crane(pivot: float, m: Manipulator, angles: Vec3, log: float) -> tuple[Weight, ...]:
    """Return the weights of a crane whose boom's pivot is so high above the ground [m]."""
    swing, boom, pitch = angles[0], angles[1], angles[1] + angles[2]
    foot = m.base_offset, pivot
    elbow = _along(foot, boom, m.boom_length, 0.0)
    parts = (
        (m.base_mass, (m.base_x, pivot)),
        (m.boom_mass, _along(foot, boom, m.boom_x, m.boom_y)),
        (m.stick_mass, _along(elbow, pitch, m.stick_x, m.stick_y)),
        (m.head_mass + log, _along(elbow, pitch, m.stick_length, 0.0)),
    )
    x, y = math.cos(swing), math.sin(swing)
    return tuple(Weight(mass, x * reach, y * reach, height) for mass, (reach, height) in parts)


def _along(joint: Pair, slope: float, x: float, y: float) -> Pair:
    """Return reach and height [m] of a place on a link: x along it, y across."""
    c, s = math.cos(slope), math.sin(slope)
    return joint[0] + c * x - s * y, joint[1] + s * x + c * y


def _margin(weights: tuple[Weight, ...], normal: Pair, distance: float, down: float, across: float) -> float:
    holds = tips = 0.0
    for mass, x, y, height in weights:
        moment = mass * (down * (normal[0] * x + normal[1] * y - distance) - across * normal[1] * height)
        holds, tips = holds + max(0.0, -moment), tips + max(0.0, moment)
    return (holds - tips) / holds if holds > 0.0 else -math.inf
