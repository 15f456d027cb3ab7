"""What the controller's steps hand on: state, inputs, output, and the governed wish between its blocks."""

from typing import NamedTuple

from forest_control.limits.velocity_scaling import Governed
from forest_control.operator.levers import Levers
from forest_control.pipeline.stop_profile import NO_STOP, Stop
from forest_control.servo import coordinated_servo
from forest_control.servo.joint_angle_filter import NONE as NO_CORRECTION
from forest_control.servo.joint_angle_filter import UNREAD, Correction, Lengths
from forest_control.valve.tracking_limit import FULL, RELAXED, Reach, Strains
from forest_description.types import ZERO, Vec3

NO_SCHEME = NO_MODE = -1


class State(NamedTuple):
    """What the controller remembers."""

    reference: Vec3  # r [rad]
    enabled: bool
    memory: coordinated_servo.Memory = coordinated_servo.REST
    scheme: int = NO_SCHEME  # that was in charge
    rates: Vec3 = ZERO  # u [rad/s], commanded last
    offset: Vec3 = ZERO  # [rad/s] added to the servo's, and fading
    mode: int = NO_MODE  # that was in force
    clutch: Vec3 = ZERO  # [rad] the pose that position mode moves about
    changed: bool = False  # somebody changed a parameter: what it does to the command shall fade, too
    stop: Stop = NO_STOP  # along the path, under way or over
    correction: Correction = NO_CORRECTION  # of the angles
    strains: Strains = RELAXED  # joints that could not follow


class Inputs(NamedTuple):
    """What arrives in a step."""

    angles: Vec3  # s [rad], measured by the resolvers
    rates: Vec3  # v [rad/s], measured
    levers: Levers
    enabled: bool  # a fresh, finite, held deadman
    cylinders: Lengths = UNREAD  # [m] boom, stick, of the same moment; NaN: no sample
    reach: Reach = FULL  # of the valves, as the driver has learnt it
    voltages: Vec3 = ZERO  # [V] of the valves, given last by the driver


class Output(NamedTuple):
    """What leaves in a step."""

    command: Vec3  # [V] of ideal valves, as applied
    tip_wish: Vec3  # [m/s], governed
    governed: Governed


class Told(NamedTuple):
    """What a step has to tell of itself and of the tip."""

    output: Output
    tip: Vec3  # [m]
    tip_orientation: tuple[float, float, float, float]  # quaternion x, y, z, w
    tip_velocity: Vec3  # [m/s]


class Wish(NamedTuple):
    """What the scheme is asked for, governed."""

    rates: Vec3  # a [rad/s]
    velocity: Vec3  # x' [m/s]
    governed: Governed


REST = State(ZERO, False)


def begun(angles: Vec3, enabled: bool) -> State:
    """Return the state of a machine at rest; a compiler knows no defaults."""
    return State(
        angles, enabled, coordinated_servo.REST, NO_SCHEME, ZERO, ZERO, NO_MODE, ZERO, False, NO_STOP
    )


def minus(x: Vec3, y: Vec3) -> Vec3:
    """Return x - y."""
    return x[0] - y[0], x[1] - y[1], x[2] - y[2]


def scaled(values: Vec3, factor: float) -> Vec3:
    """Return values times a factor."""
    return factor * values[0], factor * values[1], factor * values[2]
