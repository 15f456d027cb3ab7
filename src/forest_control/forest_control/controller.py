"""From the operator's levers to commands for ideal valves: the controller's core.

    levers -> wish -> J^-1 or IK -> governor -> servo -> lever arms -> ideal valve voltage

A command of the valve's rated voltage (10 V on the C-180) asks for the actuator speed that the fully open
valve gives at no load (`rated_speeds`); the driver makes the real valve behave so. When the wish is no longer
enabled the tip stops along its path (`stopping`); then the command is zero and the reference rests on the
machine.

**Live changes.** All schemes remember the same: a reference pose and what was commanded last. A scheme that
takes over starts from the pose at which it would command just that, where there is one; what remains of the
difference is added to its command and fades (`HAND_OVER`).
"""

from typing import NamedTuple

from forest_control import coordination, stopping, workspace
from forest_control.capacity import greatest_rates
from forest_control.governor import Governed, GovernorParameters, Limit, govern
from forest_control.hand import JOINT_ACCELERATION, Mode, joint_following, shaped, tip_following, tip_rate
from forest_control.levers import Levers, joint_rate_wish
from forest_control.schemes import (
    Scheme,
    Signals,
    advanced,
    closes_on_position,
    decayed,
    jacobian_pose,
    moved,
    reference_that_gives,
    servo,
)
from forest_control.settings import Parameters as Parameters
from forest_control.settings import Settings as Settings
from forest_control.settings import parameters as parameters
from forest_control.singularity import rates_anywhere
from forest_control.stopping import NO_STOP, Stop
from forest_description.actuation import joint_rates_to_actuator_speeds
from forest_description.kinematics import is_singular, joint_rates, tip_position, tip_velocity
from forest_description.machine import AXES

Triple = tuple[float, float, float]
ZERO: Triple = (0.0, 0.0, 0.0)
BEYOND_LIMIT = 0.1  # [rad] outside the joint limits: end stops give, encoders are not perfect
FASTEST = 5.0  # [rad/s] no joint of such a crane moves faster
HAND_OVER = 0.2  # [s] in which the difference between two schemes' commands fades
NEAR = 0.002  # [rad] of the reference, where a position servo at rest may leave its valve shut
NO_SCHEME = NO_MODE = -1


class State(NamedTuple):
    """What the controller remembers."""

    reference: Triple  # r [rad]
    enabled: bool
    memory: coordination.Memory = coordination.REST
    scheme: int = NO_SCHEME  # that was in charge
    rates: Triple = ZERO  # u [rad/s], commanded last
    offset: Triple = ZERO  # [rad/s] added to the servo's, and fading
    mode: int = NO_MODE  # that was in force
    clutch: Triple = ZERO  # [rad] the pose that position mode moves about
    changed: bool = False  # somebody changed a parameter: what it does to the command shall fade, too
    stop: Stop = NO_STOP  # along the path, under way or over


class Inputs(NamedTuple):
    """What arrives in a step."""

    angles: Triple  # s [rad], measured
    rates: Triple  # v [rad/s], measured
    levers: Levers
    enabled: bool  # a fresh, finite, held deadman


class Output(NamedTuple):
    """What leaves in a step."""

    command: Triple  # [V] of ideal valves, as applied
    tip_wish: Triple  # [m/s], governed
    governed: Governed


class Wish(NamedTuple):
    """What the scheme is asked for, governed."""

    rates: Triple  # a [rad/s]
    velocity: Triple  # x' [m/s]
    governed: Governed


REST = State(ZERO, False)


def step(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Output]:
    """Advance the controller by dt [s]."""
    if not inputs.enabled:
        return _stopping(state, inputs, p, dt)
    if not state.enabled and not stopping.is_over(state.stop):
        state = _resumed(state)
    elif not state.enabled:
        state = _begun(inputs.angles, True)
    if state.scheme != NO_SCHEME and state.scheme != p.scheme:
        state = _taken_over(state, inputs, p)
    state = _clutched(state, inputs.angles, p)
    pose = jacobian_pose(p.scheme, state.reference, inputs.angles, p.jacobian_at_joints)
    velocity = _wished_velocity(state, pose, inputs, p, dt)
    if (
        p.scheme == Scheme.COORDINATED
        and velocity == ZERO
        and state.memory.samples < coordination.MOST_SAMPLES
    ):
        reference, memory = coordination.settle(state.reference, inputs.angles, state.memory)
        state = State(reference, True, memory, p.scheme, ZERO, ZERO, p.hand.mode, reference, False, NO_STOP)
        return state, Output(ZERO, ZERO, Governed(1.0, Limit.NONE))
    free = velocity
    velocity = workspace.slid(tip_position(pose, p.links), free, p.workspace)
    rates = _wished_rates(state, pose, velocity, inputs, p, dt)
    wish = _governed_wish(pose, inputs.angles, rates, velocity, p)
    if velocity != free and wish.governed.limit == Limit.NONE:
        wish = Wish(wish.rates, wish.velocity, Governed(wish.governed.factor, Limit.WALL))
    return _commanded(state, wish, pose, inputs, p, dt)


def _begun(angles: Triple, enabled: bool) -> State:
    """Return the state of a machine at rest; a compiler knows no defaults."""
    return State(angles, enabled, coordination.REST, NO_SCHEME, ZERO, ZERO, NO_MODE, ZERO, False, NO_STOP)


def _resumed(state: State) -> State:
    """Return the state of a machine that was stopping, and shall not."""
    r, m, u = state.reference, state.memory, state.rates
    return State(r, True, m, state.scheme, u, state.offset, NO_MODE, state.clutch, True, NO_STOP)


def _clutched(state: State, s: Triple, p: Parameters) -> State:
    """Return the state with the clutch where the machine is, if another mode was in force."""
    if state.mode == p.hand.mode:
        return state
    clutch = state.reference if closes_on_position(p.scheme) else s
    changed = state.changed or state.mode != NO_MODE
    r, m, u = state.reference, state.memory, state.rates
    return State(r, True, m, state.scheme, u, state.offset, p.hand.mode, clutch, changed, NO_STOP)


def _stopping(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Output]:
    """Advance the stop along the path; once it is over the command is zero."""
    stop = stopping.advanced(_stop_from(state, inputs.angles, p) if state.enabled else state.stop, dt)
    if stopping.is_over(stop) or state.scheme != p.scheme:
        return _begun(inputs.angles, False), Output(ZERO, ZERO, Governed(0.0, Limit.RELEASED))
    if stop.duration == stopping.CLOSED_LOOP:
        return _stopping_at_reference(stop, state, inputs, p, dt)
    s = inputs.angles
    rates, velocity = stopping.commanded(stop, s, p.links)
    factor = govern(s, rates, p.governor).factor
    rates, velocity = _scale(rates, factor), _scale(velocity, factor)
    wish = ZERO if p.scheme == Scheme.JOINT else velocity
    output = Output(_to_voltage(rates, s, p), wish, Governed(factor, Limit.RELEASED))
    memory = coordination.in_motion(velocity, rates, coordination.MOST_SAMPLES)
    return State(s, False, memory, p.scheme, rates, ZERO, NO_MODE, ZERO, False, stop), output


def _stopping_at_reference(
    stop: Stop, state: State, inputs: Inputs, p: Parameters, dt: float
) -> tuple[State, Output]:
    """Advance the stop of a scheme that follows its reference to the end."""
    r = state.reference
    velocity = _scale(stop.wish, stopping.share(stop))
    velocity = workspace.slid(tip_position(r, p.links), velocity, p.workspace)
    wish = _governed_wish(r, inputs.angles, joint_rates(r, velocity, p.links), velocity, p)
    after, output = _commanded(state, wish, r, inputs, p, dt)
    released = Governed(wish.governed.factor, Limit.RELEASED)
    m, u = after.memory, after.rates
    after = State(after.reference, False, m, p.scheme, u, after.offset, NO_MODE, ZERO, False, stop)
    return after, Output(output.command, output.tip_wish, released)


def _stop_from(state: State, s: Triple, p: Parameters) -> Stop:
    """Return the stop of a scheme at measured angles [rad]; none when nothing was commanded."""
    if state.rates == ZERO and state.memory.velocity == ZERO:
        return NO_STOP
    away = _minus(state.reference, s)
    near = max(abs(away[0]), abs(away[1]), abs(away[2])) < stopping.ASTRAY
    closed = p.scheme == Scheme.COORDINATED and near
    duration = stopping.CLOSED_LOOP if closed else stopping.OPEN_LOOP
    return stopping.begin(duration, state.rates, state.memory.velocity, s, p.links)


def _wished_velocity(state: State, pose: Triple, inputs: Inputs, p: Parameters, dt: float) -> Triple:
    """Return the tip velocity [m/s] that the levers ask for; a ramp in position mode or coordinated."""
    if p.scheme == Scheme.JOINT:
        return ZERO
    levers = shaped(inputs.levers, p.hand)
    if p.hand.mode == Mode.POSITION:
        here = state.reference if closes_on_position(p.scheme) else inputs.angles
        wish = tip_following(levers, state.clutch, here, p.hand, p.links)
    else:
        wish = tip_rate(levers, pose, p.hand)
        if p.scheme != Scheme.COORDINATED:
            return wish
    return coordination.ramped(state.memory.velocity, wish, p.coordinated.acceleration, dt)


def _wished_rates(
    state: State, pose: Triple, velocity: Triple, inputs: Inputs, p: Parameters, dt: float
) -> Triple:
    """Return the joint rates [rad/s] of a wished tip velocity, or in the joint scheme the levers' own."""
    if p.scheme != Scheme.JOINT:
        return rates_anywhere(pose, velocity, p.links)
    levers = shaped(inputs.levers, p.hand)
    if p.hand.mode == Mode.RATE:
        return joint_rate_wish(levers, p.governor.rates)
    wish = joint_following(levers, state.clutch, inputs.angles, p.hand, p.governor.rates)
    before = state.memory.swing.a, state.memory.boom.a, state.memory.stick.a
    return coordination.ramped(before, wish, JOINT_ACCELERATION, dt)


def _governed_wish(pose: Triple, angles: Triple, rates: Triple, velocity: Triple, p: Parameters) -> Wish:
    """Return what the scheme shall do, governed.

    Args:
        pose: where J^-1 is taken [rad].
        angles: measured; the limits count from here for a scheme that does not hold its reference.
        rates: wished of the joints [rad/s].
        velocity: wished of the tip [m/s].
        p: parameters.
    """
    place = pose if closes_on_position(p.scheme) else angles
    governed = govern(place, rates, governor_at(place, rates, p))
    if p.scheme == Scheme.JOINT:
        left = workspace.share(
            tip_position(angles, p.links), tip_velocity(angles, rates, p.links), p.workspace
        )
        if left < governed.factor:
            governed = Governed(left, Limit.WALL)
    a = _scale(rates, governed.factor)
    if p.scheme != Scheme.JOINT and is_singular(pose, p.links):
        # Out of it the tip goes where the joints take it.
        return Wish(a, tip_velocity(pose, a, p.links), Governed(governed.factor, Limit.SINGULARITY))
    return Wish(a, _scale(velocity, governed.factor), governed)


def _commanded(
    state: State, wish: Wish, pose: Triple, inputs: Inputs, p: Parameters, dt: float
) -> tuple[State, Output]:
    """Return the state and the output of a step that carries out a governed wish."""
    r, s, a = state.reference, inputs.angles, wish.rates
    after = _held(advanced(p.scheme, r, a, wish.velocity, p.links, dt), s, p)
    if p.scheme == Scheme.COORDINATED:
        before = coordination.going(state.memory, wish.velocity)
        memory, u = coordination.servo(before, a, r, s, inputs.rates, p.coordinated, dt)
    else:
        memory, u = _servo(state.memory, wish, after, inputs, p, dt)
    offset = state.offset
    if state.changed or (state.scheme != NO_SCHEME and state.scheme != p.scheme):
        offset = _minus(state.rates, u)
    u = moved(u, offset, 1.0)
    tip_wish = wish.velocity
    if p.scheme == Scheme.COORDINATED and offset != ZERO:
        # The reference goes the way that is commanded, or the servo would fight what fades.
        after = _held(moved(after, offset, dt), s, p)
        tip_wish = moved(tip_wish, tip_velocity(pose, offset, p.links), 1.0)
    fading = (
        decayed(offset[0], dt, HAND_OVER),
        decayed(offset[1], dt, HAND_OVER),
        decayed(offset[2], dt, HAND_OVER),
    )
    output = Output(_to_voltage(u, s, p), tip_wish, wish.governed)
    return State(after, True, memory, p.scheme, u, fading, p.hand.mode, state.clutch, False, NO_STOP), output


def _taken_over(state: State, inputs: Inputs, p: Parameters) -> State:
    """Return the state that the chosen scheme starts from, another one having been in charge."""
    s, v, u, g = inputs.angles, inputs.rates, state.rates, p.gains
    still = state.memory.velocity == ZERO and _is_rest(state.memory)
    r = s
    if closes_on_position(p.scheme) and (still or p.scheme != Scheme.COORDINATED):
        r = (
            reference_that_gives(p.scheme, u[0], s[0], v[0], g[0]),
            reference_that_gives(p.scheme, u[1], s[1], v[1], g[1]),
            reference_that_gives(p.scheme, u[2], s[2], v[2], g[2]),
        )
    a = state.memory.swing.a, state.memory.boom.a, state.memory.stick.a
    velocity = tip_velocity(s, a, p.links) if state.scheme == Scheme.JOINT else state.memory.velocity
    shut = max(abs(u[0]), abs(u[1]), abs(u[2])) <= coordination.HELD
    samples = 0 if still and shut else coordination.MOST_SAMPLES
    r = _held(r, s, p)
    if state.scheme != Scheme.JOINT:
        a = joint_rates(r, velocity, p.links)  # else the lead would take the other pose's rates for a jerk
    memory = coordination.in_motion(velocity, a, samples)
    return State(
        r, True, memory, state.scheme, u, state.offset, state.mode, state.clutch, state.changed, NO_STOP
    )


def _is_rest(memory: coordination.Memory) -> bool:
    """Tell whether no joint is wished to move."""
    return memory.swing.a == 0.0 and memory.boom.a == 0.0 and memory.stick.a == 0.0


def governor_at(angles: Triple, wished: Triple, p: Parameters) -> GovernorParameters:
    """Return the governor's limits at a pose [rad] for wished joint rates [rad/s].

    The coordinated scheme asks the valves for no more than they can give against the crane's weight, where
    the others leave them saturated.
    """
    if p.scheme != Scheme.COORDINATED:
        return p.governor
    most, rates = greatest_rates(angles, wished, p.capacity), p.governor.rates
    least = min(rates[0], most[0]), min(rates[1], most[1]), min(rates[2], most[2])
    g = p.governor
    return GovernorParameters(g.lower, g.upper, least, g.approach, g.pumps, g.axis)


def plausible(angles: Triple, rates: Triple, p: Parameters) -> bool:
    """Tell whether a measured state can be true; `implausible` says what of it cannot."""
    for i in range(3):
        low, high = p.governor.lower[i] - BEYOND_LIMIT, p.governor.upper[i] + BEYOND_LIMIT
        if not low <= angles[i] <= high or not abs(rates[i]) <= FASTEST:
            return False
    return True


def implausible(angles: tuple[float, ...], rates: tuple[float, ...], p: Parameters) -> str:
    """Return what cannot be true of a measured state, or "": degrees for radians, a broken encoder, no rates.

    Args:
        angles: joint angles [rad]; at most `BEYOND_LIMIT` outside the joint limits.
        rates: joint rates [rad/s]; at most `FASTEST`.
        p: the controller's parameters.
    """
    if len(rates) != len(AXES):
        return "joint state: no finite velocity; allowed: rad/s of every joint"
    for i, name in enumerate(AXES):
        low, high = p.governor.lower[i] - BEYOND_LIMIT, p.governor.upper[i] + BEYOND_LIMIT
        if not low <= angles[i] <= high:
            return f"joint state: {name} is {angles[i]:g} rad; allowed: {low:.3f} .. {high:.3f}"
        if not abs(rates[i]) <= FASTEST:
            return f"joint state: {name} moves at {rates[i]:g} rad/s; allowed: up to {FASTEST:g}"
    return ""


def _held(r: Triple, s: Triple, p: Parameters) -> Triple:
    """Return reference angles [rad] within `lead` of the joints and inside their limits."""
    return _held_joint(r[0], s[0], 0, p), _held_joint(r[1], s[1], 1, p), _held_joint(r[2], s[2], 2, p)


def _held_joint(r: float, s: float, i: int, p: Parameters) -> float:
    lower, upper = min(p.governor.lower[i], s), max(p.governor.upper[i], s)
    return max(lower, min(upper, max(s - p.lead, min(s + p.lead, r))))


def _servo(
    memory: coordination.Memory, wish: Wish, r: Triple, inputs: Inputs, p: Parameters, dt: float
) -> tuple[coordination.Memory, Triple]:
    """Return the memory, and the joint rates [rad/s] that a scheme of the thesis commands at a reference."""
    still = closes_on_position(p.scheme) and coordination.rests(memory, wish.rates)
    swing, u_1 = _joint_servo(memory.swing, 0, still, wish, r, inputs, p, dt)
    boom, u_2 = _joint_servo(memory.boom, 1, still, wish, r, inputs, p, dt)
    stick, u_3 = _joint_servo(memory.stick, 2, still, wish, r, inputs, p, dt)
    return coordination.Memory(wish.velocity, swing, boom, stick, 0.0, 0), (u_1, u_2, u_3)


def _joint_servo(
    memory: coordination.Joint,
    i: int,
    still: bool,
    wish: Wish,
    r: Triple,
    inputs: Inputs,
    p: Parameters,
    dt: float,
) -> tuple[coordination.Joint, float]:
    """Return one joint's memory and rate [rad/s]; where it rests at its reference, its valve stays shut."""
    a, s, v = wish.rates[i], inputs.angles[i], inputs.rates[i]
    seen, holds, wide, side = coordination.held(memory, r[i] - s, still, p.coordinated, dt)
    u = (
        0.0
        if holds and abs(r[i] - s) < NEAR
        else servo(p.scheme, Signals(a, 0.0, r[i], s, v, 0.0), p.gains[i])
    )
    return coordination.Joint(a, 0.0, 0.0, seen, holds, wide, side), u


def _to_voltage(rates: Triple, angles: Triple, p: Parameters) -> Triple:
    """Return the ideal valves' voltages for joint rates [rad/s], clipped at the rating. Thesis eq. 3.16."""
    speeds = joint_rates_to_actuator_speeds(angles, rates, p.linkages)
    return _volts(speeds[0], 0, p), _volts(speeds[1], 1, p), _volts(speeds[2], 2, p)


def _volts(speed: float, i: int, p: Parameters) -> float:
    rated = p.rated_voltages[i]
    return max(-rated, min(rated, rated * speed / p.rated_speeds[i]))


def _minus(x: Triple, y: Triple) -> Triple:
    return x[0] - y[0], x[1] - y[1], x[2] - y[2]


def _scale(values: Triple, factor: float) -> Triple:
    return factor * values[0], factor * values[1], factor * values[2]
