"""What the stages of the controller hand on: state and inputs, command, reference, servo, output."""

from enum import IntEnum
from typing import NamedTuple

from forest_control.limits.load_moment import Loading
from forest_control.limits.load_weighing import UNKNOWN, UNREAD, Pressures, Weighing
from forest_control.limits.velocity_scaling import VelocityScaling
from forest_control.operator.levers import Levers
from forest_control.operator.taught_command import NO_COMMAND, TaughtCommand
from forest_control.pipeline.stop_profile import NO_STOP, Stop
from forest_control.safety.driver_response import DriverSample
from forest_control.servo import coordinated_servo
from forest_control.servo.anti_sway import NO_SWAY, Sway
from forest_control.servo.joint_angle_filter import NONE as NO_CORRECTION
from forest_control.servo.joint_angle_filter import UNREAD as NO_LENGTHS
from forest_control.servo.joint_angle_filter import AngleCorrection, Lengths
from forest_control.valve.tracking_limit import FULL, NO_TRACKING_LIMIT, OpeningRatio, TrackingLimits
from forest_description.types import ZERO, Vec3

NO_SCHEME = NO_MODE = -1  # [1] of an enumeration, before the first step: no member's number


class State(NamedTuple):
    """What the controller remembers between steps."""

    reference: Vec3  # r [rad]
    enabled: bool
    memory: coordinated_servo.Memory = coordinated_servo.REST
    scheme: int = NO_SCHEME  # that was in charge
    rates: Vec3 = ZERO  # u [rad/s], commanded last
    offset: Vec3 = ZERO  # [rad/s] added to the servo's, and fading
    mode: int = NO_MODE  # that was in force
    clutch: Vec3 = ZERO  # [rad] the pose that position mode moves about
    changed: bool = False  # a parameter was changed: its effect on the command shall fade, too
    stop: Stop = NO_STOP  # along the path, under way or over
    correction: AngleCorrection = NO_CORRECTION  # of the angles
    tracking_limits: TrackingLimits = NO_TRACKING_LIMIT  # joints that could not follow
    sway: Sway = NO_SWAY  # of what hangs from the tip
    weighing: Weighing = UNKNOWN  # of the load
    wish: Vec3 = ZERO  # [m/s] that the tip would have by now, had nothing held it back


class Inputs(NamedTuple):
    """What arrives in a step."""

    angles: Vec3  # s [rad], measured by the resolvers
    rates: Vec3  # v [rad/s], measured
    levers: Levers
    enabled: bool  # the levers may move the crane (`motion_permission`)
    cylinders: Lengths = NO_LENGTHS  # [m] boom, stick, of the same moment; NaN: no sample
    opening_ratio: OpeningRatio = FULL  # of the valves, as the driver has learnt it
    voltages: Vec3 = ZERO  # [V] of the valves, given last by the driver
    taught: TaughtCommand = NO_COMMAND  # that is followed in place of the levers
    boom_pressures: Pressures = UNREAD  # [Pa] head and rod side; NaN: no sample
    overloaded: bool = False  # a load has driven a joint back; while this stands, nothing is enabled
    speed_scale: float = 1.0  # of the levers, behind a late link


class ValveFeedback(NamedTuple):
    """What the valve driver reports."""

    opening_ratio: OpeningRatio = FULL
    voltages: Vec3 = ZERO  # [V] that the valves have by now; zero of a driver that is silent
    driver: DriverSample = DriverSample()  # its newest word


class Phase(IntEnum):
    """What the crane is about."""

    STANDING = 0  # released, and the stop is over: zero spool
    SETTLING = 1  # enabled, levers centred: the reference is the mean of what is measured
    MOVING = 2  # by the levers
    STOPPING = 3  # released: along the path, closed on the reference
    BRAKING = 4  # released: along the path, open loop


class MotionCommand(NamedTuple):
    """What levers, or the stop under way, ask for."""

    phase: int  # a `Phase`
    pose: Vec3  # where J^-1 is taken [rad]
    velocity: Vec3 = ZERO  # x' of the tip [m/s]
    lagged: Vec3 = ZERO  # x' that the reference follows, as late as the machine answers [m/s]
    rates: Vec3 = ZERO  # of the joints [rad/s], where no tip velocity asks for them
    wish: Vec3 = ZERO  # x', had nothing held it back so far [m/s]


class Reference(NamedTuple):
    """What the limits leave of a command: what the servo follows."""

    rates: Vec3  # a [rad/s]
    velocity: Vec3  # x' [m/s]
    scaling: VelocityScaling


class Servo(NamedTuple):
    """What the servo answers."""

    reference: Vec3  # r, a step on [rad]
    memory: coordinated_servo.Memory
    rates: Vec3 = ZERO  # u [rad/s]
    offset: Vec3 = ZERO  # part of u that fades [rad/s]
    velocity: Vec3 = ZERO  # x' that u aims at [m/s]


class Output(NamedTuple):
    """What leaves in a step."""

    command: Vec3  # [V] of ideal valves, as applied
    tip_velocity_reference: Vec3  # that is aimed at [m/s]
    scaling: VelocityScaling
    loading: Loading = Loading()


class Telemetry(NamedTuple):
    """A step's output, and how the tip moves by the angles that count."""

    output: Output
    tip: Vec3  # [m]
    tip_orientation: tuple[float, float, float, float]  # quaternion x, y, z, w
    tip_velocity: Vec3  # [m/s]


REST = State(ZERO, False)


def stopped(state: State) -> State:
    """Return the state with all motion forgotten; what hangs there still does."""
    return REST._replace(weighing=state.weighing)
