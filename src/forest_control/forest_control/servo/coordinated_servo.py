"""The servo of the coordinated scheme: smooth reference, feedforward, integral, joints that hold.

| symbol | name | unit |
|---|---|---|
| x' | reference velocity of the tip | m/s |
| a, b | reference joint rates, their rate of change | rad/s, rad/s^2 |
| r, s | reference and measured joint angle | rad |
| w | integral of K_i (r - s) | rad/s |

The reference is the operator's command with its steps turned into ramps, so that b is finite. While
a joint's reference rests, even if others move, a joint that is near it holds: its valve stays shut
until the error has grown. Otherwise noise would move the valve through its overlap for ever. Where
all references rest, the joints are soon inched to their places (`inching`).

Boom and stick oscillate on their oil at some 8 Hz, which a valve that is open a little hardly
damps. An unfiltered position error feeds that oscillation in slow motion. Behind the low-pass of
`ERROR_LAG` the error lags by more than a quarter of a period, and damps. From `schemes.FULL_RATE` on the
valve itself damps, and the error acts unfiltered.
"""

import math
from typing import NamedTuple

from forest_control.servo.arm_feedforward import ArmModel, yielding_rates
from forest_control.servo.inching import ARRIVED, MOVING, Inching, inched, is_due, served
from forest_control.servo.link_bending import pushed
from forest_control.servo.schemes import ERROR_LAG, Gains, Signals, coordinated, motion_weight
from forest_control.servo.stalled_joints import JointMotion, is_ahead, is_slow, is_stalled, updated_motion
from forest_control.servo.swing_feedforward import SwingModel, inertia
from forest_description.derived.actuator_kinematics import Linkages, actuator_speeds_to_joint_rates
from forest_description.geometry.vectors import minus, norm, plus, scaled
from forest_description.types import ZERO, Vec3

REST_RATE = 1e-4  # [rad/s] a reference slower than this rests: 0.6 mm/s of the tip; chosen
HOLD_RATE = 1e-9  # [rad/s] command to a joint that holds: no motion, but the driver may feed its leakage
HIGHEST_ACCELERATION = 2.0  # [rad/s^2] of b: a jump of the velocity scaling must not kick the valves; chosen
MOST_SAMPLES = 50  # [1] in the mean pose that the reference starts from: 0.25 s at rest


class CoordinationParameters(NamedTuple):
    """Gains and bounds, per joint where triples: swing, boom, stick."""

    gains: tuple[Gains, Gains, Gains]
    integral: Vec3  # K_i [1/s^2]
    swing: SwingModel  # what is fed forward to it
    arm: ArmModel  # and to boom and stick
    load_bandwidth: float  # [rad/s] at which the valve driver learns a load
    smoothing: float  # [s] of b
    acceleration: float  # [m/s^2] of the tip's reference
    hold_error: float  # [rad] a resting joint this near holds
    release_error: float  # [rad] and moves again beyond this
    inches: Vec3  # [rad/s, m/s, m/s] speeds of the actuators while a resting joint is inched
    free_ways: Vec3  # [rad] of the gears
    linkages: Linkages


class Joint(NamedTuple):
    """One joint's state between steps."""

    a: float = 0.0  # [rad/s]
    b: float = 0.0  # [rad/s^2]
    w: float = 0.0  # [rad/s]
    error: float = 0.0  # r - s, low-passed [rad]
    holding: bool = True
    inching: Inching = MOVING
    motion: JointMotion = JointMotion()


AT_REST = Joint()


class Memory(NamedTuple):
    """State between steps."""

    velocity: Vec3  # x' [m/s]
    swing: Joint = AT_REST
    boom: Joint = AT_REST
    stick: Joint = AT_REST
    torque: float = 0.0  # [N m] of the swing, as far as the driver has learnt it
    samples: int = 0  # in the mean pose that the reference starts from


REST = Memory(ZERO)


def in_motion(velocity: Vec3, a: Vec3, samples: int) -> Memory:
    """Return the memory of a scheme that takes over at a tip velocity [m/s] and joint rates [rad/s]."""
    swing, boom, stick = Joint(a=a[0]), Joint(a=a[1]), Joint(a=a[2])
    return Memory(velocity=velocity, swing=swing, boom=boom, stick=stick, samples=samples)


def reference_rates(memory: Memory) -> Vec3:
    """Return the reference rates a [rad/s] of the last step."""
    return memory.swing.a, memory.boom.a, memory.stick.a


def with_velocity(memory: Memory, velocity: Vec3) -> Memory:
    """Return the memory with the tip's reference velocity [m/s], which ends the averaging of the pose."""
    return memory._replace(velocity=velocity, samples=MOST_SAMPLES)


def settle(reference: Vec3, s: Vec3, memory: Memory) -> tuple[Vec3, Memory]:
    """Return the pose [rad] to start from, the mean of noisy samples at rest, and the memory."""
    count = memory.samples + 1
    (r_1, r_2, r_3), (s_1, s_2, s_3) = reference, s
    q = r_1 + (s_1 - r_1) / count, r_2 + (s_2 - r_2) / count, r_3 + (s_3 - r_3) / count
    return q, memory._replace(samples=count)


def ramped(velocity: Vec3, target: Vec3, acceleration: float, dt: float) -> Vec3:
    """Return the reference velocity [m/s] after dt [s] on the way to a target, at most so accelerated."""
    change, most = minus(target, velocity), acceleration * dt
    size = norm(change)
    if size <= most:
        return target
    return plus(velocity, scaled(change, most / size))


def servo(
    memory: Memory,
    a: Vec3,
    r: Vec3,
    s: Vec3,
    v: Vec3,
    volts: Vec3,
    p: CoordinationParameters,
    dt: float,
) -> tuple[Memory, Vec3]:
    """Return the memory one step on, and the commanded joint rates u [rad/s].

    Args:
        memory: before.
        a: reference rates [rad/s].
        r: reference angles [rad].
        s: measured angles [rad].
        v: measured rates [rad/s].
        volts: that the valves were given last [V]; 0: shut.
        p: parameters.
        dt: [s].
    """
    m_1, m_2, m_3 = memory.swing, memory.boom, memory.stick
    still, stalled = rests(memory, a), all_stalled(memory, a)
    b_1, jerk = _smooth_acceleration(m_1, a[0], p, dt)
    b_2, jerk_2 = _smooth_acceleration(m_2, a[1], p, dt)
    b_3, jerk_3 = _smooth_acceleration(m_3, a[2], p, dt)
    inch = actuator_speeds_to_joint_rates(s, p.inches, p.linkages)
    m_11 = inertia(r, p.swing)
    s = minus(s, pushed(r, (b_1, b_2, b_3), m_11, p.swing.compliance, p.arm))
    torque, extra = _swing_forward(memory.torque, a[0], b_1, jerk, m_11, p, dt)
    yields = yielding_rates(r, a, (b_1, b_2, b_3), (jerk, jerk_2, jerk_3), p.arm)
    x_1 = Signals(a=a[0], b=b_1, r=r[0], s=s[0], v=v[0], w=extra)
    x_2 = Signals(a=a[1], b=b_2, r=r[1], s=s[1], v=v[1], w=_onwards(yields[0], a[1]))
    x_3 = Signals(a=a[2], b=b_3, r=r[2], s=s[2], v=v[2], w=_onwards(yields[1], a[2]))
    swing, u_1 = _joint_servo(m_1, x_1, volts[0] == 0.0, still, stalled, inch[0], 0, p, dt)
    boom, u_2 = _joint_servo(m_2, x_2, volts[1] == 0.0, still, stalled, inch[1], 1, p, dt)
    stick, u_3 = _joint_servo(m_3, x_3, volts[2] == 0.0, still, stalled, inch[2], 2, p, dt)
    memory = memory._replace(swing=swing, boom=boom, stick=stick, torque=torque)
    return memory, (u_1, u_2, u_3)


def _onwards(extra: float, a: float) -> float:
    """Return what is fed forward beside a rate a [rad/s]; it stops a valve at the most, and turns none round.

    A limit that takes effect at once would else throw the valve over its overlap.
    """
    return extra if extra * a >= 0.0 else math.copysign(min(abs(extra), abs(a)), extra)


def inches(memory: Memory) -> Vec3:
    """Return the rates [rad/s] at which joints at rest are inched."""
    return memory.swing.inching.rate, memory.boom.inching.rate, memory.stick.inching.rate


def rests(memory: Memory, a: Vec3) -> bool:
    """Tell whether all joints' reference rates [rad/s] are zero, in this step and in the last one."""
    m_1, m_2, m_3 = memory.swing, memory.boom, memory.stick
    return max(abs(a[0]), abs(a[1]), abs(a[2]), abs(m_1.a), abs(m_2.a), abs(m_3.a)) < REST_RATE


def _rests(memory: Joint, a: float) -> bool:
    """Tell whether one joint's reference rests, even if others move [rad/s]."""
    return max(abs(a), abs(memory.a)) < REST_RATE


def all_stalled(memory: Memory, a: Vec3) -> bool:
    """Tell whether all joints that shall go at reference rates a [rad/s] are stalled."""
    if is_slow(a[0]) and is_slow(a[1]) and is_slow(a[2]):
        return False
    m_1, m_2, m_3 = memory.swing.motion, memory.boom.motion, memory.stick.motion
    return (
        (is_slow(a[0]) or is_stalled(m_1, a[0]))
        and (is_slow(a[1]) or is_stalled(m_2, a[1]))
        and (is_slow(a[2]) or is_stalled(m_3, a[2]))
    )


def hold_hysteresis(
    memory: Joint, error: float, still: bool, p: CoordinationParameters, dt: float
) -> tuple[float, bool]:
    """Return the filtered error r - s [rad], and whether the valve may stay shut.

    A joint that holds does so up to `release_error`; one that moves holds from `hold_error` on, or when
    its error changes sign.
    """
    filtered = memory.error + (1.0 - math.exp(-dt / ERROR_LAG)) * (error - memory.error)
    near = abs(filtered) < (p.release_error if memory.holding else p.hold_error)
    return filtered, still and (near or (not memory.holding and filtered * memory.error < 0.0))


def _joint_servo(
    memory: Joint,
    x: Signals,
    shut: bool,
    all_rest: bool,
    stalled: bool,
    inch: float,
    i: int,
    p: CoordinationParameters,
    dt: float,
) -> tuple[Joint, float]:
    """Return one joint's memory one step on, and its u [rad/s].

    Args:
        memory: before.
        x: its signals; `x.w` is what else is fed forward.
        shut: the driver keeps its valve shut.
        all_rest: the reference of no joint moves.
        stalled: all joints are that shall go.
        inch: rate of an inch, of either sign [rad/s].
        i: which joint.
        p: parameters.
        dt: [s].
    """
    # A valve that is open, to feed what leaks, is better served by the servo than by holding.
    error, still = x.r - x.s, all_rest or (shut and _rests(memory, x.a))
    filtered, holds = hold_hysteresis(memory, error, still, p, dt)
    if all_rest and is_due(memory.inching, shut):
        inching = inched(memory.inching, error, shut, abs(inch), p.free_ways[i], dt)
        return Joint(a=x.a, b=x.b, w=memory.w, error=filtered, holding=True, inching=inching), HOLD_RATE
    # At rest the integral learns what leaks, through an open valve; behind a shut one, or before joints
    # that are stalled, it would wind up.
    learns = not (stalled and is_ahead(x.a, error)) and (not still or (not shut and not holds))
    w = memory.w + dt * p.integral[i] * error if learns else memory.w
    quick = 1.0 if i == 0 else motion_weight(x.a)
    # At rest there is time for less noise: a valve that feeds what leaks would follow it.
    calm = still and (shut or memory.inching.rested >= ARRIVED)
    fed_back = filtered if calm else filtered + quick * (error - filtered)
    u = HOLD_RATE if holds else coordinated(x._replace(s=x.r - fed_back, w=x.w + w), p.gains[i])
    inching = served(memory.inching, dt) if all_rest else MOVING
    motion = updated_motion(memory.motion, x.a, x.v, dt)
    return Joint(a=x.a, b=x.b, w=w, error=filtered, holding=holds, inching=inching, motion=motion), u


def _smooth_acceleration(
    memory: Joint, a: float, p: CoordinationParameters, dt: float
) -> tuple[float, float]:
    """Return b [rad/s^2], low-passed so that its own rate is finite, and that rate [rad/s^3]."""
    change = max(-HIGHEST_ACCELERATION, min(HIGHEST_ACCELERATION, (a - memory.a) / dt))
    gap = change - memory.b
    return memory.b + (1.0 - math.exp(-dt / p.smoothing)) * gap, gap / p.smoothing


def _swing_forward(
    known: float, a: float, b: float, jerk: float, m_11: float, p: CoordinationParameters, dt: float
) -> tuple[float, float]:
    """Return the torque [N m] that the driver has learnt, and the rate [rad/s] to add to the swing's.

    The hoses yield under the torque M_11 b + B a, and take up oil as it grows; the column twists. The
    driver learns the load slowly: what it has not learnt makes the valve slower by half its share of
    the valve's drop.
    """
    torque = m_11 * b + p.swing.damping * a
    known += (1.0 - math.exp(-p.load_bandwidth * dt)) * (torque - known)
    slower = abs(a) * (torque - known) / (2.0 * p.swing.valve_drop)
    oil = (m_11 * jerk + p.swing.damping * b) / p.swing.stiffness
    return known, oil + m_11 * jerk * p.swing.compliance + slower
