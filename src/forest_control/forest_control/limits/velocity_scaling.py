"""Velocity scaling: what the machine can and may do, applied to all joint rates at once.

One factor scales all rates together, so the tip slows down but keeps its direction. Motion away
from a limit is never slowed.

| symbol | name | unit |
|---|---|---|
| a | commanded joint rates | rad/s |
| k | approach rate: allowed speed towards a limit per angle (swing) or stroke left | 1/s |
| alpha | the factor, 0..1 | |
| x | length of a cylinder, pin to pin; its lever arm is dx/dq | m |
| Q, A | flow of the pumps; area of an actuator's inlet (per angle: oil of the motor) | m^3/s; m^2, m^3/rad |
| r | distance of the tip from the swing axis, negative behind it | m |

Two singular places are kept like limits: the swing axis (no swing moves the tip sideways there),
and a stick that is straight or folded flat; the latter bounds the stick's angles.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from forest_control.limits.workspace import NEGLIGIBLE_SPEED
from forest_description.derived.actuator_kinematics import Linkages
from forest_description.geometry.kinematics import Links
from forest_description.geometry.linkage import Linkage, length_and_arm, lever_arm, linkage_of
from forest_description.types import Vec3

NEGLIGIBLE_RATE = 1e-6  # [rad/s] up to this a joint does not count as moving: rounding must not stop others
LEAST_ARM = 1e-3  # [m] of a cylinder's lever: beyond its dead point a linkage turns the other way
CREEP = 2e-3  # [rad/s] no slower towards a limit: the joint arrives, and its valve can shut
FAR_OFF = 2.5  # [1] times the command: a joint limit that allows more has no effect; chosen
REACH_APPROACH = 2.0  # [1/s] k for the swing axis: that of boom and stick


class Limit(IntEnum):
    """What scales the command down."""

    NONE = 0
    RATE = 1
    JOINT = 2
    SINGULARITY = 3
    FLOW = 4  # of the pumps
    WALL = 5  # of the workspace
    RELEASED = 6  # the deadman is released, or the joystick is lost
    LOAD = 7  # of the crane: what the motion would load further
    OVERLOAD = 8  # a joint went back, or stood, though its valve was open: until the levers are armed anew
    LATE = 9  # the joystick's link is late: the levers are slower


class Pumps(NamedTuple):
    """What the pumps give, and what the actuators take."""

    limit: float  # Q [m^3/s]
    extending: Vec3  # A at port 1
    retracting: Vec3  # A at port 2
    linkages: Linkages


class Stroke(NamedTuple):
    """The allowed lengths of a cylinder; an empty stroke stands for a joint without cylinder."""

    linkage: Linkage
    shortest: float  # x [m] at one of its joint's limits, margin included
    longest: float  # [m] at the other


class Axis(NamedTuple):
    """How near the swing axis the tip may come."""

    links: Links
    closest: float  # [m]; not positive: as near as it likes


_NO_LINKAGE = linkage_of(2.0, 1.0, 0.0)  # its cylinder has a length at any angle
ENOUGH = Pumps(math.inf, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (_NO_LINKAGE, _NO_LINKAGE))
NO_STROKE = Stroke(_NO_LINKAGE, 0.0, 0.0)
NO_AXIS = Axis(Links(0.0, 1.0, 1.0), 0.0)


class VelocityLimits(NamedTuple):
    """Limits per joint, swing, boom, stick."""

    lower: Vec3  # [rad], margin included
    upper: Vec3  # [rad], margin included
    rates: Vec3  # [rad/s]
    approach: Vec3  # [1/s]
    pumps: Pumps
    axis: Axis
    strokes: tuple[Stroke, Stroke, Stroke] = (NO_STROKE, NO_STROKE, NO_STROKE)


class VelocityScaling(NamedTuple):
    """The factor, and the limit that set it."""

    factor: float
    limit: Limit


def velocity_scaling(angles: Vec3, rates: Vec3, p: VelocityLimits) -> VelocityScaling:
    """Return the factor 0..1 for all joint rates [rad/s] at joint angles [rad], and what sets it."""
    scaling = VelocityScaling(1.0, Limit.NONE)
    for joint in range(3):
        rate = rates[joint]
        if abs(rate) <= NEGLIGIBLE_RATE:
            continue
        room = p.upper[joint] - angles[joint] if rate > 0.0 else angles[joint] - p.lower[joint]
        towards_limit = p.approach[joint] * _way_left(room, angles[joint], rate > 0.0, p.strokes[joint])
        if towards_limit < CREEP:
            towards_limit = 0.0
        scaling = _at_most(scaling, p.rates[joint], abs(rate), Limit.RATE)
        scaling = _at_most(scaling, _softened(towards_limit, abs(rate)), abs(rate), Limit.JOINT)
    scaling = _at_most(scaling, p.pumps.limit, flow_demand(angles, rates, p.pumps), Limit.FLOW)
    if p.axis.closest <= 0.0:
        return scaling
    reach, inward = _towards_axis(angles, rates, p.axis.links)
    if inward <= NEGLIGIBLE_SPEED:
        return scaling
    allowed = max(0.0, REACH_APPROACH * (reach - p.axis.closest))
    return _at_most(scaling, allowed, inward, Limit.SINGULARITY)


def _way_left(room: float, angle: float, extends: bool, stroke: Stroke) -> float:
    """Return the stroke that is left of a cylinder, over its lever arm [rad].

    A cylinder slows down by its own stroke: x' = k (x_end - x). In angles alone it would come too
    fast to an end near its dead point, where little stroke turns the joint far.

    Args:
        room: angle to the joint's limit [rad], which counts for a joint without cylinder.
        angle: of the joint [rad].
        extends: the joint is commanded upwards; its cylinder extends.
        stroke: of its cylinder.
    """
    if stroke.longest <= stroke.shortest:
        return room
    length, arm = length_and_arm(math.cos(angle), math.sin(angle), stroke.linkage)
    if arm <= LEAST_ARM:
        return room  # beyond its dead point a linkage turns the other way
    return (stroke.longest - length if extends else length - stroke.shortest) / arm


def _softened(allowed: float, rate: float) -> float:
    """Return a rate [rad/s] below both, without the corner that would make the crane rock."""
    ratio = allowed / rate
    if ratio >= FAR_OFF:
        return allowed
    # The cubic from (0, 0), slope 1, to (FAR_OFF, 1), slope 0.
    square = (2.0 * FAR_OFF - 3.0) / (FAR_OFF * FAR_OFF)
    cube = (2.0 * square * FAR_OFF - 1.0) / (3.0 * (FAR_OFF * FAR_OFF))
    return rate * (ratio - square * ratio * ratio + cube * ratio * ratio * ratio)


def _at_most(scaling: VelocityScaling, allowed: float, asked: float, limit: Limit) -> VelocityScaling:
    """Return the smaller of a factor and the one that leaves what is allowed of what is asked for."""
    if allowed < scaling.factor * asked:
        return VelocityScaling(allowed / asked, limit)
    return scaling


def flow_demand(q: Vec3, rates: Vec3, pumps: Pumps) -> float:
    """Return the flow [m^3/s] that joint rates [rad/s] take at joint angles [rad]: sum of A |v|."""
    boom = lever_arm(q[1], pumps.linkages[0]) * rates[1]
    stick = lever_arm(q[2], pumps.linkages[1]) * rates[2]
    return _inlet(rates[0], 0, pumps) + _inlet(boom, 1, pumps) + _inlet(stick, 2, pumps)


def _inlet(speed: float, i: int, pumps: Pumps) -> float:
    return speed * pumps.extending[i] if speed > 0.0 else -speed * pumps.retracting[i]


def _towards_axis(q: Vec3, rates: Vec3, links: Links) -> tuple[float, float]:
    """Return |r| [m] and how fast it shrinks [m/s]."""
    c_23, s_23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    r = links.base_offset + links.boom * math.cos(q[1]) + links.stick * c_23
    outward = -links.boom * math.sin(q[1]) * rates[1] - links.stick * s_23 * (rates[1] + rates[2])
    return abs(r), -math.copysign(outward, outward * r) if outward != 0.0 else 0.0
