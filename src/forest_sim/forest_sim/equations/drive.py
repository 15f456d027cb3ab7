"""The swing between its motor and its joint: a gear with play, and a bearing that sticks.

A machine without either has none of this: `PlantParameters.drive.present` is 0.
"""

from typing import NamedTuple

from forest_sim.equations.plant_parameters import DriveLaws
from forest_sim.mechanics.bristles import rubbing
from forest_sim.mechanics.end_stop import end_stop_force
from forest_sim.mechanics.gear import teeth_depth, teeth_energy


class DriveState(NamedTuple):
    """The motor behind its play and the bearing's bristles; also holds their time derivatives."""

    motor_angle: float  # seen at the joint [rad]; 0 without play
    motor_rate: float  # [rad/s]
    bristle_angle: float  # deflection [rad]


class Driven(NamedTuple):
    """What a drive makes of its motor's torque."""

    torque: float  # on the joint [N m]
    rates: DriveState  # time derivatives


class DrivePower(NamedTuple):
    """What the swing's drive takes of its motor's power [W]."""

    gear: float  # lost between the teeth
    friction: float  # lost in the bearing
    elastic: float  # stored in motor, teeth and bristles
    stop: float  # stored and lost in the joint's end stop


AT_REST = DriveState(0.0, 0.0, 0.0)
NO_POWER = DrivePower(0.0, 0.0, 0.0, 0.0)


def driven(drive: DriveState, angle: float, rate: float, torque: float, laws: DriveLaws) -> Driven:
    """Return the torque on the swing's joint and the drive's derivatives.

    Args:
        drive: its state.
        angle: of the joint [rad].
        rate: of the joint [rad/s].
        torque: of the motor; without play with the end stop's [N m].
        laws: the constants.
    """
    rub, gear = rubbing(drive.bristle_angle, rate, laws.bearing), laws.gear
    if gear.inertia == 0.0:
        return Driven(torque - rub.force, DriveState(0.0, 0.0, rub.rate))
    teeth = end_stop_force(drive.motor_angle - angle, drive.motor_rate - rate, gear.teeth)
    return Driven(
        end_stop_force(angle, rate, gear.stop) - teeth - rub.force,
        DriveState(drive.motor_rate, (torque + teeth) / gear.inertia, rub.rate),
    )


def drive_power(drive: DriveState, angle: float, rate: float, torque: float, laws: DriveLaws) -> DrivePower:
    """Return what the drive takes of its motor's power; arguments as `driven`."""
    rub, gear = rubbing(drive.bristle_angle, rate, laws.bearing), laws.gear
    bent = laws.bearing.stiffness * drive.bristle_angle * rub.rate
    if gear.inertia == 0.0:
        return DrivePower(gear=0.0, friction=rub.force * rate - bent, elastic=bent, stop=0.0)
    twist, speed = drive.motor_angle - angle, drive.motor_rate - rate
    teeth = end_stop_force(twist, speed, gear.teeth)
    pressed = gear.teeth.stiffness * teeth_depth(twist, gear.teeth) * speed
    return DrivePower(
        gear=-teeth * speed - pressed,
        friction=rub.force * rate - bent,
        elastic=bent + pressed + drive.motor_rate * (torque + teeth),
        stop=-end_stop_force(angle, rate, gear.stop) * rate,
    )


def drive_energy(drive: DriveState, angle: float, laws: DriveLaws) -> float:
    """Return the energy [J] in motor, teeth and bristles at an angle of the joint [rad]."""
    kinetic = laws.gear.inertia * drive.motor_rate**2
    bent = laws.bearing.stiffness * drive.bristle_angle**2
    return 0.5 * (kinetic + bent) + teeth_energy(drive.motor_angle - angle, laws.gear.teeth)
