"""What a gear with play and a bearing that sticks do to an implicit stage.

Bristles have a closed form at a guessed rate. The motor's rate w is one more unknown of Newton's,
which its own equation eliminates: it is as stiff as the teeth, and no other row feels it.

    J (w - base) + h (T - torque(w)) = 0,   D = J + h (R + K)

with T the teeth's torque, K its slope -dT/d(u - w) and R the oil's -d(torque)/dw. The teeth's kinks
would send Newton to and fro: the oil's torque is taken along its slope, and w found within a
bracket. At the joint the gear is then an actuator of the torque T and the resistance K (1 - share).
"""

from typing import NamedTuple

from forest_sim.equations.drive import DriveState
from forest_sim.equations.plant_parameters import DriveLaws
from forest_sim.mechanics.bristles import stuck_after
from forest_sim.mechanics.end_stop import EndStop, end_stop_force, end_stop_resistance
from forest_sim.stage.supply_stage import SupplyError


class DriveSolution(NamedTuple):
    """The drive of a stage at guessed rates."""

    torque: float  # on the joint [N m]
    resistance: float  # -d(torque)/d(rate) [N m s]
    share: float  # h K/D, of the joint's change of rate that the motor follows; 1 without play
    excess: float  # by which the motor is too fast at the guessed rates [rad/s]
    give: float  # 1/D [1/(kg m^2)]; 0 without play


class Contact(NamedTuple):
    """Teeth within a stage, as the motor's rate alone closes them."""

    twist: float  # theta - q at a motor rate of zero [rad]
    rate: float  # of the joint [rad/s]
    give: float  # change of the motor's rate by a torque of the teeth [1/(N m s)]
    step: float  # the stage's implicit step [s]
    teeth: EndStop


MESH_ITERATIONS, MESH_TOLERANCE = 40, 1e-9  # [rad/s]


def solve_drive(
    base: DriveState,
    angle: float,
    rate: float,
    motor_rate: float,
    torque: float,
    resistance: float,
    h: float,
    laws: DriveLaws,
) -> DriveSolution:
    """Return what the drive makes of the swing's solution.

    Args:
        base: the stage's known part.
        angle: of the joint at the stage's end [rad].
        rate: of the joint there [rad/s].
        motor_rate: of the motor there [rad/s].
        torque: of the swing's actuator; with play, at the motor's rate [N m].
        resistance: its -d(torque)/d(rate) [N m s].
        h: the stage's implicit step [s].
        laws: the constants.
    """
    stuck, gear = stuck_after(base.bristle_angle, rate, h, laws.bearing), laws.gear
    if gear.inertia == 0.0:
        return DriveSolution(
            torque - stuck.force, resistance + stuck.resistance, share=1.0, excess=0.0, give=0.0
        )
    free = base.motor_rate + h * (torque + resistance * (motor_rate - base.motor_rate)) / (
        gear.inertia + h * resistance
    )
    contact = Contact(base.motor_angle - angle, rate, h / (gear.inertia + h * resistance), h, gear.teeth)
    turned = meshed_rate(free, motor_rate, contact)
    twist, speed = contact.twist + h * turned, turned - rate
    stiff = end_stop_resistance(twist, speed, gear.teeth, h)
    give = 1.0 / (gear.inertia + h * (resistance + stiff))
    share = give * h * stiff
    stopped = end_stop_resistance(angle, rate, gear.stop, h)
    return DriveSolution(
        torque=end_stop_force(angle, rate, gear.stop)
        - end_stop_force(twist, speed, gear.teeth)
        - stuck.force,
        resistance=stiff * (1.0 - share) + stopped + stuck.resistance,
        share=share,
        excess=motor_rate - turned,
        give=give,
    )


def meshed_rate(free: float, guess: float, c: Contact) -> float:
    """Return the rate [rad/s] of a motor that meets the joint's teeth, w + give T(w) = free.

    Teeth only push back: the rate lies between the free one and that which just touches.

    Args:
        free: rate without teeth [rad/s].
        guess: rate near the one sought [rad/s].
        c: the teeth at the joint's guessed rate.
    """
    loose = c.twist + c.step * free
    if c.teeth.lower <= loose <= c.teeth.upper:
        return free
    touching = ((c.teeth.lower if loose < c.teeth.lower else c.teeth.upper) - c.twist) / c.step
    low, high = min(free, touching), max(free, touching)
    rate = guess if low < guess < high else free
    for _ in range(MESH_ITERATIONS):
        twist, speed = c.twist + c.step * rate, rate - c.rate
        off = rate - c.give * end_stop_force(twist, speed, c.teeth) - free
        if off > 0.0:
            high = rate
        else:
            low = rate
        newton = off / (1.0 + c.give * end_stop_resistance(twist, speed, c.teeth, c.step))
        if abs(newton) <= MESH_TOLERANCE:
            rate -= newton
            break
        rate = rate - newton if low < rate - newton < high else 0.5 * (low + high)
    return rate


def through_gear(e: SupplyError, drive: DriveSolution) -> SupplyError:
    """Return the manifold's equation after the motor's rate is eliminated from it."""
    drawn, gain = e.by_rate[0], e.on_rates[0]
    return SupplyError(
        residual=e.residual - drawn * drive.excess,
        slope=e.slope + drawn * gain * drive.give,
        by_rate=(drawn * drive.share, e.by_rate[1], e.by_rate[2]),
        on_rates=(gain * drive.share, e.on_rates[1], e.on_rates[2]),
        feeds=e.feeds,
        state=e.state,
        control=e.control,
    )


def drive_after(base: DriveState, rate: float, motor_rate: float, h: float, laws: DriveLaws) -> DriveState:
    """Return the drive at a stage's end.

    Args:
        base: the stage's known part.
        rate: of the joint at the stage's end [rad/s].
        motor_rate: of the motor there [rad/s].
        h: the stage's implicit step [s].
        laws: the constants.
    """
    bristle_angle = stuck_after(base.bristle_angle, rate, h, laws.bearing).deflection
    if laws.gear.inertia == 0.0:
        return DriveState(0.0, 0.0, bristle_angle)
    return DriveState(base.motor_angle + h * motor_rate, motor_rate, bristle_angle)
