"""What the operator's levers ask for: tip velocity, joint rates, and what the governor leaves of them."""

from forest_control.config.settings import Parameters
from forest_control.limits import workspace
from forest_control.limits.actuator_speed_limits import greatest_rates
from forest_control.limits.singularity import rates_anywhere
from forest_control.limits.velocity_scaling import Governed, GovernorParameters, Limit, govern
from forest_control.operator.levers import joint_rate_wish
from forest_control.operator.operator_profile import (
    JOINT_ACCELERATION,
    Mode,
    joint_following,
    shaped,
    tip_following,
    tip_rate,
)
from forest_control.pipeline.control_state import Inputs, State, Wish, scaled
from forest_control.servo import coordinated_servo
from forest_control.servo.schemes import Scheme, closes_on_position
from forest_control.valve.tracking_limit import AS_FILED, Valves, ceiling
from forest_description.geometry.kinematics import is_singular, tip_position, tip_velocity
from forest_description.types import ZERO, Vec3


def wished_velocity(state: State, pose: Vec3, inputs: Inputs, p: Parameters, dt: float) -> Vec3:
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
    return coordinated_servo.ramped(state.memory.velocity, wish, p.coordinated.acceleration, dt)


def wished_rates(state: State, pose: Vec3, velocity: Vec3, inputs: Inputs, p: Parameters, dt: float) -> Vec3:
    """Return the joint rates [rad/s] of a wished tip velocity, or in the joint scheme the levers' own."""
    if p.scheme != Scheme.JOINT:
        return rates_anywhere(pose, velocity, p.links)
    levers = shaped(inputs.levers, p.hand)
    if p.hand.mode == Mode.RATE:
        return joint_rate_wish(levers, p.governor.rates)
    wish = joint_following(levers, state.clutch, inputs.angles, p.hand, p.governor.rates)
    before = state.memory.swing.a, state.memory.boom.a, state.memory.stick.a
    return coordinated_servo.ramped(before, wish, JOINT_ACCELERATION, dt)


def governed_wish(
    pose: Vec3, angles: Vec3, rates: Vec3, velocity: Vec3, valves: Valves, p: Parameters
) -> Wish:
    """Return what the scheme shall do, governed.

    Args:
        pose: where J^-1 is taken [rad].
        angles: measured; the limits count from here for a scheme that does not hold its reference.
        rates: wished of the joints [rad/s].
        velocity: wished of the tip [m/s].
        valves: what is known of them.
        p: parameters.
    """
    place = pose if closes_on_position(p.scheme) else angles
    governed = govern(place, rates, governor_at(place, rates, p, valves))
    if p.scheme == Scheme.JOINT:
        left = workspace.share(
            tip_position(angles, p.links), tip_velocity(angles, rates, p.links), p.workspace
        )
        if left < governed.factor:
            governed = Governed(left, Limit.WALL)
    a = scaled(rates, governed.factor)
    if p.scheme != Scheme.JOINT and is_singular(pose, p.links):
        # Out of it the tip goes where the joints take it.
        return Wish(a, tip_velocity(pose, a, p.links), Governed(governed.factor, Limit.SINGULARITY))
    return Wish(a, scaled(velocity, governed.factor), governed)


def governor_at(angles: Vec3, wished: Vec3, p: Parameters, valves: Valves = AS_FILED) -> GovernorParameters:
    """Return the governor's limits at a pose [rad] for wished joint rates [rad/s].

    The coordinated scheme asks the valves for no more than they can give against the crane's weight, where
    the others leave them saturated; and no joint to go faster than one that cannot follow.
    """
    if p.scheme != Scheme.COORDINATED:
        return p.governor
    most, rates = greatest_rates(angles, wished, p.capacity, valves.reach), p.governor.rates
    strains = valves.strains
    least = (
        min(rates[0], most[0], ceiling(strains.swing, wished[0])),
        min(rates[1], most[1], ceiling(strains.boom, wished[1])),
        min(rates[2], most[2], ceiling(strains.stick, wished[2])),
    )
    return p.governor._replace(rates=least)
