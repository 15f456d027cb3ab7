"""From the operator's levers to commands for ideal valves: the controller's core.

    levers -> wish -> J^-1 or IK -> governor -> servo -> lever arms -> ideal valve voltage
              `wish`                           `execution`

A command of the valve's rated voltage (10 V on the C-180) asks for the actuator speed that the fully open
valve gives at no load (`rated_speeds`); the driver makes the real valve behave so. When the wish is no longer
enabled the tip stops along its path (`stopping`); then the command is zero and the reference rests on the
machine. Schemes, modes and gains may change while it moves (`handover`).
"""

from forest_control.config.settings import Parameters as Parameters
from forest_control.config.settings import Settings as Settings
from forest_control.config.settings import parameters as parameters
from forest_control.limits import workspace
from forest_control.limits.velocity_scaling import Governed, Limit, govern
from forest_control.pipeline import stop_profile
from forest_control.pipeline.bumpless_transfer import clutched, relearnt, resumed, taken_over
from forest_control.pipeline.control_state import NO_MODE, NO_SCHEME, Wish, begun, minus, scaled
from forest_control.pipeline.control_state import REST as REST
from forest_control.pipeline.control_state import Inputs as Inputs
from forest_control.pipeline.control_state import Output as Output
from forest_control.pipeline.control_state import State as State
from forest_control.pipeline.control_state import Told as Told
from forest_control.pipeline.joint_servo import carried_out, to_voltage
from forest_control.pipeline.stop_profile import NO_STOP, Stop
from forest_control.pipeline.tip_velocity_command import governed_wish, wished_rates, wished_velocity
from forest_control.pipeline.tip_velocity_command import governor_at as governor_at
from forest_control.safety.state_checks import implausible as implausible
from forest_control.safety.state_checks import plausible as plausible
from forest_control.servo import coordinated_servo
from forest_control.servo.joint_angle_filter import corrected, latched, learnt
from forest_control.servo.schemes import Scheme, jacobian_pose
from forest_control.valve.tracking_limit import RELAXED, Strains, Valves, strained
from forest_description.geometry.kinematics import joint_rates, tip_orientation, tip_position, tip_velocity
from forest_description.types import ZERO, Vec3


def step(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Output]:
    """Advance the controller by dt [s]."""
    correction = learnt(state.correction, inputs.angles, inputs.cylinders, p.linkages, dt)
    if not state.enabled and stop_profile.is_over(state.stop):
        correction = latched(correction, p.position_source)
    inputs = inputs._replace(angles=corrected(inputs.angles, correction))
    state = relearnt(state, correction)
    strains = _strains(state, inputs, p, dt)
    state, output = _stepped(state, inputs, Valves(inputs.reach, strains), p, dt)
    return state._replace(correction=correction, strains=strains), output


def told(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Told]:
    """Do as `step`, and tell where the tip is and how it moves, by the angles that count."""
    state, output = step(state, inputs, p, dt)
    angles = corrected(inputs.angles, state.correction)
    velocity = tip_velocity(angles, inputs.rates, p.links)
    return state, Told(output, tip_position(angles, p.links), tip_orientation(angles), velocity)


def _strains(state: State, inputs: Inputs, p: Parameters, dt: float) -> Strains:
    """Return which joints cannot follow the reference; none of a scheme that does not hold one."""
    if state.scheme != Scheme.COORDINATED or p.scheme != Scheme.COORDINATED:
        return RELAXED
    m = state.memory
    a, e = (m.swing.a, m.boom.a, m.stick.a), minus(state.reference, inputs.angles)
    volts, axes = inputs.voltages, p.capacity.axes
    return strained(state.strains, volts, p.rated_voltages, axes, a, e, inputs.rates, dt)


def _stepped(state: State, inputs: Inputs, valves: Valves, p: Parameters, dt: float) -> tuple[State, Output]:
    """Advance all that goes by the corrected angles and what is known of the valves."""
    if not inputs.enabled:
        return _stopping(state, inputs, valves, p, dt)
    if not state.enabled and not stop_profile.is_over(state.stop):
        state = resumed(state)
    elif not state.enabled:
        state = begun(inputs.angles, True)
    if state.scheme != NO_SCHEME and state.scheme != p.scheme:
        state = taken_over(state, inputs, p)
    state = clutched(state, inputs.angles, p)
    pose = jacobian_pose(p.scheme, state.reference, inputs.angles, p.jacobian_at_joints)
    velocity = wished_velocity(state, pose, inputs, p, dt)
    if (
        p.scheme == Scheme.COORDINATED
        and velocity == ZERO
        and state.memory.samples < coordinated_servo.MOST_SAMPLES
    ):
        reference, memory = coordinated_servo.settle(state.reference, inputs.angles, state.memory)
        state = State(reference, True, memory, p.scheme, ZERO, ZERO, p.hand.mode, reference, False, NO_STOP)
        return state, Output(ZERO, ZERO, Governed(1.0, Limit.NONE))
    free = velocity
    velocity = workspace.slid(tip_position(pose, p.links), free, p.workspace)
    rates = wished_rates(state, pose, velocity, inputs, p, dt)
    wish = governed_wish(pose, inputs.angles, rates, velocity, valves, p)
    if velocity != free and wish.governed.limit == Limit.NONE:
        wish = Wish(wish.rates, wish.velocity, Governed(wish.governed.factor, Limit.WALL))
    return carried_out(state, wish, pose, inputs, p, dt)


def _stopping(state: State, inputs: Inputs, valves: Valves, p: Parameters, dt: float) -> tuple[State, Output]:
    """Advance the stop along the path; once it is over the command is zero."""
    stop = stop_profile.advanced(_stop_from(state, inputs.angles, p) if state.enabled else state.stop, dt)
    if stop_profile.is_over(stop) or state.scheme != p.scheme:
        return begun(inputs.angles, False), Output(ZERO, ZERO, Governed(0.0, Limit.RELEASED))
    if stop.duration == stop_profile.CLOSED_LOOP:
        return _stopping_at_reference(stop, state, inputs, valves, p, dt)
    s = inputs.angles
    rates, velocity = stop_profile.commanded(stop, s, p.links)
    factor = govern(s, rates, p.governor).factor
    rates, velocity = scaled(rates, factor), scaled(velocity, factor)
    wish = ZERO if p.scheme == Scheme.JOINT else velocity
    output = Output(to_voltage(rates, s, p), wish, Governed(factor, Limit.RELEASED))
    memory = coordinated_servo.in_motion(velocity, rates, coordinated_servo.MOST_SAMPLES)
    return State(s, False, memory, p.scheme, rates, ZERO, NO_MODE, ZERO, False, stop), output


def _stopping_at_reference(
    stop: Stop, state: State, inputs: Inputs, valves: Valves, p: Parameters, dt: float
) -> tuple[State, Output]:
    """Advance the stop of a scheme that follows its reference to the end."""
    if state.enabled:
        state = state._replace(reference=inputs.angles)
    r = state.reference
    tip, left, late = tip_position(r, p.links), stop_profile.share(stop), stop_profile.share_late(stop)
    velocity = workspace.slid(tip, scaled(stop.wish, left), p.workspace)
    wish = governed_wish(r, inputs.angles, joint_rates(r, velocity, p.links), velocity, valves, p)
    followed = scaled(workspace.slid(tip, scaled(stop.wish, late), p.workspace), wish.governed.factor)
    wish = Wish(wish.rates, followed, wish.governed)
    after, output = carried_out(state, wish, r, inputs, _braking(p), dt)
    released = Governed(wish.governed.factor, Limit.RELEASED)
    m, u = after.memory, stop_profile.onwards(after.rates, wish.rates)
    after = State(after.reference, False, m, p.scheme, u, after.offset, NO_MODE, ZERO, False, stop)
    return after, Output(to_voltage(u, inputs.angles, p), output.tip_wish, released)


def _braking(p: Parameters) -> Parameters:
    """Return the parameters of a stop: the oil for the swing's damping, fed forward, brakes it too much."""
    c = p.coordinated
    swing, boom, stick = c.gains
    lead = max(0.0, swing.lead_time - c.swing.damping / c.swing.stiffness)
    return p._replace(coordinated=c._replace(gains=(swing._replace(lead_time=lead), boom, stick)))


def _stop_from(state: State, s: Vec3, p: Parameters) -> Stop:
    """Return the stop of a scheme at measured angles [rad]; none when nothing was commanded."""
    if state.rates == ZERO and state.memory.velocity == ZERO:
        return NO_STOP
    away = minus(state.reference, s)
    near = max(abs(away[0]), abs(away[1]), abs(away[2])) < stop_profile.ASTRAY
    closed = p.scheme == Scheme.COORDINATED and near
    duration = stop_profile.CLOSED_LOOP if closed else stop_profile.OPEN_LOOP
    return stop_profile.begin(duration, state.rates, state.memory.velocity, s, p.links)
