"""The servo stage: the reference moved on, and the joint rates that bring the joints there.

Each scheme has its servo (`schemes`, `coordinated_servo`). A stop that is closed on the reference brakes with
the same servo, and turns no valve round; one in open loop takes its rates as they are.
"""

from forest_control.config.controller_settings import Parameters
from forest_control.pipeline import stop_profile
from forest_control.pipeline.bumpless_transfer import offset_to, within_error_limit
from forest_control.pipeline.control_state import (
    Inputs,
    MotionCommand,
    Phase,
    Reference,
    Servo,
    State,
)
from forest_control.servo import coordinated_servo
from forest_control.servo.coordinated_servo import CoordinationParameters, Joint, Memory
from forest_control.servo.overspeed_limit import without_overspeed
from forest_control.servo.schemes import Scheme, Signals, advanced, closes_on_position, moved, servo
from forest_control.servo.stalled_joints import kept_near
from forest_description.geometry.kinematics import tip_velocity
from forest_description.geometry.vectors import plus
from forest_description.types import ZERO, Vec3

NEAR = 0.002  # [rad] of the reference, where a position servo at rest may leave its valve shut


def joint_servo(
    command: MotionCommand, reference: Reference, state: State, inputs: Inputs, p: Parameters, dt: float
) -> Servo:
    """Return the servo's answer to a reference after dt [s]."""
    if command.phase == Phase.STANDING:
        return Servo(inputs.angles, coordinated_servo.REST)
    if command.phase == Phase.SETTLING:
        mean, memory = coordinated_servo.settle(state.reference, inputs.angles, state.memory)
        return Servo(mean, memory)
    a, velocity = reference.rates, reference.velocity
    if command.phase == Phase.BRAKING:
        memory = coordinated_servo.in_motion(velocity, a, coordinated_servo.MOST_SAMPLES)
        return Servo(reference=inputs.angles, memory=memory, rates=a, velocity=velocity)
    r, s = state.reference, inputs.angles
    after = advanced(p.scheme, r, a, velocity, p.links, dt)
    if p.scheme == Scheme.COORDINATED and coordinated_servo.all_stalled(state.memory, a):
        after = kept_near(after, a, s)
    after = within_error_limit(after, r, s, p)
    if p.scheme == Scheme.COORDINATED:
        gains = _braking(p.coordinated) if command.phase == Phase.STOPPING else p.coordinated
        before = coordinated_servo.with_velocity(state.memory, velocity)
        memory, u = coordinated_servo.servo(before, a, r, s, inputs.rates, inputs.voltages, gains, dt)
    else:
        memory, u = _thesis_servo(state.memory, reference, after, inputs, p, dt)
    offset = offset_to(u, state, p)
    u = plus(u, offset)
    if p.scheme == Scheme.COORDINATED and offset != ZERO:
        # The reference goes the way that is commanded, or the servo would fight what fades.
        after = within_error_limit(moved(after, offset, dt), r, s, p)
        velocity = plus(velocity, tip_velocity(command.pose, offset, p.links))
    if command.phase == Phase.STOPPING:
        u = stop_profile.onwards(u, a)
    if p.scheme == Scheme.COORDINATED:
        u = without_overspeed(u, a, inputs.rates)
    return Servo(reference=after, memory=memory, rates=u, offset=offset, velocity=velocity)


def _braking(p: CoordinationParameters) -> CoordinationParameters:
    """Return the gains of a stop: the oil for the swing's damping, fed forward, brakes it too much."""
    swing, boom, stick = p.gains
    lead = max(0.0, swing.lead_time - p.swing.damping / p.swing.stiffness)
    return p._replace(gains=(swing._replace(lead_time=lead), boom, stick))


def _thesis_servo(
    memory: Memory, reference: Reference, r: Vec3, inputs: Inputs, p: Parameters, dt: float
) -> tuple[Memory, Vec3]:
    """Return the memory, and the joint rates [rad/s] that a scheme of the thesis commands at a pose r."""
    still = closes_on_position(p.scheme) and coordinated_servo.rests(memory, reference.rates)
    swing, u_1 = _thesis_joint_servo(memory.swing, 0, still, reference.rates[0], r, inputs, p, dt)
    boom, u_2 = _thesis_joint_servo(memory.boom, 1, still, reference.rates[1], r, inputs, p, dt)
    stick, u_3 = _thesis_joint_servo(memory.stick, 2, still, reference.rates[2], r, inputs, p, dt)
    return Memory(reference.velocity, swing, boom, stick), (u_1, u_2, u_3)


def _thesis_joint_servo(
    memory: Joint, i: int, still: bool, a: float, r: Vec3, inputs: Inputs, p: Parameters, dt: float
) -> tuple[Joint, float]:
    """Return one joint's memory and rate [rad/s]; where it rests at its reference, its valve stays shut."""
    s, v = inputs.angles[i], inputs.rates[i]
    seen, holds = coordinated_servo.hold_hysteresis(memory, r[i] - s, still, p.coordinated, dt)
    signals = Signals(a=a, b=0.0, r=r[i], s=s, v=v, w=0.0)
    u = 0.0 if holds and abs(r[i] - s) < NEAR else servo(p.scheme, signals, p.gains[i])
    return Joint(a=a, error=seen, holding=holds), u
