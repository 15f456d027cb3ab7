"""The operator profile: stick curves, axis frames, and the manual modes of Thesis section 5.1.

| symbol | name | unit |
|---|---|---|
| d | a lever's deflection, -1..1 | |
| z, d_0 | what is left of it beyond the deadzone, 0..1; the deadzone | |
| e | expo: how much of the curve is cubic | |
| x', x_c | commanded velocity of the tip; the clutch point | m/s, m |

Curve: z = (|d| - d_0)/(1 - d_0), then sgn(d) z (1 - e (1 - z^2)): continuous, monotone, 0 and 1
exact.

Rate mode: a deflection is a speed. Position mode: a deflection is a place of the tip about the
clutch point; in the joint scheme, of each joint. The clutch point is where the machine was when the
deadman was pressed or the mode entered. The place is approached at limited speed and acceleration,
so the mode may change at any moment.

Levers are ordered as joints are: swing, boom, stick. Their directions of the tip:

| axis frame | swing | boom | stick |
|---|---|---|---|
| Cartesian | y, left | z, up | x, ahead |
| cylindrical | along the swing's circle, left | up | outwards |
"""

import math
from enum import IntEnum
from typing import NamedTuple

from forest_control.operator.levers import Levers
from forest_description.geometry.kinematics import Links, tip_position
from forest_description.types import ZERO, Vec3

APPROACH_RATE = 3.0  # [1/s] speed per distance left in position mode: chosen; not measured
ARRIVED = 2e-4  # [m] distance at which the tip has arrived: below the 1 mm that resolvers tell
JOINT_ARRIVED = 0.1 * ARRIVED  # [rad] the same for a joint: 0.1 mm at 6 m
JOINT_ACCELERATION = 1.0  # [rad/s^2] of the joint scheme in position mode: chosen; not measured


class Mode(IntEnum):
    """What a deflection means."""

    RATE = 0
    POSITION = 1


class Frame(IntEnum):
    """Along what the tip's axes lie."""

    CARTESIAN = 0
    CYLINDRICAL = 1


class OperatorProfile(NamedTuple):
    """An operator's profile; triples by lever: swing, boom, stick."""

    mode: int  # a `Mode`
    frame: int  # a `Frame`
    deadzone: Vec3
    expo: Vec3
    speeds: Vec3  # [m/s] of the tip at full deflection
    tip_span: float  # [m] of the tip about the clutch point at full deflection
    joint_span: Vec3  # [rad] of the joints about it


def shaped(levers: Levers, profile: OperatorProfile) -> Levers:
    """Return the deflections behind the stick curves."""
    return Levers(
        curve(levers.swing, profile.deadzone[0], profile.expo[0]),
        curve(levers.boom, profile.deadzone[1], profile.expo[1]),
        curve(levers.stick, profile.deadzone[2], profile.expo[2]),
    )


def curve(deflection: float, deadzone: float, expo: float) -> float:
    """Return sgn(d) z (1 - e (1 - z^2)), -1..1.

    Args:
        deflection: d.
        deadzone: d_0, 0 up to below 1.
        expo: e, 0 (straight) to 1 (cubic).
    """
    z = min(1.0, max(0.0, (abs(deflection) - deadzone) / (1.0 - deadzone)))
    return math.copysign(z * (1.0 - expo * (1.0 - z * z)), deflection)


def along(swing: float, boom: float, stick: float, angle: float, frame: int) -> Vec3:
    """Return (x, y, z) of components along the levers' directions, the crane swung to an angle [rad]."""
    if frame == Frame.CARTESIAN:
        return stick, swing, boom
    c, s = math.cos(angle), math.sin(angle)
    return c * stick - s * swing, s * stick + c * swing, boom


def rate_mode_velocity(levers: Levers, pose: Vec3, profile: OperatorProfile) -> Vec3:
    """Return the tip velocity [m/s] of shaped levers in rate mode. Thesis section 5.1."""
    v = profile.speeds
    return along(v[0] * levers.swing, v[1] * levers.boom, v[2] * levers.stick, pose[0], profile.frame)


def position_mode_velocity(
    levers: Levers, clutch: Vec3, pose: Vec3, profile: OperatorProfile, links: Links
) -> Vec3:
    """Return the tip velocity [m/s] towards the place of shaped levers in position mode. Thesis section 5.1.

    Args:
        levers: shaped.
        clutch: joint angles at the clutch point [rad].
        pose: joint angles now [rad].
        profile: the operator's.
        links: lengths of the chain.
    """
    span = profile.tip_span
    way = along(span * levers.swing, span * levers.boom, span * levers.stick, clutch[0], profile.frame)
    at, here = tip_position(clutch, links), tip_position(pose, links)
    x, y, z = at[0] + way[0] - here[0], at[1] + way[1] - here[1], at[2] + way[2] - here[2]
    distance = math.sqrt(x * x + y * y + z * z)
    if distance < ARRIVED:
        return ZERO
    speed = min(profile.speeds[0], profile.speeds[1], profile.speeds[2], APPROACH_RATE * distance) / distance
    return speed * x, speed * y, speed * z


def position_mode_rates(
    levers: Levers, clutch: Vec3, angles: Vec3, profile: OperatorProfile, rates: Vec3
) -> Vec3:
    """Return the joint rates [rad/s], at most `rates`, towards the angles of levers in position mode."""
    span = profile.joint_span
    return (
        _towards(clutch[0] + span[0] * levers.swing - angles[0], rates[0]),
        _towards(clutch[1] + span[1] * levers.boom - angles[1], rates[1]),
        _towards(clutch[2] + span[2] * levers.stick - angles[2], rates[2]),
    )


def _towards(left: float, rate: float) -> float:
    return 0.0 if abs(left) < JOINT_ARRIVED else max(-rate, min(rate, APPROACH_RATE * left))
