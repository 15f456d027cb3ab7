"""Anti-sway: the tip's wished velocity, filtered so that it leaves what hangs from the tip at rest.

The head hangs from the tip as a pendulum. The filter's zeros cancel the pendulum's poles, and two real poles
of the same frequency take their place. There is no sensor and no loop: an error of the frequency costs some
of the effect, and no stability.

    F(s) = (s^2 + 2 zeta w s + w^2) / (s + w)^2

The tip lags behind the wish by 2 (1 - zeta) / w, and ends where it would have ended. All three components
pass the same filter, so a straight way stays straight.

| symbol | name | unit |
|---|---|---|
| u, y | wished velocity of the tip, before and after the filter | m/s |
| w, zeta | frequency and damping ratio of the hanging head | rad/s, 1 |
| p, q | states of 1 / (s + w)^2, and their rate | m s, m |
"""

import math
from typing import NamedTuple

from forest_description.derived.bodies import hanging_body
from forest_description.geometry.vectors import norm
from forest_description.machine import Machine
from forest_description.types import ZERO, Vec3

LEFT = 1e-3  # [m] of way that is left once the wish is zero, at which the tip stops: under the noise; chosen


class SwayParameters(NamedTuple):
    """The pendulum; a frequency of 0 leaves the wish as it is."""

    frequency: float = 0.0  # w [rad/s]
    damping: float = 0.0  # zeta


class Sway(NamedTuple):
    """What the filter remembers."""

    wish: Vec3 = ZERO  # u, on its ramp
    p: Vec3 = ZERO
    q: Vec3 = ZERO


NO_SWAY = Sway()


def sway_parameters(machine: Machine) -> SwayParameters:
    """Return the pendulum of a machine with what its file has in the head; none of a machine without.

    The log's own inertia is left out: across the crane's plane it has none.
    """
    body = hanging_body(machine.manipulator)
    if body is None:
        return SwayParameters()
    pendulum = machine.manipulator.pendulum
    assert pendulum is not None
    inertia = body.inertia + body.mass * body.length**2
    frequency = math.sqrt(body.mass * machine.manipulator.gravity * body.length / inertia)
    return SwayParameters(frequency, min(1.0, 0.5 * pendulum.damping / (inertia * frequency)))


def begun(velocity: Vec3, s: SwayParameters) -> Sway:
    """Return the filter that has long passed a velocity [m/s] on."""
    square = s.frequency * s.frequency
    x, y, z = velocity
    return Sway(wish=velocity, p=(x / square, y / square, z / square))


def filtered(sway: Sway, wish: Vec3, s: SwayParameters, dt: float) -> tuple[Sway, Vec3]:
    """Return the filter dt [s] later, and y [m/s]. A wish [m/s] holds over the step: that is exact."""
    p_1, q_1, y_1 = _component(sway.p[0], sway.q[0], wish[0], s, dt)
    p_2, q_2, y_2 = _component(sway.p[1], sway.q[1], wish[1], s, dt)
    p_3, q_3, y_3 = _component(sway.p[2], sway.q[2], wish[2], s, dt)
    # At a wish of zero y is left to go the way 2 (1 - zeta) w p, and with q comes to it and beyond it.
    to_and_fro = s.frequency * norm((p_1, p_2, p_3)) + norm((q_1, q_2, q_3))
    if wish == ZERO and 2.0 * (1.0 - s.damping) * to_and_fro < LEFT:
        return NO_SWAY, ZERO
    return Sway(wish=wish, p=(p_1, p_2, p_3), q=(q_1, q_2, q_3)), (y_1, y_2, y_3)


def _component(p: float, q: float, u: float, s: SwayParameters, dt: float) -> tuple[float, float, float]:
    w, decay = s.frequency, math.exp(-s.frequency * dt)
    away = p - u / (w * w)
    p = u / (w * w) + decay * ((1.0 + w * dt) * away + dt * q)
    q = decay * ((1.0 - w * dt) * q - w * w * dt * away)
    return p, q, u - 2.0 * (1.0 - s.damping) * w * q
