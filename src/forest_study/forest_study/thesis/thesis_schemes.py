"""The four schemes of Thesis fig. 5.2 and ours around the linear plant of `thesis_plant`.

| scheme | wish | servo |
|---|---|---|
| (a) `ik_velocity` | x_d = x(0) + ∫ẋ_d; θ_d = IK(x_d); a = dθ_d/dt | velocity: k u = W0 K_v (K* a - v) |
| (b) `ik_position` | x_d and r = IK(x_d) as in (a) | position: k u = W0 (K_p (r - s) - K_d v) |
| (c) `jacobian_velocity` | a = J^-1(s) ẋ_d, at the measured angles | velocity |
| (d) `jacobian_position` | a as in (c); r = s(0) + ∫a | position, K* = 1 |
| `coordinated` | a = J^-1(r) x', r = s(0) + ∫a | k u = ω_n (a + T b + K_p (r - s) + w), T = 1/ω_n |

The last is the graph's own in continuous time. Its ω_n is the one that the gains are made for: that is what
the valve driver does for it in the graph. Its wish x' follows ẋ_d no faster than `ACCELERATION`, as there;
the errors are those to ẋ_d itself.

Of the others the diagrams are lost. The text has a differentiator in (a), and tip positions fed by forward
kinematics to
the integrators of the wish. Fed at every instant, they would make r = s and (b) would stand still, and (a)
would be (c); so the tip is fed once, at the start. The differentiator is ideal, dθ_d/dt = J^-1(θ_d) ẋ_d; the
noise that a real one amplifies is not in this study.

| symbol | name | unit |
|---|---|---|
| s, v, r, a, x_d | as in `thesis_plant` and `forest_control.servo.schemes` | |
| p | closed-loop pole of the velocity servo, natural frequency of the position servo | 1/s |
| ζ | damping ratio of the position servo | |
| W0 | the plant's input gain `DRIVE` | rad/s |
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from forest_control.servo import schemes
from forest_description.geometry.kinematics import Links, inverse_kinematics, joint_rates
from forest_description.types import ZERO, Vec3
from forest_study.thesis.thesis_plant import DRIVE, Control, Scheme, State

ACCELERATION = 4.0  # [m/s^2] of x', as in the graph
RAMP_LAG = 0.01  # [s] with which x' closes in on the wish
FEEDBACK_DAMPING = 0.8  # of the coordinated scheme's loop: K_p = w_n/(4 D^2), 4.9 1/s on the 2 Hz plant
INTEGRAL_SHARE = 0.16  # K_i over K_p^2
ALONG = 1e-6  # [s] of the difference quotient for b
DAMPING_RATIO = 1.64  # as read in docs/explanation/equations.md


class Servo(NamedTuple):
    """Both servos' gains, the same for every joint, made for one natural frequency of the plant."""

    natural_frequency: float  # that the gains are made for [rad/s]
    pole: float  # p [1/s]
    velocity_gain: float  # K_v
    pre_loop_gain: float  # K*
    position_gain: float  # K_p [1/s]
    damping_gain: float  # K_d


def servo(natural_frequency: float, pole: float) -> Servo:
    """Return the gains with which both loops have one closed-loop frequency. Thesis section 5.2.1, fig. 5.3.

    K_v = (p - w_n)/W0, K* = p/(W0 K_v), K_p = p²/W0, K_d = (2 ζ p - w_n)/W0.

    Args:
        natural_frequency: the plant's w_n as the designer knows it [rad/s].
        pole: p [1/s], above w_n.
    """
    velocity_gain = (pole - natural_frequency) / DRIVE
    return Servo(
        natural_frequency=natural_frequency,
        pole=pole,
        velocity_gain=velocity_gain,
        pre_loop_gain=pole / (DRIVE * velocity_gain),
        position_gain=pole * pole / DRIVE,
        damping_gain=(2.0 * DAMPING_RATIO * pole - natural_frequency) / DRIVE,
    )


def poles(gains: Servo, natural_frequency: float) -> dict[str, list[float]]:
    """Return the closed-loop poles [1/s] of both servos around a plant of a natural frequency [rad/s].

    Velocity: -(w_n + W0 K_v); position: the roots of s² + (w_n + W0 K_d) s + W0 K_p, real at the damping
    ratios of this study. Thesis section 5.2.2.
    """
    half = 0.5 * (natural_frequency + DRIVE * gains.damping_gain)
    apart = math.sqrt(half * half - DRIVE * gains.position_gain)
    return {
        "velocity": [-(natural_frequency + DRIVE * gains.velocity_gain)],
        "position": [-half + apart, -half - apart],
    }


def ik_velocity(gains: Servo, links: Links) -> Scheme:
    """Scheme (a), inverse kinematics, velocity servo; its differentiator is ideal. Thesis fig. 5.2."""

    def control(state: State, wished: Vec3) -> Control:
        a = joint_rates(inverse_kinematics(state.wished_tip, links), wished, links)
        return Control(_velocity_servo(a, state, gains), ZERO)

    return control


def ik_position(gains: Servo, links: Links) -> Scheme:
    """Scheme (b), inverse kinematics, position servo. Thesis fig. 5.2."""

    def control(state: State, _: Vec3) -> Control:
        return Control(_position_servo(inverse_kinematics(state.wished_tip, links), state, gains), ZERO)

    return control


def jacobian_velocity(gains: Servo, links: Links) -> Scheme:
    """Scheme (c), inverse Jacobian at the measured angles, velocity servo. Thesis fig. 5.2."""

    def control(state: State, wished: Vec3) -> Control:
        return Control(_velocity_servo(joint_rates(state.angles, wished, links), state, gains), ZERO)

    return control


def jacobian_position(gains: Servo, links: Links) -> Scheme:
    """Scheme (d), inverse Jacobian at the measured angles, position servo. Thesis fig. 5.2."""

    def control(state: State, wished: Vec3) -> Control:
        a = joint_rates(state.angles, wished, links)
        return Control(_position_servo(state.reference, state, gains), a)

    return control


def coordinated(gains: Servo, links: Links) -> Scheme:
    """Ours: reference velocity with lead, closed on the pose; x' without steps."""
    w_n = gains.natural_frequency
    k_p = w_n / (4.0 * FEEDBACK_DAMPING**2)
    k_i = INTEGRAL_SHARE * k_p**2
    made = schemes.Gains(0.0, 0.0, 0.0, feedback=k_p, lead_time=1.0 / w_n)

    def control(state: State, wished: Vec3) -> Control:
        ramp, r, s, w = _ramp(state.ramped, wished), state.reference, state.angles, state.integral
        a = joint_rates(r, state.ramped, links)
        later = joint_rates(schemes.moved(r, a, ALONG), schemes.moved(state.ramped, ramp, ALONG), links)
        signals = (
            schemes.Signals(a=a[i], b=(later[i] - a[i]) / ALONG, r=r[i], s=s[i], v=state.rates[i], w=w[i])
            for i in range(3)
        )
        x, y, z = (w_n * schemes.coordinated(signal, made) for signal in signals)
        integral = k_i * (r[0] - s[0]), k_i * (r[1] - s[1]), k_i * (r[2] - s[2])
        return Control((x, y, z), a, ramp, integral)

    return control


def _ramp(velocity: Vec3, wished: Vec3) -> Vec3:
    """Return dx'/dt [m/s^2] towards a wish [m/s], at most `ACCELERATION`."""
    x, y, z = ((w - v) / RAMP_LAG for w, v in zip(wished, velocity, strict=True))
    share = min(1.0, ACCELERATION / max(math.hypot(x, y, z), ACCELERATION))
    return share * x, share * y, share * z


SCHEMES: dict[str, Callable[[Servo, Links], Scheme]] = {
    "a": ik_velocity,
    "b": ik_position,
    "c": jacobian_velocity,
    "d": jacobian_position,
    "coordinated": coordinated,
}


def _velocity_servo(a: Vec3, state: State, gains: Servo) -> Vec3:
    """Return k u = W0 K_v (K* a - v) [rad/s²] of the three joints. Thesis fig. 5.3.

    `forest_control.servo.schemes` writes the servo for a plant v' = w_n (u - v); its gain is W0 K_v
    / w_n, and it
    derives K* = (1 + gain)/gain from that. A `pre_loop_gain` that is not this one scales the wish.
    """
    w_n = gains.natural_frequency
    k_v = DRIVE * gains.velocity_gain / w_n
    shaping = gains.pre_loop_gain * k_v / (1.0 + k_v)
    v, made = state.rates, schemes.Gains(velocity=k_v, position=0.0, damping=0.0, feedback=0.0, lead_time=0.0)
    return (
        w_n * schemes.velocity_servo(_signals(shaping * a[0], 0.0, 0.0, v[0]), made),
        w_n * schemes.velocity_servo(_signals(shaping * a[1], 0.0, 0.0, v[1]), made),
        w_n * schemes.velocity_servo(_signals(shaping * a[2], 0.0, 0.0, v[2]), made),
    )


def _position_servo(r: Vec3, state: State, gains: Servo) -> Vec3:
    """Return k u = W0 (K_p (r - s) - K_d v) [rad/s²] of the three joints. Thesis fig. 5.3."""
    made = schemes.Gains(
        velocity=0.0,
        position=DRIVE * gains.position_gain,
        damping=DRIVE * gains.damping_gain,
        feedback=0.0,
        lead_time=0.0,
    )
    s, v = state.angles, state.rates
    return (
        schemes.position_servo(_signals(0.0, r[0], s[0], v[0]), made),
        schemes.position_servo(_signals(0.0, r[1], s[1], v[1]), made),
        schemes.position_servo(_signals(0.0, r[2], s[2], v[2]), made),
    )


def _signals(a: float, r: float, s: float, v: float) -> schemes.Signals:
    return schemes.Signals(a=a, b=0.0, r=r, s=s, v=v, w=0.0)
