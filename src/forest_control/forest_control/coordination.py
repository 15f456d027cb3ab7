"""What the coordinated scheme remembers between steps: a smooth reference, the integral, who holds still.

| symbol | name | unit |
|---|---|---|
| x' | reference velocity of the tip | m/s |
| a, b | reference joint rates, their rate of change | rad/s, rad/s^2 |
| r, s | reference and measured joint angle | rad |
| w | integral of K_i (r - s) | rad/s |

The reference is the operator's wish with its steps turned into ramps, so that b is finite. While the
reference rests, a joint that is near it holds: its valve stays shut until the error has grown, or noise would
open it back and forth through the overlap for ever.
"""

import math
from typing import NamedTuple

from forest_control.schemes import coordinated
from forest_control.swing_load import SwingLoad, inertia

Triple = tuple[float, float, float]
Flags = tuple[bool, bool, bool]
ZERO: Triple = (0.0, 0.0, 0.0)

REST_RATE = 1e-4  # [rad/s] a reference slower than this rests
ERROR_LAG = 0.05  # [s] of the low-pass through which an error decides about holding
HIGHEST_ACCELERATION = 2.0  # [rad/s^2] a jump of the governor's must not kick the valves


class CoordinationParameters(NamedTuple):
    """Gains and bounds, per joint where triples: swing, boom, stick."""

    feedback: Triple  # K_p [1/s]
    integral: Triple  # K_i [1/s^2]
    lead_time: Triple  # T [s]
    swing: SwingLoad  # what is fed forward to it
    load_bandwidth: float  # [rad/s] at which the valve driver learns a load
    smoothing: float  # [s] of b
    acceleration: float  # [m/s^2] of the tip's reference
    integral_limit: float  # [rad/s]
    hold_error: float  # [rad] a resting joint this near holds
    release_error: float  # [rad] and moves again beyond this


class Memory(NamedTuple):
    """State between steps."""

    velocity: Triple  # x' [m/s], governed
    rates: Triple  # a [rad/s]
    accelerations: Triple  # b [rad/s^2]
    integral: Triple  # w [rad/s]
    holding: Flags
    errors: Triple = ZERO  # [rad] r - s, low-passed
    torque: float = 0.0  # [N m] of the swing that the driver knows by now
    samples: int = 0  # in the mean pose that the reference starts from


REST = Memory(ZERO, ZERO, ZERO, ZERO, (True, True, True))
MOST_SAMPLES = 50


def settle(reference: Triple, s: Triple, memory: Memory) -> tuple[Triple, Memory]:
    """Return the pose [rad] to start from: the mean of what was measured at rest; one sample is too noisy."""
    count = memory.samples + 1
    q = tuple(r + (x - r) / count for r, x in zip(reference, s, strict=True))
    return (q[0], q[1], q[2]), memory._replace(samples=count)


def ramped(velocity: Triple, wish: Triple, acceleration: float, dt: float) -> Triple:
    """Return the reference velocity [m/s] after dt [s] on the way to a wish, at most so accelerated."""
    change = tuple(w - v for v, w in zip(velocity, wish, strict=True))
    size, most = math.hypot(*change), acceleration * dt
    if size <= most:
        return wish
    x, y, z = (v + most / size * c for v, c in zip(velocity, change, strict=True))
    return x, y, z


def servo(
    memory: Memory, a: Triple, r: Triple, s: Triple, p: CoordinationParameters, dt: float
) -> tuple[Memory, Triple]:
    """Return the memory one step on, and the commanded joint rates u [rad/s]."""
    b, jerk = _smooth_acceleration(memory, a, p, dt)
    torque, extra = _swing_forward(memory.torque, a[0], b[0], jerk[0], inertia(r, p.swing), p, dt)
    forward = extra, 0.0, 0.0
    still = max(map(abs, (*a, *memory.rates))) < REST_RATE
    u, w, holding, errors = [], [], [], []
    for i in range(3):
        error = r[i] - s[i]
        seen = memory.errors[i] + (1.0 - math.exp(-dt / ERROR_LAG)) * (error - memory.errors[i])
        errors.append(seen)
        near = abs(seen) < (p.release_error if memory.holding[i] else p.hold_error)
        holds = near and still
        # What the integral has learnt of the valve at speed is kept while the joint holds.
        grown = memory.integral[i] if holds else memory.integral[i] + dt * p.integral[i] * error
        w.append(max(-p.integral_limit, min(p.integral_limit, grown)))
        wish = a[i] + forward[i]
        u.append(0.0 if holds else coordinated(wish, b[i], r[i], s[i], w[i], p.lead_time[i], p.feedback[i]))
        holding.append(holds)
    after = memory._replace(
        rates=a,
        accelerations=b,
        integral=(w[0], w[1], w[2]),
        holding=(holding[0], holding[1], holding[2]),
        torque=torque,
        errors=(errors[0], errors[1], errors[2]),
    )
    return after, (u[0], u[1], u[2])


def _smooth_acceleration(
    memory: Memory, a: Triple, p: CoordinationParameters, dt: float
) -> tuple[Triple, Triple]:
    """Return b [rad/s^2], low-passed so that its own rate is finite, and that rate [rad/s^3]."""
    weight, b, jerk = 1.0 - math.exp(-dt / p.smoothing), [], []
    for i in range(3):
        change = (a[i] - memory.rates[i]) / dt
        gap = max(-HIGHEST_ACCELERATION, min(HIGHEST_ACCELERATION, change)) - memory.accelerations[i]
        b.append(memory.accelerations[i] + weight * gap)
        jerk.append(gap / p.smoothing)
    return (b[0], b[1], b[2]), (jerk[0], jerk[1], jerk[2])


def _swing_forward(
    known: float, a: float, b: float, jerk: float, m_11: float, p: CoordinationParameters, dt: float
) -> tuple[float, float]:
    """Return the torque [N m] that the driver knows of by now, and the rate [rad/s] to add to the swing's.

    The hoses yield under the torque M_11 b: their oil takes jerk / w_0^2. And the driver learns the load
    slowly: what it does not know yet makes the valve slower by half its share of the greatest torque.
    """
    torque = m_11 * b + p.swing.damping * a
    known += (1.0 - math.exp(-p.load_bandwidth * dt)) * (torque - known)
    slower = abs(a) * (torque - known) / (2.0 * p.swing.greatest_torque)
    return known, m_11 / p.swing.stiffness * jerk + slower
