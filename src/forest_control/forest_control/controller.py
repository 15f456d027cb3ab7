"""From the operator's levers to commands for ideal valves: the controller's core.

    levers -> wish -> J^-1 -> governor -> scheme -> lever arms -> ideal valve voltage

A command of the valve's rated voltage (10 V on the C-180) asks for the actuator speed that the fully open
valve gives at no load (`rated_speeds`); the driver makes the real valve behave so. Without an enabled wish
the command is zero and the reference rests on the machine.
"""

import math
from typing import NamedTuple

from forest_control import coordination
from forest_control.capacity import Capacity, capacity, greatest_rates
from forest_control.coordination import CoordinationParameters
from forest_control.governor import Governed, GovernorParameters, Limit, govern
from forest_control.levers import Levers, joint_rate_wish, tip_velocity_wish
from forest_control.schemes import Gains, Scheme, jacobian_position, jacobian_velocity, joint
from forest_control.swing_load import swing_load
from forest_control.valve_driver import axis_drivers
from forest_description.actuation import Linkages, joint_rates_to_actuator_speeds, rated_speeds
from forest_description.kinematics import Links, is_singular, joint_rates, tip_velocity
from forest_description.limits import joint_limits
from forest_description.machine import AXES, Machine

Triple = tuple[float, float, float]
ZERO: Triple = (0.0, 0.0, 0.0)
BEYOND_LIMIT = 0.1  # [rad] outside the joint limits: end stops give, encoders are not perfect
FASTEST = 5.0  # [rad/s] no joint of such a crane moves faster
SMOOTHING = 0.01  # [s] of the reference's acceleration
INTEGRAL_LIMIT = 0.1  # [rad/s] more than any valve is wrong by
HOLD_ERROR, RELEASE_ERROR = (
    1.5e-4,
    5e-4,
)  # [rad] above the resolvers' low-passed jitter; 1 and 3 mm of the tip
REST_RATE = 2e-3  # [rad/s] a smaller wish counts as none in scheme (c)


class Settings(NamedTuple):
    """What a user may set: the node's parameters and their defaults. Triples are swing, boom, stick."""

    scheme: Scheme = Scheme.JACOBIAN_POSITION
    tip_speed: float = 0.5  # [m/s] wished at full deflection, tip schemes
    joint_rates: Triple = (0.8, 0.25, 0.25)  # [rad/s] largest wish; at full deflection in the joint scheme
    velocity_gain: Triple = (0.313, 0.313, 0.313)  # K_v
    position_gain: Triple = (2.5, 5.0, 5.0)  # K_p [1/s]
    damping_gain: Triple = (0.0, 0.0, 0.0)  # K_d
    lead: float = 0.2  # [rad]
    feedback_gain: Triple = (4.0, 5.0, 5.0)  # K_p of the coordinated scheme [1/s]
    integral_gain: Triple = (2.0, 4.0, 4.0)  # K_i of the coordinated scheme [1/s^2]
    lead_time: Triple = (0.02, 0.013, 0.013)  # T [s]
    load_bandwidth: float = 1.0  # [Hz] of the valve driver's
    tip_acceleration: float = 4.0  # [m/s^2] of the coordinated scheme's reference: steps become ramps
    joint_margin: float = 0.0175  # [rad] kept from every joint limit
    approach: Triple = (1.0, 2.0, 2.0)  # [1/s] allowed rate per remaining angle before a joint limit


class Parameters(NamedTuple):
    """What the controller knows of machine and operator."""

    scheme: Scheme
    tip_speed: float  # [m/s] at full deflection
    gains: Gains
    governor: GovernorParameters
    lead: float  # [rad] the reference may run ahead of the joint, so that a stalled joint does not wind up
    links: Links
    linkages: Linkages
    rated_speeds: Triple  # [rad/s, m/s, m/s] of an ideal valve at its rated voltage
    rated_voltages: Triple  # [V] of each axis' valve
    coordinated: CoordinationParameters
    capacity: Capacity


class State(NamedTuple):
    """What the controller remembers."""

    reference: Triple  # [rad]
    enabled: bool
    memory: coordination.Memory = coordination.REST


class Inputs(NamedTuple):
    """What arrives in a step."""

    angles: Triple  # [rad], measured
    rates: Triple  # [rad/s], measured
    levers: Levers
    enabled: bool  # a fresh, finite, held deadman


class Output(NamedTuple):
    """What leaves in a step."""

    command: Triple  # [V] of ideal valves, as applied
    tip_wish: Triple  # [m/s], governed
    governed: Governed


REST = State(ZERO, False)


def step(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Output]:
    """Advance the controller by dt [s]."""
    if not inputs.enabled:
        return State(inputs.angles, False), Output(ZERO, ZERO, Governed(0.0, Limit.NONE))
    reference = state.reference if state.enabled else inputs.angles
    if p.scheme is Scheme.COORDINATED:
        return _coordinated_step(reference, state.memory, inputs, p, dt)
    # Scheme (d) holds a reference: with J^-1 taken there, it integrates the wish free of the joints' lag.
    pose = reference if p.scheme is Scheme.JACOBIAN_POSITION else inputs.angles
    wished, limit = _wished_rates(pose, inputs.levers, p)
    governed = govern(inputs.angles, wished, p.governor) if limit is Limit.NONE else Governed(0.0, limit)
    a = _scale(wished, governed.factor)
    reference = _advance(reference, a, inputs.angles, p, dt)
    command = _to_voltage(_servo(a, reference, inputs, p), inputs.angles, p)
    wish = ZERO if p.scheme is Scheme.JOINT else tip_velocity(pose, a, p.links)
    return State(reference, True), Output(command, wish, governed)


def _coordinated_step(
    reference: Triple, memory: coordination.Memory, inputs: Inputs, p: Parameters, dt: float
) -> tuple[State, Output]:
    """Advance the coordinated scheme: the tip's wish, ramped, governed, moves the pose that it is held at."""
    c = p.coordinated
    wish = coordination.ramped(
        memory.velocity, tip_velocity_wish(inputs.levers, p.tip_speed), c.acceleration, dt
    )
    if wish == ZERO and memory.samples < coordination.MOST_SAMPLES:
        reference, memory = coordination.settle(reference, inputs.angles, memory)
        return State(reference, True, memory), Output(ZERO, ZERO, Governed(1.0, Limit.NONE))
    memory = memory._replace(samples=coordination.MOST_SAMPLES)
    governed = Governed(0.0, Limit.SINGULARITY)
    if not is_singular(reference, p.links):
        wished = joint_rates(reference, wish, p.links)
        governed = govern(reference, wished, governor_at(reference, wished, p))
    velocity = _scale(wish, governed.factor)
    a = joint_rates(reference, velocity, p.links)
    # The rates half a step on: the tip's reference then stays on the integral of its velocity.
    middle = _plus(reference, a, 0.5 * dt)
    after = _advance(reference, joint_rates(middle, velocity, p.links), inputs.angles, p, dt)
    memory, u = coordination.servo(memory._replace(velocity=velocity), a, reference, inputs.angles, c, dt)
    command = _to_voltage(u, inputs.angles, p)
    return State(after, True, memory), Output(command, velocity, governed)


def governor_at(angles: Triple, wished: Triple, p: Parameters) -> GovernorParameters:
    """Return the governor's limits at a pose [rad] for wished joint rates [rad/s].

    The coordinated scheme asks the valves for no more than they can give against the crane's weight, where
    the others leave them saturated.
    """
    if p.scheme is not Scheme.COORDINATED:
        return p.governor
    most = greatest_rates(angles, wished, p.capacity)
    rates = tuple(min(rate, limit) for rate, limit in zip(p.governor.rates, most, strict=True))
    return p.governor._replace(rates=(rates[0], rates[1], rates[2]))


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


def _wished_rates(pose: Triple, levers: Levers, p: Parameters) -> tuple[Triple, Limit]:
    """Return the joint rates [rad/s] that the levers ask for at a pose [rad]."""
    if p.scheme is Scheme.JOINT:
        return joint_rate_wish(levers, p.governor.rates), Limit.NONE
    if is_singular(pose, p.links):
        return ZERO, Limit.SINGULARITY
    return joint_rates(pose, tip_velocity_wish(levers, p.tip_speed), p.links), Limit.NONE


def _advance(reference: Triple, a: Triple, angles: Triple, p: Parameters, dt: float) -> Triple:
    """Return the reference angles [rad] one step on, within `lead` of the joints and inside their limits."""
    r = []
    for i in range(3):
        s = angles[i]
        lower, upper = min(p.governor.lower[i], s), max(p.governor.upper[i], s)
        ahead = max(s - p.lead, min(s + p.lead, reference[i] + dt * a[i]))
        r.append(max(lower, min(upper, ahead)))
    return r[0], r[1], r[2]


def _servo(a: Triple, reference: Triple, inputs: Inputs, p: Parameters) -> Triple:
    """Return the commanded joint rates [rad/s] of the chosen scheme."""
    u = []
    for i in range(3):
        s, v = inputs.angles[i], inputs.rates[i]
        if p.scheme is Scheme.JACOBIAN_POSITION:
            u.append(jacobian_position(reference[i], s, v, p.gains.position[i], p.gains.damping[i]))
        elif p.scheme is Scheme.JACOBIAN_VELOCITY:
            # At rest the servo would chase what it hears of its own valve's opening, for ever.
            u.append(jacobian_velocity(a[i], v, p.gains.velocity[i]) if abs(a[i]) > REST_RATE else 0.0)
        else:
            u.append(joint(a[i]))
    return u[0], u[1], u[2]


def _to_voltage(rates: Triple, angles: Triple, p: Parameters) -> Triple:
    """Return the ideal valves' voltages for joint rates [rad/s], clipped at the rating. Thesis eq. 3.16."""
    speeds = joint_rates_to_actuator_speeds(angles, rates, p.linkages)
    volts = tuple(
        max(-volts, min(volts, volts * speed / rated))
        for speed, rated, volts in zip(speeds, p.rated_speeds, p.rated_voltages, strict=True)
    )
    return volts[0], volts[1], volts[2]


def _plus(angles: Triple, rates: Triple, dt: float) -> Triple:
    """Return angles [rad] moved on at rates [rad/s]."""
    return angles[0] + dt * rates[0], angles[1] + dt * rates[1], angles[2] + dt * rates[2]


def _scale(values: Triple, factor: float) -> Triple:
    return factor * values[0], factor * values[1], factor * values[2]


def parameters(machine: Machine, settings: Settings) -> Parameters:
    """Return the core's parameters for a machine."""
    limits, margin = joint_limits(machine), settings.joint_margin
    governor = GovernorParameters(
        lower=(limits[0][0] + margin, limits[1][0] + margin, limits[2][0] + margin),
        upper=(limits[0][1] - margin, limits[1][1] - margin, limits[2][1] - margin),
        rates=settings.joint_rates,
        approach=settings.approach,
    )
    return Parameters(
        scheme=settings.scheme,
        tip_speed=settings.tip_speed,
        gains=Gains(settings.velocity_gain, settings.position_gain, settings.damping_gain),
        governor=governor,
        lead=settings.lead,
        links=machine.manipulator.links,
        linkages=machine.linkages,
        rated_speeds=rated_speeds(machine),
        rated_voltages=(
            machine.valve_of(0).rated_voltage,
            machine.valve_of(1).rated_voltage,
            machine.valve_of(2).rated_voltage,
        ),
        capacity=capacity(machine, axis_drivers(machine)),
        coordinated=CoordinationParameters(
            feedback=settings.feedback_gain,
            integral=settings.integral_gain,
            lead_time=settings.lead_time,
            swing=swing_load(machine),
            load_bandwidth=2.0 * math.pi * settings.load_bandwidth,
            smoothing=SMOOTHING,
            acceleration=settings.tip_acceleration,
            integral_limit=INTEGRAL_LIMIT,
            hold_error=HOLD_ERROR,
            release_error=RELEASE_ERROR,
        ),
    )
