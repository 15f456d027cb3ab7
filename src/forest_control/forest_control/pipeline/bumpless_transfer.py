"""Live changes that are not felt: another scheme, another mode, other gains, a stop that is taken back.

All schemes remember the same: a reference pose and what was commanded last. A scheme that takes over starts
from the pose at which it would command just that, where there is one. What remains of the difference is added
to its command and fades (`FADE_TIME`).
"""

from forest_control.config.controller_settings import Parameters
from forest_control.pipeline.control_state import NO_MODE, NO_SCHEME, REST, Inputs, State
from forest_control.pipeline.stop_profile import NO_STOP
from forest_control.servo import coordinated_servo
from forest_control.servo.anti_sway import NO_SWAY
from forest_control.servo.joint_angle_filter import AngleCorrection
from forest_control.servo.schemes import Scheme, closes_on_position, decayed, reference_for_rate
from forest_description.geometry.kinematics import joint_rates, tip_velocity
from forest_description.geometry.vectors import minus
from forest_description.types import ZERO, Vec3

FADE_TIME = 0.2  # [s] in which the difference between two schemes' commands fades


def begun(state: State, s: Vec3) -> State:
    """Return the state of a machine that begins to move from rest at measured angles [rad]."""
    return REST._replace(
        reference=s,
        enabled=True,
        correction=state.correction,
        tracking_limits=state.tracking_limits,
        weighing=state.weighing,
    )


def resumed(state: State) -> State:
    """Return the state of a machine that was stopping, and shall not."""
    wish = state.memory.velocity
    return state._replace(enabled=True, mode=NO_MODE, changed=True, stop=NO_STOP, sway=NO_SWAY, wish=wish)


def clutched(state: State, s: Vec3, p: Parameters) -> State:
    """Return the state with the clutch where the machine is, if another mode was in force."""
    if state.mode == p.profile.mode:
        return state
    clutch = state.reference if closes_on_position(p.scheme) else s
    changed = state.changed or state.mode != NO_MODE
    return state._replace(mode=p.profile.mode, clutch=clutch, changed=changed)


def taken_over(state: State, inputs: Inputs, p: Parameters) -> State:
    """Return the state that the chosen scheme starts from, another one having been in charge."""
    s, v, u, g = inputs.angles, inputs.rates, state.rates, p.gains
    a = coordinated_servo.reference_rates(state.memory)
    still = state.memory.velocity == ZERO and a == ZERO
    r = s
    if closes_on_position(p.scheme) and (still or p.scheme != Scheme.COORDINATED):
        r = (
            reference_for_rate(p.scheme, u[0], s[0], v[0], g[0]),
            reference_for_rate(p.scheme, u[1], s[1], v[1], g[1]),
            reference_for_rate(p.scheme, u[2], s[2], v[2], g[2]),
        )
    velocity = tip_velocity(s, a, p.links) if state.scheme == Scheme.JOINT else state.memory.velocity
    shut = max(abs(u[0]), abs(u[1]), abs(u[2])) <= coordinated_servo.HOLD_RATE
    samples = 0 if still and shut else coordinated_servo.MOST_SAMPLES
    r = within_error_limit(r, s, s, p)
    if state.scheme != Scheme.JOINT:
        # The rates of the other pose would be a jerk to the feedforward.
        a = joint_rates(r, velocity, p.links)
    return state._replace(reference=r, memory=coordinated_servo.in_motion(velocity, a, samples))


def relearnt(state: State, correction: AngleCorrection) -> State:
    """Return the state whose resting reference goes with the correction: no tip moves for what is learnt."""
    if not (state.enabled and correction.used) or state.memory.velocity != ZERO:
        return state
    boom, stick = correction.boom - state.correction.boom, correction.stick - state.correction.stick
    r, k = state.reference, state.clutch
    reference, clutch = (r[0], r[1] + boom, r[2] + stick), (k[0], k[1] + boom, k[2] + stick)
    return state._replace(reference=reference, clutch=clutch)


def offset_to(u: Vec3, state: State, p: Parameters) -> Vec3:
    """Return what is added [rad/s] to the servo's rates; after a change, all that they differ by."""
    if state.changed or (state.scheme != NO_SCHEME and state.scheme != p.scheme):
        return minus(state.rates, u)
    return state.offset


def faded(offset: Vec3, dt: float) -> Vec3:
    """Return an offset [rad/s] dt [s] later."""
    return (
        decayed(offset[0], dt, FADE_TIME),
        decayed(offset[1], dt, FADE_TIME),
        decayed(offset[2], dt, FADE_TIME),
    )


def within_error_limit(r: Vec3, before: Vec3, s: Vec3, p: Parameters) -> Vec3:
    """Return reference angles [rad] within `following_error_limit` of the joints, and inside their limits.

    A machine may stand between margin and limit. There the reference goes no further out than it was before;
    bounded by what is measured, noise would draw it inwards step by step.

    Args:
        r: reference angles.
        before: where they were, or are allowed to be.
        s: measured angles.
        p: parameters.
    """
    return (
        _within_error_limit(r[0], before[0], s[0], 0, p),
        _within_error_limit(r[1], before[1], s[1], 1, p),
        _within_error_limit(r[2], before[2], s[2], 2, p),
    )


def _within_error_limit(r: float, before: float, s: float, i: int, p: Parameters) -> float:
    lower, upper = min(p.velocity_limits.lower[i], before), max(p.velocity_limits.upper[i], before)
    most = p.following_error_limit
    return max(lower, min(upper, max(s - most, min(s + most, r))))
