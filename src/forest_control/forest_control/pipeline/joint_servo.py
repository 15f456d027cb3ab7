"""A governed wish carried out: the reference moved on, the scheme's servo, the valves' voltages."""

from forest_control.config.settings import Parameters
from forest_control.pipeline.bumpless_transfer import faded, offset_to, within_lead
from forest_control.pipeline.control_state import Inputs, Output, State, Wish
from forest_control.pipeline.stop_profile import NO_STOP
from forest_control.servo import coordinated_servo
from forest_control.servo.inching import MOVING
from forest_control.servo.schemes import Scheme, Signals, advanced, closes_on_position, moved, servo
from forest_description.derived.actuator_kinematics import joint_rates_to_actuator_speeds
from forest_description.geometry.kinematics import tip_velocity
from forest_description.types import ZERO, Vec3

NEAR = 0.002  # [rad] of the reference, where a position servo at rest may leave its valve shut


def carried_out(
    state: State, wish: Wish, pose: Vec3, inputs: Inputs, p: Parameters, dt: float
) -> tuple[State, Output]:
    """Return the state and the output of a step that carries out a governed wish."""
    r, s, a = state.reference, inputs.angles, wish.rates
    after = within_lead(advanced(p.scheme, r, a, wish.velocity, p.links, dt), r, s, p)
    if p.scheme == Scheme.COORDINATED:
        before = coordinated_servo.going(state.memory, wish.velocity)
        memory, u = coordinated_servo.servo(before, a, r, s, inputs.rates, inputs.voltages, p.coordinated, dt)
    else:
        memory, u = _thesis_servo(state.memory, wish, after, inputs, p, dt)
    offset = offset_to(u, state, p)
    u = moved(u, offset, 1.0)
    tip_wish = wish.velocity
    if p.scheme == Scheme.COORDINATED and offset != ZERO:
        # The reference goes the way that is commanded, or the servo would fight what fades.
        after = within_lead(moved(after, offset, dt), r, s, p)
        tip_wish = moved(tip_wish, tip_velocity(pose, offset, p.links), 1.0)
    # What takes over while a joint is inched takes nothing over of that.
    command = to_voltage(moved(u, coordinated_servo.inches(memory), 1.0), s, p)
    output = Output(command, tip_wish, wish.governed)
    fading, mode = faded(offset, dt), p.hand.mode
    return State(after, True, memory, p.scheme, u, fading, mode, state.clutch, False, NO_STOP), output


def _thesis_servo(
    memory: coordinated_servo.Memory, wish: Wish, r: Vec3, inputs: Inputs, p: Parameters, dt: float
) -> tuple[coordinated_servo.Memory, Vec3]:
    """Return the memory, and the joint rates [rad/s] that a scheme of the thesis commands at a reference."""
    still = closes_on_position(p.scheme) and coordinated_servo.rests(memory, wish.rates)
    swing, u_1 = _joint_servo(memory.swing, 0, still, wish, r, inputs, p, dt)
    boom, u_2 = _joint_servo(memory.boom, 1, still, wish, r, inputs, p, dt)
    stick, u_3 = _joint_servo(memory.stick, 2, still, wish, r, inputs, p, dt)
    return coordinated_servo.Memory(wish.velocity, swing, boom, stick, 0.0, 0), (u_1, u_2, u_3)


def _joint_servo(
    memory: coordinated_servo.Joint,
    i: int,
    still: bool,
    wish: Wish,
    r: Vec3,
    inputs: Inputs,
    p: Parameters,
    dt: float,
) -> tuple[coordinated_servo.Joint, float]:
    """Return one joint's memory and rate [rad/s]; where it rests at its reference, its valve stays shut."""
    a, s, v = wish.rates[i], inputs.angles[i], inputs.rates[i]
    seen, holds, wide, side = coordinated_servo.held(memory, r[i] - s, still, p.coordinated, dt)
    u = (
        0.0
        if holds and abs(r[i] - s) < NEAR
        else servo(p.scheme, Signals(a, 0.0, r[i], s, v, 0.0), p.gains[i])
    )
    return coordinated_servo.Joint(a, 0.0, 0.0, seen, holds, wide, side, 0.0, MOVING), u


def to_voltage(rates: Vec3, angles: Vec3, p: Parameters) -> Vec3:
    """Return the ideal valves' voltages for joint rates [rad/s], clipped at the rating. Thesis eq. 3.16."""
    speeds = joint_rates_to_actuator_speeds(angles, rates, p.linkages)
    return _volts(speeds[0], 0, p), _volts(speeds[1], 1, p), _volts(speeds[2], 2, p)


def _volts(speed: float, i: int, p: Parameters) -> float:
    rated = p.rated_voltages[i]
    return max(-rated, min(rated, rated * speed / p.rated_speeds[i]))
