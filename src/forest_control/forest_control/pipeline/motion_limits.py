"""The limit stage: what walls, the machine's limits and its valves leave of a command.

Walls take from the tip's velocity what is too fast towards them, and a load near the crane's capacity what
would load it further (`load_moment`). Then J^-1 makes joint rates of it, and one factor scales them all, so
that the tip keeps its direction (`velocity_scaling`).
"""

from forest_control.config.controller_settings import Parameters
from forest_control.limits import workspace
from forest_control.limits.actuator_speed_limits import joint_rate_limits
from forest_control.limits.load_moment import Loading, load_scale, unloaded
from forest_control.limits.singularity import rates_near_singularity
from forest_control.limits.velocity_scaling import Limit, VelocityLimits, VelocityScaling, velocity_scaling
from forest_control.pipeline.control_state import Inputs, MotionCommand, Phase, Reference
from forest_control.servo.schemes import Scheme, closes_on_position
from forest_control.valve.tracking_limit import AS_FILED, Valves, ceiling
from forest_description.geometry.kinematics import is_singular, joint_rates, tip_position, tip_velocity
from forest_description.geometry.vectors import norm, scaled
from forest_description.types import ZERO, Vec3


def limited(
    command: MotionCommand, valves: Valves, load: Loading, inputs: Inputs, p: Parameters
) -> Reference:
    """Return the reference that a command leaves, and what holds it back."""
    if command.phase == Phase.STANDING:
        standing = Limit.OVERLOAD if inputs.overloaded else Limit.RELEASED
        return Reference(ZERO, ZERO, VelocityScaling(0.0, standing))
    if command.phase == Phase.SETTLING:
        return Reference(ZERO, ZERO, VelocityScaling(1.0, Limit.NONE))
    if command.phase == Phase.BRAKING:
        factor = velocity_scaling(inputs.angles, command.rates, p.velocity_limits).factor
        released = VelocityScaling(factor, Limit.RELEASED)
        return Reference(scaled(command.rates, factor), scaled(command.velocity, factor), released)
    if command.phase == Phase.STOPPING:
        return _stopping(command, valves, inputs, p)
    reference = _moving(command, valves, load, inputs, p)
    factor, limit = reference.scaling
    return reference._replace(scaling=VelocityScaling(factor * _share(command), limit))


def _share(command: MotionCommand) -> float:
    """Return what the limits of former steps have left of the tip's velocity, 0..1."""
    wish = norm(command.wish)
    return min(1.0, norm(command.velocity) / wish) if wish > 0.0 else 1.0


def _moving(
    command: MotionCommand, valves: Valves, load: Loading, inputs: Inputs, p: Parameters
) -> Reference:
    """Return the reference of what the levers, or a taught command, ask for."""
    tip = tip_position(command.pose, p.links)
    walled = workspace.slide(tip, command.velocity, p.workspace)
    velocity, rates, left = walled, command.rates, 1.0
    if p.scheme == Scheme.JOINT:
        left = load_scale(inputs.angles, rates, p.links, load)
        rates = scaled(rates, left)
    else:
        velocity, left = unloaded(tip, walled, load, inputs.taught.speed > 0.0)
        rates = rates_near_singularity(command.pose, velocity, p.links)
    reference = scaled_reference(command.pose, rates, velocity, inputs.angles, valves, p)
    factor, limit = reference.scaling.factor, reference.scaling.limit
    if left < factor:
        return reference._replace(scaling=VelocityScaling(left * factor, Limit.LOAD))
    if walled != command.velocity and limit == Limit.NONE:
        return reference._replace(scaling=VelocityScaling(factor, Limit.WALL))
    if inputs.speed_scale < factor and inputs.taught.speed == 0.0:
        return reference._replace(scaling=VelocityScaling(inputs.speed_scale * factor, Limit.LATE))
    return reference


def _stopping(command: MotionCommand, valves: Valves, inputs: Inputs, p: Parameters) -> Reference:
    """Return the reference of a stop: rates at once, the tip's velocity as late as the machine answers."""
    pose, tip = command.pose, tip_position(command.pose, p.links)
    velocity = workspace.slide(tip, command.velocity, p.workspace)
    rates = joint_rates(pose, velocity, p.links)
    reference = scaled_reference(pose, rates, velocity, inputs.angles, valves, p)
    factor = reference.scaling.factor
    lagged = scaled(workspace.slide(tip, command.lagged, p.workspace), factor)
    return Reference(reference.rates, lagged, VelocityScaling(factor, Limit.RELEASED))


def scaled_reference(
    pose: Vec3, rates: Vec3, velocity: Vec3, angles: Vec3, valves: Valves, p: Parameters
) -> Reference:
    """Return rates and velocity, scaled by what the machine can and may do.

    Args:
        pose: where J^-1 is taken [rad].
        rates: asked of the joints [rad/s].
        velocity: asked of the tip [m/s].
        angles: measured [rad]; the limits count there for a scheme that does not hold its reference.
        valves: what is known of them.
        p: parameters.
    """
    place = pose if closes_on_position(p.scheme) else angles
    scaling = velocity_scaling(place, rates, velocity_limits_at(place, rates, p, valves))
    if p.scheme == Scheme.JOINT:
        left = workspace.wall_scaling(
            tip_position(angles, p.links), tip_velocity(angles, rates, p.links), p.workspace
        )
        if left < scaling.factor:
            scaling = VelocityScaling(left, Limit.WALL)
    a = scaled(rates, scaling.factor)
    if p.scheme != Scheme.JOINT and is_singular(pose, p.links):
        # Out of it the tip goes where the joints take it.
        return Reference(
            a, tip_velocity(pose, a, p.links), VelocityScaling(scaling.factor, Limit.SINGULARITY)
        )
    return Reference(a, scaled(velocity, scaling.factor), scaling)


def velocity_limits_at(angles: Vec3, rates: Vec3, p: Parameters, valves: Valves = AS_FILED) -> VelocityLimits:
    """Return the limits at a pose [rad] for joint rates that are asked for [rad/s].

    The coordinated scheme asks the valves for no more than they can give against the crane's weight, where
    the others leave them saturated; and no joint to go faster than one that cannot follow.
    """
    if p.scheme != Scheme.COORDINATED:
        return p.velocity_limits
    most, highest = (
        joint_rate_limits(angles, rates, p.speed_limits, valves.opening_ratio),
        p.velocity_limits.rates,
    )
    tracking_limits = valves.tracking_limits
    least = (
        min(highest[0], most[0], ceiling(tracking_limits.swing, rates[0])),
        min(highest[1], most[1], ceiling(tracking_limits.boom, rates[1])),
        min(highest[2], most[2], ceiling(tracking_limits.stick, rates[2])),
    )
    return p.velocity_limits._replace(rates=least)
