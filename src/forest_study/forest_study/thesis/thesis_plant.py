"""The linear machine of the thesis' evaluation: three first-order joints under a real kinematic chain.

| symbol | name | unit |
|---|---|---|
| s, v | joint angles, joint rates | rad, rad/s |
| r | angles that the position servo of scheme (d) integrates | rad |
| x_d | wished tip position, the integral of the wished tip velocity | m |
| w_n | the plant's natural frequency, 2 pi times 2 Hz or 0.2 Hz | rad/s |
| k u | what the valves drive the joint with | rad/s^2 |

Per joint v' = -w_n v + k u with k = `DRIVE` whatever w_n is: the plant's gain at rest, k / w_n, is wrong when
w_n is. Only the kinematics couple the joints, and only they are nonlinear. Signs and frames as in
`forest_description.geometry.kinematics`.

Integration: classical Runge-Kutta of fourth order at a fixed `STEP`. The fastest pole of the nominal cases is
49 1/s, a quarter of one over the step; positions agree with an adaptive method's to 1e-5 m, and a peak can
hide between rows by 2e-4 of its value. The wish jumps only where steps meet, and the stages of a step look at
it from inside.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from forest_control.operator.joystick_sources import thesis_tip_velocity
from forest_control.servo.schemes import moved
from forest_description.geometry.kinematics import Links, inverse_kinematics, tip_position, tip_velocity
from forest_description.types import ZERO, Floats, Vec3

DRIVE = 2.0 * math.pi * 2.0
"""The plant's input gain k, the thesis' W0, fixed at the nominal natural frequency [rad/s]."""
STEP = 0.005  # [s]; 1, 2.5, 4 and 5.5 s are whole numbers of it
INSIDE = 1e-9  # [s]


class State(NamedTuple):
    """What a case integrates."""

    angles: Vec3  # s [rad]
    rates: Vec3  # v [rad/s]
    reference: Vec3  # r [rad]
    wished_tip: Vec3  # x_d [m]
    ramped: Vec3 = ZERO  # x', the coordinated scheme's own wish [m/s]
    integral: Vec3 = ZERO  # w, alike [rad/s]


class Control(NamedTuple):
    """What a scheme makes of state and wish."""

    drive: Vec3  # k u [rad/s^2]
    reference_rates: Vec3  # dr/dt [rad/s]
    ramp: Vec3 = ZERO  # dx'/dt [m/s^2]
    integral_rates: Vec3 = ZERO  # dw/dt [rad/s^2]


Scheme = Callable[[State, Vec3], Control]  # of a state and the wished tip velocity [m/s]
Wish = Callable[[float], Vec3]  # tip velocity [m/s] at a time [s]


class Motion(NamedTuple):
    """A simulated case, one row per step, the wish as it holds from the row's time on."""

    time: Floats  # [N] s
    wished_velocity: Floats  # [N, 3] m/s
    velocity: Floats  # [N, 3] m/s
    wished_position: Floats  # [N, 3] m
    position: Floats  # [N, 3] m

    @property
    def velocity_error(self) -> Floats:
        """True minus wished tip velocity [N, 3] m/s."""
        return self.velocity - self.wished_velocity

    @property
    def position_error(self) -> Floats:
        """True minus wished tip position [N, 3] m."""
        return self.position - self.wished_position


def at_rest(tip: Vec3, links: Links) -> State:
    """Return the state at rest with the tip at a place [m], nothing wished yet."""
    angles = inverse_kinematics(tip, links)
    return State(angles, (0.0, 0.0, 0.0), angles, tip)


def rate_change(rates: Vec3, drive: Vec3, natural_frequency: float) -> Vec3:
    """Return the joints' accelerations v' = -w_n v + k u [rad/s^2]. Thesis section 5.2.1.

    Differs: the thesis prints the order and the 2 Hz, not the gain.

    Args:
        rates: v [rad/s].
        drive: k u [rad/s^2].
        natural_frequency: w_n [rad/s].
    """
    return (
        drive[0] - natural_frequency * rates[0],
        drive[1] - natural_frequency * rates[1],
        drive[2] - natural_frequency * rates[2],
    )


def simulate(
    scheme: Scheme,
    natural_frequency: float,
    start: State,
    links: Links,
    duration: float,
    wish: Wish = thesis_tip_velocity,
    step: float = STEP,
) -> Motion:
    """Run a case from a state.

    Args:
        scheme: one of `thesis_schemes`.
        natural_frequency: the plant's true w_n [rad/s].
        start: the first row.
        links: of the kinematic chain.
        duration: [s], a whole number of steps.
        wish: tip velocity [m/s] by time; jumps only at whole steps.
        step: of the integration [s].
    """
    rows, state = [start], start
    count = round(duration / step)
    for k in range(count):
        state = _runge_kutta(state, k * step, step, scheme, natural_frequency, wish)
        rows.append(state)
    time = step * np.arange(count + 1, dtype=np.float64)
    return Motion(
        time=time,
        wished_velocity=np.array([wish(t + INSIDE) for t in time.tolist()]),
        velocity=np.array([tip_velocity(row.angles, row.rates, links) for row in rows]),
        wished_position=np.array([row.wished_tip for row in rows]),
        position=np.array([tip_position(row.angles, links) for row in rows]),
    )


def _runge_kutta(
    state: State, time: float, step: float, scheme: Scheme, natural_frequency: float, wish: Wish
) -> State:
    """Return the state one step on."""

    def slope(at: State, wished: Vec3) -> State:
        control = scheme(at, wished)
        change = rate_change(at.rates, control.drive, natural_frequency)
        return State(
            angles=at.rates,
            rates=change,
            reference=control.reference_rates,
            wished_tip=wished,
            ramped=control.ramp,
            integral=control.integral_rates,
        )

    first, middle, last = wish(time + INSIDE), wish(time + 0.5 * step), wish(time + step - INSIDE)
    k1 = slope(state, first)
    k2 = slope(_moved(state, k1, 0.5 * step), middle)
    k3 = slope(_moved(state, k2, 0.5 * step), middle)
    k4 = slope(_moved(state, k3, step), last)
    return _moved(state, State(*map(_mean, k1, k2, k3, k4)), step)


def _mean(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> Vec3:
    """Return (a + 2 b + 2 c + d)/6."""
    return (
        (a[0] + 2.0 * (b[0] + c[0]) + d[0]) / 6.0,
        (a[1] + 2.0 * (b[1] + c[1]) + d[1]) / 6.0,
        (a[2] + 2.0 * (b[2] + c[2]) + d[2]) / 6.0,
    )


def _moved(state: State, slope: State, step: float) -> State:
    """Return state + step * slope."""
    return State(
        angles=moved(state.angles, slope.angles, step),
        rates=moved(state.rates, slope.rates, step),
        reference=moved(state.reference, slope.reference, step),
        wished_tip=moved(state.wished_tip, slope.wished_tip, step),
        ramped=moved(state.ramped, slope.ramped, step),
        integral=moved(state.integral, slope.integral, step),
    )
