"""The stop along the path: what is commanded after the deadman was let go, or the joystick lost.

Valves that are slammed shut stop each joint when its oil wants, and the crane rocks; the tip leaves its path.
So the tip's velocity is taken back smoothly, along the direction that it had, and no lever is heeded; then
every valve stays shut. A scheme that holds its reference follows it to the end, from where the tip is: what
it was off its path by is not caught up with. The machine answers late, so that reference goes by what was
commanded `LAG` ago, or the servo would brake twice; and no valve opens the other way. For the other schemes
the commanded rates are taken back, open loop and faster, since the machine lags behind.

| symbol | name | unit |
|---|---|---|
| x' | tip velocity that was commanded when the stop began | m/s |
| u | commanded joint rates, J^-1(s) x' left(t) | rad/s |
| t | time since then | s |
| T | duration | s |

left(t) = x^2.5 (3.5 - 2.5 x), x = 1 - t / T: it brakes soon and ends gently, so that little rocks on behind
the shut valves; the way is 4/9 x' T, the greatest deceleration 1.63 x' / T.
"""

import math
from typing import NamedTuple

from forest_description.geometry.kinematics import Links, is_singular, joint_rates, tip_velocity
from forest_description.geometry.vectors import scaled
from forest_description.types import Vec3

CLOSED_LOOP = 0.24  # [s] T of a scheme that holds its reference: just inside 0.25 s, softest for the swing
OPEN_LOOP = 0.16  # [s] T of the others
LAG = 0.015  # [s] after which spool and oil answer
ASTRAY = 0.01  # [rad] a joint that is further from its reference has stalled: it must not be pulled there


class Stop(NamedTuple):
    """A stop under way."""

    elapsed: float  # t [s]
    duration: float  # T [s]
    velocity: Vec3  # x' [m/s]
    rates: Vec3  # u [rad/s] when it began, for where J has no inverse
    reference_velocity: Vec3  # of the tip when it began [m/s], for a scheme that holds its reference


NO_STOP = Stop(
    elapsed=math.inf,
    duration=OPEN_LOOP,
    velocity=(0.0, 0.0, 0.0),
    rates=(0.0, 0.0, 0.0),
    reference_velocity=(0.0, 0.0, 0.0),
)


def begin(duration: float, u: Vec3, reference_velocity: Vec3, s: Vec3, links: Links) -> Stop:
    """Return the stop within a duration [s] from commanded joint rates [rad/s] and a reference velocity.

    Args:
        duration: `CLOSED_LOOP` or `OPEN_LOOP`.
        u: commanded last.
        reference_velocity: of the tip, aimed at last [m/s].
        s: measured angles [rad].
        links: of the crane.
    """
    return Stop(
        elapsed=0.0,
        duration=duration,
        velocity=tip_velocity(s, u, links),
        rates=u,
        reference_velocity=reference_velocity,
    )


def velocity_left(stop: Stop) -> float:
    """Return how much of the velocity is left, 1..0."""
    return _left(stop.elapsed / stop.duration)


def lagged_velocity_left(stop: Stop) -> float:
    """Return how much of it the machine can have by now: what was left `LAG` ago."""
    return _left((stop.elapsed - LAG) / stop.duration)


def _left(part: float) -> float:
    x = 1.0 - max(0.0, min(1.0, part))
    return x * x * math.sqrt(x) * (3.5 - 2.5 * x)


def onwards(u: Vec3, a: Vec3) -> Vec3:
    """Return the rates u [rad/s] of the joints that go on as wished [rad/s]; none of the others.

    What is little over at the end of a stop would throw the valves to and fro across their overlap.
    """
    return _onwards(u[0], a[0]), _onwards(u[1], a[1]), _onwards(u[2], a[2])


def _onwards(u: float, a: float) -> float:
    return u if u * a > 0.0 else 0.0


def advanced(stop: Stop, dt: float) -> Stop:
    """Return the stop one step on."""
    return stop._replace(elapsed=stop.elapsed + dt)


def is_over(stop: Stop) -> bool:
    """Tell whether nothing is left of it."""
    return stop.elapsed >= stop.duration


def commanded(stop: Stop, s: Vec3, links: Links) -> tuple[Vec3, Vec3]:
    """Return joint rates [rad/s] at measured angles [rad], and the tip velocity [m/s] that they aim at."""
    left = velocity_left(stop)
    velocity = scaled(stop.velocity, left)
    if is_singular(s, links):
        return scaled(stop.rates, left), velocity
    return joint_rates(s, velocity, links), velocity
