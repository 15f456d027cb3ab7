"""The control schemes of Thesis fig. 5.2 and the one of ours, each a chain of the block diagram's blocks.

    scheme                 the tip velocity x' becomes           and the servo makes of it
    joint                  a, from the levers themselves         u = a
    (a) ik_velocity        r = IK(x_d), x_d = ∫x'; a = dr/dt      u = K_v (K* a - v)
    (b) ik_position        r = IK(x_d), x_d = ∫x'                 u = K_p (r - s) - K_d v
    (c) jacobian_velocity  a = J^-1(s) x'                        u = K_v (K* a - v)
    (d) jacobian_position  a = J^-1 x', r = ∫a                    u = K_p (r - s) - K_d v
    coordinated            a = J^-1(r) x', r = ∫a                 u = a + T b + K_p (r - s) + D (a - v) + w

| symbol | name | unit |
|---|---|---|
| x', x_d | reference velocity of the tip; its integral | m/s, m |
| a, b | reference joint rate, its rate of change | rad/s, rad/s^2 |
| r | reference angle; FK(r) is x_d, so that all schemes remember the same | rad |
| s, v | measured joint angle, rate | rad, rad/s |
| u | commanded joint rate, to the valve driver | rad/s |
| K* | pre-loop gain, 1 / (closed-loop gain at rest) | |
| K_v | velocity servo gain | |
| K_p, K_d | position servo gains | 1/s, 1 |
| T | lead: what spool, hoses and sampling lag behind the command | s |
| D | rate feedback: damps what rocks on its hoses; fades out where a changes sign | 1 |
| w | integral of K_i (r - s) | rad/s |

The thesis writes its servos around a plant v' = -w_n v + k u. Here the driver makes the plant's
gain one: u is a rate, and the machine settles at it. So the servos' W_0/k is one and K* = (1 +
K_v)/K_v.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from forest_description.geometry.kinematics import Links, is_singular, joint_rates, nearest_pose, tip_position
from forest_description.types import ZERO, Vec3

FADED = 1e-3  # [rad/s] of an offset that counts as none: it would only keep a valve open
ERROR_LAG = 0.05  # [s] low-pass of error and of a joint's going: over a quarter of a period at 8 Hz
FULL_RATE = 0.1  # [rad/s] reference rate from which D acts in full: slower, noise of v crosses the overlap
REST_RATE = 2e-3  # [rad/s] reference rate that counts as none for a velocity servo: above sensor noise


class Scheme(IntEnum):
    """How a command becomes joint rates."""

    JOINT = 0
    IK_VELOCITY = 1
    IK_POSITION = 2
    JACOBIAN_VELOCITY = 3
    JACOBIAN_POSITION = 4
    COORDINATED = 5

    @property
    def label(self) -> str:
        """The name that users type."""
        return self.name.lower()


LABELS = tuple(scheme.label for scheme in Scheme)


def scheme_named(label: str) -> Scheme:
    """Return the scheme that users call so, one of `LABELS`."""
    return Scheme(LABELS.index(label))


class Gains(NamedTuple):
    """Servo gains of one joint."""

    velocity: float  # K_v
    position: float  # K_p [1/s] of schemes (b), (d)
    damping: float  # K_d
    feedback: float  # K_p [1/s] of the coordinated scheme
    lead_time: float  # T [s]
    rate: float = 0.0  # D, beyond `FULL_RATE`


class Signals(NamedTuple):
    """What reaches one joint's servo."""

    a: float
    b: float
    r: float
    s: float
    v: float
    w: float


def joint(x: Signals, g: Gains) -> float:  # noqa: ARG001  one signature for all
    """Conventional control: each lever commands its joint's rate, open loop. Thesis section 5.1."""
    return x.a


def velocity_servo(x: Signals, g: Gains) -> float:
    """Schemes (a) and (c): u = K_v (K* a - v).

    Thesis section 5.2, fig. 5.2, 5.3.
    """
    pre_loop_gain = (1.0 + g.velocity) / g.velocity
    return g.velocity * (pre_loop_gain * x.a - x.v)


def position_servo(x: Signals, g: Gains) -> float:
    """Schemes (b) and (d): u = K_p (r - s) - K_d v, with K* = 1.

    Thesis section 5.2, fig. 5.2, 5.3.
    """
    return g.position * (x.r - x.s) - g.damping * x.v


def coordinated(x: Signals, g: Gains) -> float:
    """Reference velocity with lead, closed on the tip's position: u = a + T b + K_p (r - s) + D (a - v) + w.

    The reference rate is fed forward with the lead T; the feedback only corrects errors of valve
    and model. r is the pose that holds the tip on its path, so an error of the tip is one of the
    joints. Near a change of sign D fades out: the noise of v would throw the valve across its
    overlap and back.
    """
    damping = g.rate * motion_weight(x.a)
    return x.a + g.lead_time * x.b + g.feedback * (x.r - x.s) + damping * (x.a - x.v) + x.w


def motion_weight(a: float) -> float:
    """Return (a/`FULL_RATE`)^2 of a reference rate [rad/s], at most 1: 0 in slow motion, 1 beyond it."""
    part = a / FULL_RATE
    return min(1.0, part * part)


def servo(scheme: int, x: Signals, g: Gains) -> float:
    """Return u [rad/s] of a scheme for one joint."""
    if scheme == Scheme.COORDINATED:
        return coordinated(x, g)
    if scheme == Scheme.IK_POSITION or scheme == Scheme.JACOBIAN_POSITION:
        return position_servo(x, g)
    if scheme == Scheme.IK_VELOCITY or scheme == Scheme.JACOBIAN_VELOCITY:
        # At rest the servo would follow the motion of its own valve's opening, for ever.
        return velocity_servo(x, g) if abs(x.a) > REST_RATE else 0.0
    return joint(x, g)


def closes_on_position(scheme: int) -> bool:
    """Tell whether a scheme holds the machine at its reference."""
    return scheme == Scheme.IK_POSITION or scheme == Scheme.JACOBIAN_POSITION or scheme == Scheme.COORDINATED


def jacobian_pose(scheme: int, r: Vec3, s: Vec3, at_joints: bool) -> Vec3:
    """Return the pose [rad] at which a scheme takes J^-1.

    Args:
        scheme: whose.
        r: reference angles.
        s: measured angles.
        at_joints: scheme (d) takes it at the measured angles, as the thesis does. At its reference,
            it integrates the command free of the joints' lag.
    """
    measured = scheme == Scheme.JOINT or scheme == Scheme.JACOBIAN_VELOCITY
    return s if measured or (at_joints and scheme == Scheme.JACOBIAN_POSITION) else r


def advanced(scheme: int, r: Vec3, a: Vec3, velocity: Vec3, links: Links, dt: float) -> Vec3:
    """Return the reference angles r [rad] one step on.

    Args:
        scheme: (a) and (b) solve the inverse kinematics of the tip, the others integrate the rates.
        r: reference angles before.
        a: reference joint rates [rad/s].
        velocity: x' [m/s].
        links: lengths of the chain.
        dt: [s].
    """
    if scheme == Scheme.IK_VELOCITY or scheme == Scheme.IK_POSITION:
        if velocity == ZERO:
            return r  # exactly
        x, y, z = tip_position(r, links)
        target = x + dt * velocity[0], y + dt * velocity[1], z + dt * velocity[2]
        return nearest_pose(target, r, links)
    if scheme == Scheme.COORDINATED:
        # The rates half a step on: the tip's reference then stays on the integral of its velocity.
        middle = moved(r, a, 0.5 * dt)
        if not (is_singular(r, links) or is_singular(middle, links)):
            a = joint_rates(middle, velocity, links)
    return moved(r, a, dt)


def moved(q: Vec3, rates: Vec3, dt: float) -> Vec3:
    """Return angles [rad] moved on at rates [rad/s]."""
    return q[0] + dt * rates[0], q[1] + dt * rates[1], q[2] + dt * rates[2]


def reference_for_rate(scheme: int, u: float, s: float, v: float, g: Gains) -> float:
    """Return the reference angle r [rad] at which a scheme commands u [rad/s] at rest, or s if none does."""
    if scheme == Scheme.COORDINATED:
        return s + u / g.feedback if g.feedback > 0.0 else s
    if closes_on_position(scheme) and g.position > 0.0:
        return s + (u + g.damping * v) / g.position
    return s


def decayed(offset: float, dt: float, time: float) -> float:
    """Return what is left of an offset after dt [s] of an exponential decay."""
    return offset * math.exp(-dt / time) if abs(offset) > FADED else 0.0
