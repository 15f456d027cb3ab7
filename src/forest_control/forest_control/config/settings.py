"""What a user may set of the controller, and what its core makes of that and of the machine."""

import math
from typing import NamedTuple

from forest_control.limits.actuator_speed_limits import Capacity, capacity
from forest_control.limits.singularity import BENT
from forest_control.limits.velocity_scaling import NO_AXIS, NO_STROKE, Axis, GovernorParameters, Pumps, Stroke
from forest_control.limits.workspace import OPEN, Workspace
from forest_control.operator.operator_profile import Frame, Hand, Mode
from forest_control.servo.coordinated_servo import CoordinationParameters
from forest_control.servo.joint_angle_filter import Source
from forest_control.servo.schemes import Gains, Scheme
from forest_control.servo.swing_feedforward import swing_load
from forest_control.valve.valve_driver import axis_drivers
from forest_control.valve.valve_driver_parameters import command_noise
from forest_description.derived.actuator_kinematics import Linkages, displacements, rated_speeds
from forest_description.derived.limits import Interval, joint_limits
from forest_description.geometry.kinematics import Links
from forest_description.geometry.linkage import Linkage, cylinder_length
from forest_description.machine import Machine
from forest_description.types import Vec3

SMOOTHING = 0.01  # [s] of the reference's acceleration
INTEGRAL_LIMIT = 0.1  # [rad/s] more than any valve is wrong by
HOLD_ERROR = 1.5e-4  # [rad] above the resolvers' low-passed jitter; 1 mm of the tip
RELEASE_ERROR = 3e-4  # [rad] 2 mm
INCH, OVER_NOISE = 0.03, 1.25  # of the rated speed; of what the valve driver may take for noise
CLOSEST = 0.03  # of the arm's length: how near the tip comes to the swing axis in tip schemes
FLOW_RESERVE = 0.95  # of the pumps' flow: leakage and the loads' oil need the rest


class Settings(NamedTuple):
    """What a user may set: the node's parameters and their defaults. Triples are swing, boom, stick."""

    scheme: Scheme = Scheme.COORDINATED
    mode: Mode = Mode.RATE
    position_source: Source = Source.CYLINDERS  # of boom and stick
    axis_frame: Frame = Frame.CARTESIAN
    deadzone: Vec3 = (0.0, 0.0, 0.0)  # of the levers
    expo: Vec3 = (0.0, 0.0, 0.0)
    tip_speed: float = 0.5  # [m/s] wished at full deflection, tip schemes
    axis_speed: Vec3 = (3.0, 3.0, 3.0)  # [m/s] largest wish of each lever, tip schemes
    position_span: float = 0.5  # [m] of the tip about the clutch point at full deflection, position mode
    joint_span: Vec3 = (0.1, 0.1, 0.1)  # [rad] of the joints, joint scheme in position mode
    joint_rates: Vec3 = (0.8, 0.25, 0.25)  # [rad/s] largest wish; at full deflection in the joint scheme
    velocity_gain: Vec3 = (0.313, 0.313, 0.313)  # K_v
    position_gain: Vec3 = (2.5, 5.0, 5.0)  # K_p [1/s]
    damping_gain: Vec3 = (0.0, 0.0, 0.0)  # K_d
    jacobian_at_joints: bool = False  # scheme (d) takes J^-1 at the measured angles, as the thesis does
    lead: float = 0.2  # [rad]
    feedback_gain: Vec3 = (3.0, 5.0, 5.0)  # K_p of the coordinated scheme [1/s]
    integral_gain: Vec3 = (3.0, 4.0, 4.0)  # K_i of the coordinated scheme [1/s^2]
    rate_gain: Vec3 = (0.4, 0.0, 0.0)  # D of the coordinated scheme; only the swing rocks slowly
    lead_time: Vec3 = (0.018, 0.013, 0.013)  # T [s]
    load_bandwidth: float = 1.0  # [Hz] of the valve driver's
    tip_acceleration: float = 4.0  # [m/s^2] of the coordinated scheme's reference: steps become ramps
    joint_margin: float = 0.0175  # [rad] kept from every joint limit
    approach: Vec3 = (1.0, 2.0, 2.0)  # [1/s] allowed speed per angle or stroke left to a limit


class Parameters(NamedTuple):
    """What the controller knows of machine and operator; numbers only, for a compiler."""

    scheme: int  # a `Scheme`
    hand: Hand
    gains: tuple[Gains, Gains, Gains]
    jacobian_at_joints: bool
    governor: GovernorParameters
    lead: float  # [rad] the reference may run ahead of the joint, so that a stalled joint does not wind up
    links: Links
    linkages: Linkages
    rated_speeds: Vec3  # [rad/s, m/s, m/s] of an ideal valve at its rated voltage
    rated_voltages: Vec3  # [V] of each axis' valve
    coordinated: CoordinationParameters
    capacity: Capacity
    workspace: Workspace
    position_source: int  # a `Source`


def parameters(machine: Machine, settings: Settings, workspace: Workspace = OPEN) -> Parameters:
    """Return the core's parameters for a machine and the walls around it."""
    gains = _gains(settings, 0), _gains(settings, 1), _gains(settings, 2)
    return Parameters(
        scheme=int(settings.scheme),
        hand=_hand(settings),
        gains=gains,
        jacobian_at_joints=settings.jacobian_at_joints,
        governor=_governor(machine, settings),
        lead=settings.lead,
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
        capacity=capacity(machine, axis_drivers(machine)),
        coordinated=CoordinationParameters(
            gains=gains,
            integral=settings.integral_gain,
            swing=swing_load(machine),
            load_bandwidth=2.0 * math.pi * settings.load_bandwidth,
            smoothing=SMOOTHING,
            acceleration=settings.tip_acceleration,
            integral_limit=INTEGRAL_LIMIT,
            hold_error=HOLD_ERROR,
            release_error=RELEASE_ERROR,
            inches=(_inch(machine, 0), _inch(machine, 1), _inch(machine, 2)),
            linkages=machine.linkages,
        ),
    )


def _inch(machine: Machine, axis: int) -> float:
    """Return the actuator's speed [rad/s; m/s] while a resting joint is inched."""
    rated = machine.valve_of(axis).rated_voltage
    share = max(INCH, OVER_NOISE * command_noise(machine, axis) / rated)
    return share * rated_speeds(machine)[axis]


def _hand(settings: Settings) -> Hand:
    v, most = settings.tip_speed, settings.axis_speed
    return Hand(
        mode=int(settings.mode),
        frame=int(settings.axis_frame),
        deadzone=settings.deadzone,
        expo=settings.expo,
        speeds=(min(v, most[0]), min(v, most[1]), min(v, most[2])),
        tip_span=settings.position_span,
        joint_span=settings.joint_span,
    )


def _gains(settings: Settings, i: int) -> Gains:
    return Gains(
        velocity=settings.velocity_gain[i],
        position=settings.position_gain[i],
        damping=settings.damping_gain[i],
        feedback=settings.feedback_gain[i],
        lead_time=settings.lead_time[i],
        rate=settings.rate_gain[i],
    )


def _governor(machine: Machine, settings: Settings) -> GovernorParameters:
    limits, margin = joint_limits(machine), settings.joint_margin
    lower, upper = [low + margin for low, _ in limits], [high - margin for _, high in limits]
    links, displaced = machine.manipulator.links, [displacements(machine, axis) for axis in range(3)]
    axis = NO_AXIS
    if settings.scheme != Scheme.JOINT:
        lower[2], upper[2] = _regular(lower[2], upper[2])
        axis = Axis(links, CLOSEST * (links.boom + links.stick))
    pumps = Pumps(
        limit=FLOW_RESERVE * machine.pump.flow_limit,
        extending=(displaced[0][0], displaced[1][0], displaced[2][0]),
        retracting=(displaced[0][1], displaced[1][1], displaced[2][1]),
        linkages=machine.linkages,
    )
    return GovernorParameters(
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

    A stick that can be straight or folded flat stops `BENT` before; a range that has none of that side stays.
    """
    low, high = max(lower, -math.pi + BENT), min(upper, -BENT)
    return (low, high) if low < high else (lower, upper)
