"""What a fault makes of what passes between joystick, machine, controller, driver and valves."""

import math
from collections.abc import Sequence

from forest_control.operator.joystick_watch import Sample, unreadable_sample
from forest_control.operator.levers import REST, Levers
from forest_control.valve.command_gate import Command
from forest_description.types import ZERO, Vec3
from forest_msgs_py.types import NS_PER_S, PERIOD
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.hydraulics.hydraulic_line import PortGuard
from forest_sim.sensors.signal_processing import Measurement, Motion
from forest_sim.solver.integrator import Simulation
from forest_study.faults.fault import Moment

HOUR = 3600 * NS_PER_S  # [ns]
SELDOM = 0.15  # [s] between two commands of a bad link: longer than command_timeout
SLOW = 0.2  # [s] of a contact that flickers: longer than joy_timeout
RATED = 10.0  # [V]
CHIP = 0.3  # [1] of the rated voltage at which a spool is held open
TORN = PortGuard(1e5, 3e-10, 0.0, 0.0)  # 180 L/min at 10 MPa out of each port
GLITCH = 0.3  # [rad]
TOO_MUCH = 3e7  # [Pa] that a transducer reads
NOTHING = 1e-12  # [1] of what a pump gave


def silent(_moment: Moment, _sample: Sample) -> Sequence[Sample]:
    """Nothing comes."""
    return ()


def unplugged(moment: Moment, sample: Sample) -> Sequence[Sample]:
    """One sample at rest, as a driver says that its device is gone; then nothing."""
    return (sample._replace(levers=REST, held=False),) if moment.since == 0.0 else ()


def hanging(moment: Moment, sample: Sample) -> Sequence[Sample]:
    """The driver goes on with the device's last sample, under new stamps."""
    first: Sample = moment.first
    return (sample._replace(levers=first.levers, held=first.held, same=moment.since > 0.0),)


def flickering(moment: Moment, sample: Sample) -> Sequence[Sample]:
    """A loose contact: now it comes, now it does not."""
    return (sample,) if int(moment.since / SLOW) % 2 else ()


def garbled(_moment: Moment, sample: Sample) -> Sequence[Sample]:
    """Levers that are no numbers."""
    return (unreadable_sample(sample.received),)


def crossed(_moment: Moment, sample: Sample) -> Sequence[Sample]:
    """Boom's and stick's levers are swapped."""
    swing, boom, stick = sample.levers
    return (sample._replace(levers=Levers(swing, stick, boom)),)


def doubled(_moment: Moment, sample: Sample) -> Sequence[Sample]:
    """A second joystick lies on the seat, at rest."""
    return sample, sample._replace(levers=REST, held=False, stamp=sample.stamp + 1)


def joystick_ahead(_moment: Moment, sample: Sample) -> Sequence[Sample]:
    """The joystick's clock is an hour ahead."""
    return (sample._replace(stamp=sample.stamp + HOUR),)


def joystick_behind(_moment: Moment, sample: Sample) -> Sequence[Sample]:
    """The joystick's clock is an hour behind."""
    return (sample._replace(stamp=max(1, sample.stamp - HOUR)),)


def joystick_stands(moment: Moment, sample: Sample) -> Sequence[Sample]:
    """The joystick's clock stands still."""
    return (sample._replace(stamp=moment.first.stamp),)


def ahead(_moment: Moment, stamp: int) -> int:
    """The machine's clock is an hour ahead."""
    return stamp + HOUR


def behind(_moment: Moment, stamp: int) -> int:
    """The machine's clock is an hour behind."""
    return stamp - HOUR


def stands(moment: Moment, _stamp: int) -> int:
    """The machine's clock stands still."""
    return int(moment.first)


def lost(_moment: Moment) -> bool:
    """Nothing comes of the machine's state."""
    return True


def half_lost(moment: Moment) -> bool:
    """Half of the machine's states come."""
    return moment.chance < 0.5


def swapped(_moment: Moment, seen: Measurement) -> Measurement:
    """Boom's and stick's resolvers are plugged the wrong way round."""

    def turned(values: Vec3) -> Vec3:
        return values[0], values[2], values[1]

    joints = Motion(*(turned(values) for values in seen.joints))
    return seen._replace(joints=joints)


def reversed_axis(moment: Moment, seen: Measurement) -> Measurement:
    """One resolver counts the other way, from where it stood."""
    (at, rates), i = seen.joints[:2], moment.axis
    turned = _with(at, i, 2.0 * moment.first.joints.position[i] - at[i]), _with(rates, i, -rates[i])
    return seen._replace(joints=seen.joints._replace(position=turned[0], speed=turned[1]))


def glitching(moment: Moment, seen: Measurement) -> Measurement:
    """One resolver's angle is off in one sample of twenty; its speed is not."""
    i, at = moment.axis, seen.joints.position
    off = GLITCH if round(moment.since / PERIOD) % 20 == 0 else 0.0
    return seen._replace(joints=seen.joints._replace(position=_with(at, i, at[i] + off)))


def in_degrees(_moment: Moment, seen: Measurement) -> Measurement:
    """Somebody publishes degrees."""
    at, rates = (_degrees(values) for values in seen.joints[:2])
    return seen._replace(joints=seen.joints._replace(position=at, speed=rates))


def _degrees(values: Vec3) -> Vec3:
    return math.degrees(values[0]), math.degrees(values[1]), math.degrees(values[2])


def no_pressures(_moment: Moment, seen: Measurement) -> Measurement:
    """All pressure transducers are without supply."""
    return seen._replace(pressures=(math.nan,) * len(seen.pressures), supply_pressure=math.nan)


def high_pressures(_moment: Moment, seen: Measurement) -> Measurement:
    """All pressure transducers read 3 MPa too much."""
    return seen._replace(pressures=tuple(p + 3e6 for p in seen.pressures))


def swing_pressure_high(_moment: Moment, seen: Measurement) -> Measurement:
    """The transducer at the swing motor's first port reads too much."""
    read = list(seen.pressures)
    read[1] += TOO_MUCH
    return seen._replace(pressures=tuple(read))


def frozen_pressures(moment: Moment, seen: Measurement) -> Measurement:
    """All pressure transducers repeat what they read."""
    return seen._replace(pressures=moment.first.pressures)


def crossed_transducers(_moment: Moment, seen: Measurement) -> Measurement:
    """Boom's and stick's cylinder transducers are plugged the wrong way round."""
    swing, boom, stick = seen.actuators.position
    return seen._replace(actuators=seen.actuators._replace(position=(swing, stick, boom)))


def no_command(_moment: Moment, _command: Command) -> None:
    """Commands do not reach the driver."""


def late_command(moment: Moment, command: Command) -> Command | None:
    """A command reaches the driver now and then."""
    return command if moment.since % SELDOM < 0.5 * PERIOD else None


def no_number(_moment: Moment, command: Command) -> Command:
    """Commands are no numbers."""
    return command._replace(values=ZERO, problem="valve_commands: not finite")


def repeated(moment: Moment, command: Command) -> Command:
    """A controller that hangs: its last command again and again."""
    first: Command = moment.first
    return first._replace(sent=command.sent)


def no_volts(_moment: Moment, _volts: Vec3) -> Vec3:
    """The valves' cable is cut."""
    return ZERO


def stuck(moment: Moment, volts: Vec3) -> Vec3:
    """One spool stays where it is."""
    return _with(volts, moment.axis, moment.first[moment.axis])


def not_closing(moment: Moment, volts: Vec3) -> Vec3:
    """A chip holds one spool open by a third, on the side to which it last went."""
    i = moment.axis
    side = math.copysign(1.0, moment.first[i] or 1.0)
    return _with(volts, i, side * max(side * volts[i], CHIP * RATED))


def crossed_valves(moment: Moment, volts: Vec3) -> Vec3:
    """One valve is wired the other way."""
    return _with(volts, moment.axis, -volts[moment.axis])


def wrong_from_here(moment: Moment, volts: Vec3) -> Vec3:
    """Full voltage on one valve, whatever the driver says: a short circuit."""
    return _with(volts, moment.axis, RATED)


def _with(volts: Vec3, axis: int, value: float) -> Vec3:
    changed = list(volts)
    changed[axis] = value
    return changed[0], changed[1], changed[2]


def torn_hoses(simulation: Simulation, p: PlantParameters) -> tuple[Simulation, PlantParameters]:
    """The bundle of hoses is torn off: each ends in the open, behind the load-holding valves."""
    return simulation, p._replace(guard=TORN)


def no_supply(simulation: Simulation, p: PlantParameters) -> tuple[Simulation, PlantParameters]:
    """The pump's shaft is broken: it gives nothing."""
    given = p.supply
    dead = given._replace(flow_limit=NOTHING * given.flow_limit, compensation=NOTHING * given.compensation)
    return simulation, p._replace(supply=dead)


def stalled(simulation: Simulation, p: PlantParameters) -> tuple[Simulation, PlantParameters]:
    """The engine stands still; nobody starts it again."""
    pump = simulation.plant.pump._replace(speed=0.0)
    return simulation._replace(plant=simulation.plant._replace(pump=pump)), p
