"""What the operator's hand asks for: stick curves, axis frames, and the manual modes of Thesis section 5.1.

| symbol | name | unit |
|---|---|---|
| d | a lever's deflection, -1..1 | |
| z, d_0 | what is left of it beyond the deadzone, 0..1; the deadzone | |
| e | expo: how much of the curve is cubic | |
| x', x_c | wished velocity of the tip; the clutch point | m/s, m |

Curve: z = (|d| - d_0)/(1 - d_0), then sgn(d) z (1 - e (1 - z^2)): continuous, monotone, 0 and 1 exact.

Rate mode: a deflection is a speed. Position mode: a deflection is a place of the tip (in the joint scheme, of
each joint) about the clutch point, which is where the machine was when the deadman was pressed or the mode
entered. It is followed at limited speed and acceleration, so the mode may change at any moment.

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

FOLLOWING = 3.0  # [1/s] speed per distance left in position mode
ARRIVED = 2e-4  # [m] from where the tip shall be: it is there; for a joint a tenth of it in rad
JOINT_ACCELERATION = 1.0  # [rad/s^2] of the joint scheme in position mode


class Mode(IntEnum):
    """What a deflection means."""

    RATE = 0
    POSITION = 1


class Frame(IntEnum):
    """Along what the tip's axes lie."""

    CARTESIAN = 0
    CYLINDRICAL = 1


class Hand(NamedTuple):
    """An operator's profile; triples by lever: swing, boom, stick."""

    mode: int  # a `Mode`
    frame: int  # a `Frame`
    deadzone: Vec3
    expo: Vec3
    speeds: Vec3  # [m/s] of the tip at full deflection
    tip_span: float  # [m] of the tip about the clutch point at full deflection
    joint_span: Vec3  # [rad] of the joints about it


def shaped(levers: Levers, h: Hand) -> Levers:
    """Return the deflections behind the stick curves."""
    return Levers(
        curve(levers.swing, h.deadzone[0], h.expo[0]),
        curve(levers.boom, h.deadzone[1], h.expo[1]),
        curve(levers.stick, h.deadzone[2], h.expo[2]),
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
    """Return the vector (x, y, z) of components along the levers' directions, the crane swung to an angle."""
    if frame == Frame.CARTESIAN:
        return stick, swing, boom
    c, s = math.cos(angle), math.sin(angle)
    return c * stick - s * swing, s * stick + c * swing, boom


def tip_rate(levers: Levers, pose: Vec3, h: Hand) -> Vec3:
    """Return the tip velocity [m/s] that shaped levers wish in rate mode. Thesis section 5.1."""
    v = h.speeds
    return along(v[0] * levers.swing, v[1] * levers.boom, v[2] * levers.stick, pose[0], h.frame)


def tip_following(levers: Levers, clutch: Vec3, pose: Vec3, h: Hand, links: Links) -> Vec3:
    """Return the tip velocity [m/s] towards what shaped levers wish in position mode. Thesis section 5.1.

    Args:
        levers: shaped.
        clutch: joint angles at the clutch point [rad].
        pose: joint angles now [rad].
        h: the profile.
        links: lengths of the chain.
    """
    span = h.tip_span
    way = along(span * levers.swing, span * levers.boom, span * levers.stick, clutch[0], h.frame)
    at, here = tip_position(clutch, links), tip_position(pose, links)
    x, y, z = at[0] + way[0] - here[0], at[1] + way[1] - here[1], at[2] + way[2] - here[2]
    distance = math.sqrt(x * x + y * y + z * z)
    if distance < ARRIVED:
        return ZERO
    speed = min(h.speeds[0], h.speeds[1], h.speeds[2], FOLLOWING * distance) / distance
    return speed * x, speed * y, speed * z


def joint_following(levers: Levers, clutch: Vec3, angles: Vec3, h: Hand, rates: Vec3) -> Vec3:
    """Return the joint rates [rad/s] towards what shaped levers wish in position mode, at most `rates`."""
    span = h.joint_span
    return (
        _towards(clutch[0] + span[0] * levers.swing - angles[0], rates[0]),
        _towards(clutch[1] + span[1] * levers.boom - angles[1], rates[1]),
        _towards(clutch[2] + span[2] * levers.stick - angles[2], rates[2]),
    )


def _towards(left: float, rate: float) -> float:
    return 0.0 if abs(left) < 0.1 * ARRIVED else max(-rate, min(rate, FOLLOWING * left))
