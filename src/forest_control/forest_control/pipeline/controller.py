"""From the operator's levers to commands for ideal valves: one step of the controller, in five stages.

    levers, measured state -> estimate -> command -> limit -> servo -> output -> ideal valve voltage

| stage | question | file |
|---|---|---|
| estimate | where are the links, which joint cannot follow, what hangs there? | `link_bending` ... |
| command | what do the levers ask for, or the stop without them? | `motion_command` |
| limit | what may the machine do of it? | `motion_limits` |
| servo | which joint rates bring it there? | `joint_servo` |
| output | which voltages of ideal valves are these? | here |

A command of the valve's rated voltage (10 V on the C-180) asks for the actuator speed that the fully open
valve gives at no load (`rated_speeds`); the driver makes the real valve behave so. Schemes, modes and gains
may change while the crane moves (`bumpless_transfer`).
"""

from forest_control.config.controller_settings import Parameters
from forest_control.limits.load_moment import believed_mass, loading
from forest_control.limits.load_weighing import weighed
from forest_control.pipeline import stop_profile
from forest_control.pipeline.bumpless_transfer import begun, faded, relearnt
from forest_control.pipeline.control_state import (
    NO_MODE,
    Inputs,
    MotionCommand,
    Output,
    Phase,
    Reference,
    Servo,
    State,
    Telemetry,
)
from forest_control.pipeline.joint_servo import joint_servo
from forest_control.pipeline.motion_command import motion_command
from forest_control.pipeline.motion_limits import limited
from forest_control.pipeline.stop_profile import NO_STOP
from forest_control.servo import coordinated_servo
from forest_control.servo.joint_angle_filter import corrected_angles, latched_correction, updated_correction
from forest_control.servo.link_bending import link_angles
from forest_control.servo.schemes import Scheme
from forest_control.valve.tracking_limit import NO_TRACKING_LIMIT, TrackingLimits, Valves, updated_limits
from forest_description.derived.actuator_kinematics import joint_rates_to_actuator_speeds
from forest_description.geometry.kinematics import tip_orientation, tip_position, tip_velocity
from forest_description.geometry.vectors import minus, plus
from forest_description.types import ZERO, Vec3


def step(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Output]:
    """Advance the controller by dt [s]."""
    state, inputs = _estimate(state, inputs, p, dt)
    state, command = motion_command(state, inputs, p, dt)
    load = loading(state.weighing.mass, inputs.angles, p.links, p.capacity)
    counted = loading(state.weighing.counted, inputs.angles, p.links, p.capacity)
    reference = limited(command, Valves(inputs.opening_ratio, state.tracking_limits), counted, inputs, p)
    servo = joint_servo(command, reference, state, inputs, p, dt)
    state, output = _output(command, reference, servo, state, inputs, p, dt)
    return state, output._replace(loading=load)


def step_with_telemetry(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Telemetry]:
    """Do as `step`, and tell where the tip is and how it moves, by the angles that count."""
    state, output = step(state, inputs, p, dt)
    angles = counted_angles(inputs.angles, state, p)
    velocity = tip_velocity(angles, inputs.rates, p.links)
    return state, Telemetry(output, tip_position(angles, p.links), tip_orientation(angles), velocity)


def counted_angles(measured: Vec3, state: State, p: Parameters) -> Vec3:
    """Return the angles [rad] that count for measured ones: corrected, and of links that bend."""
    return _of_links(corrected_angles(measured, state.correction), state.weighing.mass, p)


def _of_links(joints: Vec3, mass: float, p: Parameters) -> Vec3:
    """Return the links' angles for their joints' [rad] and a weighed mass [kg], as far as it is believed."""
    hung = believed_mass(mass, p.weighing.empty_head, joints, p.links, p.capacity)
    return link_angles(joints, hung, p.speed_limits, p.coordinated.arm)


def _estimate(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Inputs]:
    """Return the state with what is known of angles and valves, and the inputs with the angles that count."""
    correction = updated_correction(state.correction, inputs.angles, inputs.cylinders, p.linkages, dt)
    if not state.enabled and stop_profile.is_over(state.stop):
        correction = latched_correction(correction, p.position_source)
    joints = corrected_angles(inputs.angles, correction)
    weighing = weighed(state.weighing, joints, inputs.rates, inputs.boom_pressures, p.weighing, dt)
    inputs = inputs._replace(angles=_of_links(joints, weighing.mass, p))
    state = relearnt(state, correction)
    return state._replace(
        correction=correction, tracking_limits=_tracking_limits(state, inputs, p, dt), weighing=weighing
    ), inputs


def _tracking_limits(state: State, inputs: Inputs, p: Parameters, dt: float) -> TrackingLimits:
    """Return which joints cannot follow the reference; none of a scheme that does not hold one."""
    if state.scheme != Scheme.COORDINATED or p.scheme != Scheme.COORDINATED:
        return NO_TRACKING_LIMIT
    a, e = coordinated_servo.reference_rates(state.memory), minus(state.reference, inputs.angles)
    volts, axes = inputs.voltages, p.speed_limits.axes
    return updated_limits(state.tracking_limits, volts, p.rated_voltages, axes, a, e, inputs.rates, dt)


def _output(
    command: MotionCommand,
    reference: Reference,
    servo: Servo,
    state: State,
    inputs: Inputs,
    p: Parameters,
    dt: float,
) -> tuple[State, Output]:
    """Return the state after a step, and the voltages of its rates."""
    if command.phase == Phase.STANDING:
        return begun(state, inputs.angles)._replace(enabled=False), Output(ZERO, ZERO, reference.scaling)
    enabled = command.phase == Phase.SETTLING or command.phase == Phase.MOVING
    after = state._replace(
        reference=servo.reference,
        enabled=enabled,
        memory=servo.memory,
        scheme=p.scheme,
        rates=servo.rates,
        offset=faded(servo.offset, dt),
        mode=p.profile.mode if enabled else NO_MODE,
        clutch=state.clutch if enabled else ZERO,
        changed=False,
        stop=NO_STOP if enabled else state.stop,
    )
    if command.phase == Phase.SETTLING:
        return after._replace(clutch=servo.reference), Output(ZERO, ZERO, reference.scaling)
    # An inch is commanded, but not remembered: what takes over from it takes nothing of it over.
    rates = plus(servo.rates, coordinated_servo.inches(servo.memory)) if enabled else servo.rates
    voltage = to_voltage(rates, inputs.angles, p)
    velocity = ZERO if p.scheme == Scheme.JOINT else servo.velocity
    return after, Output(voltage, velocity, reference.scaling)


def to_voltage(rates: Vec3, angles: Vec3, p: Parameters) -> Vec3:
    """Return the ideal valves' voltages for joint rates [rad/s], clipped at the rating. Thesis eq. 3.16."""
    speeds = joint_rates_to_actuator_speeds(angles, rates, p.linkages)
    return _volts(speeds[0], 0, p), _volts(speeds[1], 1, p), _volts(speeds[2], 2, p)


def _volts(speed: float, i: int, p: Parameters) -> float:
    rated = p.rated_voltages[i]
    return max(-rated, min(rated, rated * speed / p.rated_speeds[i]))
