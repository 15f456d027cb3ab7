"""The controller's settings, and the parameters that its core takes from them and from the machine."""

import math
from functools import lru_cache
from typing import Annotated, NamedTuple

from forest_control.limits.actuator_speed_limits import SpeedLimitParameters, speed_limit_parameters
from forest_control.limits.load_moment import Capacity, capacity
from forest_control.limits.load_weighing import WeighingParameters, weighing_parameters
from forest_control.limits.singularity import ASIDE, BENT
from forest_control.limits.velocity_scaling import NO_AXIS, NO_STROKE, Axis, Pumps, Stroke, VelocityLimits
from forest_control.limits.workspace import OPEN, Workspace
from forest_control.operator.operator_profile import Frame, Mode, OperatorProfile
from forest_control.servo.acceleration_rule import acceleration_by_rule
from forest_control.servo.anti_sway import SwayParameters, sway_parameters
from forest_control.servo.arm_feedforward import arm_model
from forest_control.servo.coordinated_servo import CoordinationParameters
from forest_control.servo.gain_rule import gains_by_rule, integral
from forest_control.servo.joint_angle_filter import Source
from forest_control.servo.schemes import Gains, Scheme
from forest_control.servo.swing_feedforward import swing_model
from forest_control.valve.valve_driver_parameters import axis_drivers, command_noise
from forest_description.derived.actuator_kinematics import Linkages, displacements, rated_speeds
from forest_description.derived.limits import Interval, joint_limits
from forest_description.geometry.kinematics import Links
from forest_description.geometry.linkage import Linkage, cylinder_length
from forest_description.machine import Machine
from forest_description.types import ZERO, Vec3
from forest_msgs_py.runtime.parameter_table import tunable

SMOOTHING = 0.01  # [s] time constant of the reference's acceleration: two periods; chosen
HOLD_ERROR = 1.5e-4  # [rad] at which a resting joint holds, 1 mm of the tip: above the resolvers' jitter
RELEASE_ERROR = 3e-4  # [rad] at which it moves again: 2 mm of the tip
INCH = 0.03  # [1] of the rated speed, for an inch: over the command's noise; chosen
OVER_NOISE = 1.25  # [1] times the command's noise, at the least: the driver must take an inch for motion
BY_RULE: Vec3 = (-1.0, -1.0, -1.0)  # [1/s] or the gain's own unit: below zero the machine's rule gives it
FLOW_RESERVE = 0.95  # [1] of the pumps' flow: leakage and the loads' oil need the rest; chosen


class Settings(NamedTuple):
    """The controller's settings: parameters of its node that may be set while it runs.

    Three numbers are of swing, boom, stick. Symbols are those of `schemes`.
    """

    scheme: Annotated[Scheme, tunable("control scheme; to and from joint once nothing moves")] = (
        Scheme.COORDINATED
    )
    mode: Annotated[Mode, tunable("meaning of a deflection: tip velocity or position")] = Mode.RATE
    position_source: Annotated[
        Source,
        tunable(
            "sensors of boom and stick: resolvers, or resolvers corrected by the cylinders; heeded at rest"
        ),
    ] = Source.CYLINDERS
    axis_frame: Annotated[Frame, tunable("coordinates of the tip's axes")] = Frame.CARTESIAN
    deadzone: Annotated[Vec3, tunable("deflection of each lever that counts as none", "", 0.0, 0.5)] = ZERO
    expo: Annotated[Vec3, tunable("cubic share of each lever's curve", "", 0.0, 1.0)] = ZERO
    tip_speed: Annotated[float, tunable("tip speed at full deflection", "m/s", 0.01, 3.0)] = 0.5
    axis_speed: Annotated[Vec3, tunable("largest tip speed of each lever", "m/s", 0.01, 3.0)] = (
        3.0,
        3.0,
        3.0,
    )
    position_span: Annotated[
        float, tunable("displacement of the tip at full deflection in position mode", "m", 0.01, 3.0)
    ] = 0.5
    joint_span: Annotated[
        Vec3, tunable("displacement of the joints at full deflection in position mode", "rad", 0.001, 1.0)
    ] = (0.1, 0.1, 0.1)
    joint_rates: Annotated[Vec3, tunable("largest joint rates", "rad/s", 0.01, 3.0)] = (0.8, 0.25, 0.25)
    velocity_gain: Annotated[Vec3, tunable("K_v of schemes (a) and (c)", "", 0.01, 10.0)] = (
        0.313,
        0.313,
        0.313,
    )
    position_gain: Annotated[Vec3, tunable("K_p of schemes (b) and (d)", "1/s", 0.0, 50.0)] = (2.5, 5.0, 5.0)
    damping_gain: Annotated[Vec3, tunable("K_d of schemes (b) and (d)", "", -0.9, 10.0)] = ZERO
    jacobian_at_joints: Annotated[
        bool, tunable("scheme (d) takes J^-1 at the measured angles, as the thesis does")
    ] = False
    lead: Annotated[float, tunable("largest lead of the reference over a joint", "rad", 0.001, 1.0)] = 0.2
    feedback_gain: Annotated[
        Vec3,
        tunable(
            "K_p of the coordinated scheme; negative: from the machine file by the gain rule",
            "1/s",
            -1.0,
            30.0,
        ),
    ] = BY_RULE
    integral_gain: Annotated[
        Vec3,
        tunable("K_i of the coordinated scheme; negative: from K_p by the gain rule", "1/s^2", -1.0, 50.0),
    ] = BY_RULE
    rate_gain: Annotated[
        Vec3,
        tunable(
            "D of the coordinated scheme: damping by the measured rate; negative: by the gain rule",
            "",
            -1.0,
            2.0,
        ),
    ] = BY_RULE
    lead_time: Annotated[
        Vec3,
        tunable("T of the coordinated scheme: lag of the machine, without dead times", "s", 0.0, 0.5),
    ] = (0.018, 0.013, 0.013)
    load_bandwidth: Annotated[
        float, tunable("low-pass of the loads in the valve driver", "Hz", 0.01, 50.0)
    ] = 1.0
    tip_acceleration: Annotated[
        float,
        tunable(
            "largest acceleration of the coordinated scheme's reference; 0 or less: by the acceleration rule",
            "m/s^2",
            -1.0,
            20.0,
        ),
    ] = -1.0
    anti_sway: Annotated[
        bool, tunable("move the tip so that the hanging head does not sway: coordinated scheme, rate mode")
    ] = False
    joint_margin: Annotated[float, tunable("margin to the joint limits", "rad", 0.0, 0.2)] = (
        0.0175  # 1 degree
    )
    approach: Annotated[
        Vec3, tunable("largest speed over the way left to a limit, of an angle or a stroke", "1/s", 0.1, 20.0)
    ] = (1.0, 2.0, 2.0)


class Parameters(NamedTuple):
    """Machine and settings, as the core takes them; numbers only, for a compiler."""

    scheme: int  # a `Scheme`
    profile: OperatorProfile
    gains: tuple[Gains, Gains, Gains]
    jacobian_at_joints: bool
    velocity_limits: VelocityLimits
    following_error_limit: float  # [rad] of reference and joint, so that a stalled joint does not wind up
    links: Links
    linkages: Linkages
    rated_speeds: Vec3  # [rad/s, m/s, m/s] of an ideal valve at its rated voltage
    rated_voltages: Vec3  # [V] of each axis' valve
    coordinated: CoordinationParameters
    speed_limits: SpeedLimitParameters
    workspace: Workspace
    position_source: int  # a `Source`
    weighing: WeighingParameters
    capacity: Capacity
    sway: SwayParameters  # frequency 0: anti-sway is off, or nothing hangs


@lru_cache(maxsize=64)
def parameters(machine: Machine, settings: Settings, workspace: Workspace = OPEN) -> Parameters:
    """Return the core's parameters for a machine and the walls around it, and keep them for the next run."""
    settings = with_rules(machine, settings)
    gains = _gains(machine, settings, 0), _gains(machine, settings, 1), _gains(machine, settings, 2)
    return Parameters(
        scheme=int(settings.scheme),
        profile=operator_profile(settings),
        gains=gains,
        jacobian_at_joints=settings.jacobian_at_joints,
        velocity_limits=_velocity_limits(machine, settings),
        following_error_limit=settings.lead,
        links=machine.manipulator.links,
        linkages=machine.linkages,
        rated_speeds=rated_speeds(machine),
        rated_voltages=(
            machine.valve_of(0).rated_voltage,
            machine.valve_of(1).rated_voltage,
            machine.valve_of(2).rated_voltage,
        ),
        workspace=workspace,
        position_source=int(settings.position_source),
        sway=sway_parameters(machine) if settings.anti_sway else SwayParameters(),
        weighing=weighing_parameters(machine),
        capacity=capacity(machine),
        speed_limits=speed_limit_parameters(machine, axis_drivers(machine)),
        coordinated=CoordinationParameters(
            gains=gains,
            integral=settings.integral_gain,
            swing=swing_model(machine),
            arm=arm_model(machine),
            load_bandwidth=2.0 * math.pi * settings.load_bandwidth,
            smoothing=SMOOTHING,
            acceleration=settings.tip_acceleration,
            hold_error=HOLD_ERROR,
            release_error=RELEASE_ERROR,
            inches=(_inch(machine, 0), _inch(machine, 1), _inch(machine, 2)),
            free_ways=(0.0 if machine.swing.backlash is None else machine.swing.backlash.free_way, 0.0, 0.0),
            linkages=machine.linkages,
        ),
    )


def with_rules(machine: Machine, settings: Settings) -> Settings:
    """Return settings with what the machine's rules say in place of negative gains and no acceleration."""
    if settings.tip_acceleration <= 0.0:
        by_rule = acceleration_by_rule(machine, settings.tip_speed)
        settings = settings._replace(tip_acceleration=by_rule)
    k_p, k_i, d = settings.feedback_gain, settings.integral_gain, settings.rate_gain
    if min(*k_p, *k_i, *d) >= 0.0:
        return settings
    rule = gains_by_rule(machine)
    k_p = _told(k_p, rule.feedback)
    goes_with = integral(k_p[0], 0), integral(k_p[1], 1), integral(k_p[2], 2)
    return settings._replace(
        feedback_gain=k_p, integral_gain=_told(k_i, goes_with), rate_gain=_told(d, rule.rate)
    )


def _told(given: Vec3, rule: Vec3) -> Vec3:
    one, two, three = (by_rule if x < 0.0 else x for x, by_rule in zip(given, rule, strict=True))
    return one, two, three


def _inch(machine: Machine, axis: int) -> float:
    """Return the actuator's speed [rad/s; m/s] while a resting joint is inched."""
    rated = machine.valve_of(axis).rated_voltage
    share = max(INCH, OVER_NOISE * command_noise(machine, axis) / rated)
    return share * rated_speeds(machine)[axis]


def operator_profile(settings: Settings) -> OperatorProfile:
    """Return how an operator's levers are read."""
    v, most = settings.tip_speed, settings.axis_speed
    return OperatorProfile(
        mode=int(settings.mode),
        frame=int(settings.axis_frame),
        deadzone=settings.deadzone,
        expo=settings.expo,
        speeds=(min(v, most[0]), min(v, most[1]), min(v, most[2])),
        tip_span=settings.position_span,
        joint_span=settings.joint_span,
    )


def _gains(machine: Machine, settings: Settings, i: int) -> Gains:
    return Gains(
        velocity=settings.velocity_gain[i],
        position=settings.position_gain[i],
        damping=settings.damping_gain[i],
        feedback=settings.feedback_gain[i],
        lead_time=settings.lead_time[i] + (machine.valve_of(i).dead_time or 0.0),
        rate=settings.rate_gain[i],
    )


def _velocity_limits(machine: Machine, settings: Settings) -> VelocityLimits:
    limits, margin = joint_limits(machine), settings.joint_margin
    lower, upper = [low + margin for low, _ in limits], [high - margin for _, high in limits]
    links, displaced = machine.manipulator.links, [displacements(machine, axis) for axis in range(3)]
    axis = NO_AXIS
    if settings.scheme != Scheme.JOINT:
        lower[2], upper[2] = _regular(lower[2], upper[2])
        axis = Axis(links, ASIDE * (links.boom + links.stick))
    pumps = Pumps(
        limit=FLOW_RESERVE * machine.pump.flow_limit,
        extending=(displaced[0][0], displaced[1][0], displaced[2][0]),
        retracting=(displaced[0][1], displaced[1][1], displaced[2][1]),
        linkages=machine.linkages,
    )
    return VelocityLimits(
        lower=(lower[0], lower[1], lower[2]),
        upper=(upper[0], upper[1], upper[2]),
        rates=settings.joint_rates,
        approach=settings.approach,
        pumps=pumps,
        axis=axis,
        strokes=(
            NO_STROKE,
            _stroke(lower[1], upper[1], machine.linkages[0]),
            _stroke(lower[2], upper[2], machine.linkages[1]),
        ),
    )


def _stroke(lower: float, upper: float, linkage: Linkage) -> Stroke:
    """Return the cylinder's lengths at its joint's limits [rad]."""
    return Stroke(linkage, cylinder_length(lower, linkage), cylinder_length(upper, linkage))


def _regular(lower: float, upper: float) -> Interval:
    """Return the part of the stick's range [rad] on the side of the elbow that inverse kinematics takes.

    A stick that can be straight or folded flat stops `BENT` before; a range that has none of that
    side stays.
    """
    low, high = max(lower, -math.pi + BENT), min(upper, -BENT)
    return (low, high) if low < high else (lower, upper)
