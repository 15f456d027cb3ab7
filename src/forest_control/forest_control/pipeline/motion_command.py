"""The command stage: what the operator's levers ask of tip and joints, or the stop that goes on without them.

While the levers may move the crane, they ask for a tip velocity, or in the joint scheme for joint rates. A
taught command takes their place in the tip schemes while it counts (`taught_watch`). Once the levers may not,
the stop along the path (`stop_profile`) asks in their place, until nothing is left of it.
"""

from forest_control.config.controller_settings import Parameters
from forest_control.operator.levers import rate_mode_rates
from forest_control.operator.operator_profile import (
    JOINT_ACCELERATION,
    Mode,
    position_mode_rates,
    position_mode_velocity,
    rate_mode_velocity,
    shaped,
)
from forest_control.operator.taught_command import taught_velocity
from forest_control.pipeline import stop_profile
from forest_control.pipeline.bumpless_transfer import begun, clutched, resumed, taken_over
from forest_control.pipeline.control_state import (
    NO_SCHEME,
    Inputs,
    MotionCommand,
    Phase,
    State,
)
from forest_control.pipeline.stop_profile import NO_STOP, Stop
from forest_control.servo import anti_sway
from forest_control.servo.anti_sway import Sway
from forest_control.servo.coordinated_servo import MOST_SAMPLES, ramped, reference_rates
from forest_control.servo.schemes import Scheme, closes_on_position, jacobian_pose
from forest_description.geometry.kinematics import tip_position
from forest_description.geometry.vectors import minus, norm, scaled
from forest_description.types import ZERO, Vec3


def motion_command(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, MotionCommand]:
    """Return what is asked for in a step of dt [s], and the state from which it goes on."""
    if inputs.enabled:
        return lever_command(state, inputs, p, dt)
    return stop_command(state, inputs.angles, p, dt)


def lever_command(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, MotionCommand]:
    """Return what the levers ask for; the state takes over from a stop, a scheme, a mode without a bump."""
    if not state.enabled and not stop_profile.is_over(state.stop):
        state = resumed(state)
    elif not state.enabled:
        state = begun(state, inputs.angles)
    if state.scheme != NO_SCHEME and state.scheme != p.scheme:
        state = taken_over(state, inputs, p)
    state = clutched(state, inputs.angles, p)
    if inputs.taught.speed > 0.0:  # position mode goes on from where the path is left
        state = state._replace(clutch=_here(state, inputs, p))
    pose = jacobian_pose(p.scheme, state.reference, inputs.angles, p.jacobian_at_joints)
    state, velocity = tip_velocity_command(state, pose, inputs, p, dt)
    rates = joint_rate_command(state, inputs, p, dt) if p.scheme == Scheme.JOINT else ZERO
    settles = p.scheme == Scheme.COORDINATED and velocity == ZERO and state.memory.samples < MOST_SAMPLES
    phase = Phase.SETTLING if settles else Phase.MOVING
    return state, MotionCommand(
        phase=phase, pose=pose, velocity=velocity, lagged=velocity, rates=rates, wish=state.wish
    )


def tip_velocity_command(
    state: State, pose: Vec3, inputs: Inputs, p: Parameters, dt: float
) -> tuple[State, Vec3]:
    """Return the tip velocity [m/s] that the levers ask for; a ramp in position mode or coordinated."""
    if p.scheme == Scheme.JOINT:
        return state._replace(sway=anti_sway.NO_SWAY, wish=ZERO), ZERO
    levers, sway = shaped(inputs.levers, p.profile), anti_sway.NO_SWAY
    if inputs.taught.speed > 0.0:
        most = min(p.profile.speeds[0], p.profile.speeds[1], p.profile.speeds[2])
        asked = taught_velocity(inputs.taught, tip_position(_here(state, inputs, p), p.links), most)
    elif p.profile.mode == Mode.POSITION:
        here = _here(state, inputs, p)
        asked = scaled(
            position_mode_velocity(levers, state.clutch, here, p.profile, p.links), inputs.speed_scale
        )
    else:
        asked = scaled(rate_mode_velocity(levers, pose, p.profile), inputs.speed_scale)
        if p.scheme != Scheme.COORDINATED:
            return state._replace(sway=anti_sway.NO_SWAY, wish=asked), asked
        sway, asked = _without_sway(state, asked, p, dt)
    velocity = ramped(state.memory.velocity, asked, p.coordinated.acceleration, dt)
    held_back = norm(asked) > norm(state.memory.velocity)
    wish = ramped(state.wish, asked, p.coordinated.acceleration, dt) if held_back else velocity
    return state._replace(sway=sway, wish=wish), velocity


def _without_sway(state: State, asked: Vec3, p: Parameters, dt: float) -> tuple[Sway, Vec3]:
    """Return the filter and the tip velocity [m/s] that leaves the head at rest."""
    if p.sway.frequency == 0.0:
        return anti_sway.NO_SWAY, asked
    sway = state.sway
    if sway == anti_sway.NO_SWAY:
        sway = anti_sway.begun(state.memory.velocity, p.sway)
    wish = ramped(sway.wish, asked, p.coordinated.acceleration, dt)
    return anti_sway.filtered(sway, wish, p.sway, dt)


def _here(state: State, inputs: Inputs, p: Parameters) -> Vec3:
    """Return the pose [rad] that is led: the reference, where the scheme holds one."""
    return state.reference if closes_on_position(p.scheme) else inputs.angles


def joint_rate_command(state: State, inputs: Inputs, p: Parameters, dt: float) -> Vec3:
    """Return the joint rates [rad/s] that the levers ask for in the joint scheme; a ramp in position mode."""
    levers, most = shaped(inputs.levers, p.profile), scaled(p.velocity_limits.rates, inputs.speed_scale)
    if p.profile.mode == Mode.RATE:
        return rate_mode_rates(levers, most)
    asked = position_mode_rates(levers, state.clutch, inputs.angles, p.profile, most)
    return ramped(reference_rates(state.memory), asked, JOINT_ACCELERATION, dt)


def stop_command(state: State, s: Vec3, p: Parameters, dt: float) -> tuple[State, MotionCommand]:
    """Return what the stop along the path asks for at measured angles [rad]; once it is over, nothing."""
    stop = stop_profile.advanced(_stop_from(state, s, p) if state.enabled else state.stop, dt)
    if stop_profile.is_over(stop) or state.scheme != p.scheme:
        return state, MotionCommand(phase=Phase.STANDING, pose=s)
    if state.enabled:  # what fades since a resumed stop would be added to this one, again and again
        state = state._replace(reference=s, offset=ZERO)
    r, state = state.reference, state._replace(stop=stop)
    if stop.duration != stop_profile.CLOSED_LOOP:
        rates, velocity = stop_profile.commanded(stop, s, p.links)
        return state, MotionCommand(phase=Phase.BRAKING, pose=s, velocity=velocity, rates=rates)
    velocity = scaled(stop.reference_velocity, stop_profile.velocity_left(stop))
    lagged = scaled(stop.reference_velocity, stop_profile.lagged_velocity_left(stop))
    return state, MotionCommand(phase=Phase.STOPPING, pose=r, velocity=velocity, lagged=lagged)


def _stop_from(state: State, s: Vec3, p: Parameters) -> Stop:
    """Return the stop of a scheme at measured angles [rad]; none when nothing was commanded."""
    if state.rates == ZERO and state.memory.velocity == ZERO:
        return NO_STOP
    away = minus(state.reference, s)
    near = max(abs(away[0]), abs(away[1]), abs(away[2])) < stop_profile.ASTRAY
    closed = p.scheme == Scheme.COORDINATED and near
    duration = stop_profile.CLOSED_LOOP if closed else stop_profile.OPEN_LOOP
    return stop_profile.begin(duration, state.rates, state.memory.velocity, s, p.links)
