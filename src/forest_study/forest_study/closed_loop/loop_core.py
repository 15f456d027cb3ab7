"""One period of machine, sensors, guarded controller and driver: a function of numbers, for machine code.

    loop, levers -> sensors -> may the crane move? -> controller -> driver -> plant -> loop, what happened

It does what a `closed_loop` period does without links, number by number, with those of the sensors that
control reads. The checks are those of `motion_permission`: joystick watch, plausible state, frozen sensor,
driver that does not respond. Two of its stations are left out. Stamps are in order and states fresh, for here
nothing is late. And the levers need no interpolation, for the joystick speaks in each period; it would need a
number of samples that varies, which machine code of fixed shape has not.

Everything here stays in the subset of Python that `forest_compile` translates; `loop_kernel` makes the
machine code.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from forest_control.config import settings as control_settings
from forest_control.operator.joystick_watch import Sample, Watch, WatchParameters, heed, judge
from forest_control.operator.levers import Levers
from forest_control.pipeline import control_state, controller
from forest_control.safety.driver_response import DriverSample
from forest_control.safety.motion_permission import Checks, armed_watch, checked, passes
from forest_control.safety.state_checks import plausible
from forest_control.servo.joint_angle_filter import Lengths
from forest_control.valve import valve_driver
from forest_control.valve.tracking_limit import learnt_reach
from forest_description.geometry.kinematics import Links, tip_position
from forest_description.types import ZERO, Vec3
from forest_msgs_py.types import NS_PER_S, PERIOD
from forest_sim.sensors.sensor_model import ABSENT, SensorMemory, SensorModel, sample_if
from forest_sim.sensors.sensor_readings import axis_pressures
from forest_sim.sensors.sensor_suite import PLACES, TIME_TOLERANCE
from forest_sim.sensors.signal_processing import SpeedEstimate, estimate_speed
from forest_sim.solver import integrator
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.plant import ports_at, transmissions
from forest_sim.solver.plant_parameters import PlantParameters
from forest_study.closed_loop.link_model import Reports, reported

CHANNEL_COUNT = PLACES["pressure"].stop  # resolvers, transducers, pressures: the suite's first channels
SUBSTEPS = 5  # of 1 ms
PERIOD_NS = round(PERIOD * NS_PER_S)
WATCH = WatchParameters()


class Sensing(NamedTuple):
    """The sensors that control reads, and their sampling period [s]."""

    channels: tuple[SensorModel, ...]
    period: float


class Senses(NamedTuple):
    """What sensors and estimators of the joints' rates remember."""

    channels: tuple[SensorMemory, ...]
    estimates: tuple[SpeedEstimate, SpeedEstimate, SpeedEstimate]
    time: float  # [s]
    next_sample: float  # [s]


class Guarded(NamedTuple):
    """What the controller and its guard remember."""

    state: control_state.State = control_state.REST
    command: Vec3 = ZERO  # [V] the last one
    joystick: Watch = armed_watch()
    checks: Checks = Checks()


class Loop(NamedTuple):
    """All that is remembered between two periods."""

    simulation: Simulation
    senses: Senses
    control: Guarded
    drive: valve_driver.State
    reports: Reports


class Knowledge(NamedTuple):
    """All that stays: the machine, its sensors, and what controller and driver believe."""

    plant: PlantParameters
    links: Links  # of the machine
    sensing: Sensing
    control: control_settings.Parameters
    drive: valve_driver.Parameters


class Happened(NamedTuple):
    """What is recorded of a period."""

    angles: Vec3  # [rad] true
    tip: Vec3  # [m] true
    tip_wish: Vec3  # [m/s]
    command: Vec3  # [V]
    voltages: Vec3  # [V]
    pressures: tuple[float, ...]  # [Pa] read, 12


class Seen(NamedTuple):
    """What controller and driver hear of the machine; NaN where there is no sensor."""

    angles: Vec3  # [rad]
    rates: Vec3  # [rad/s]
    cylinders: Lengths  # [m] boom, stick
    pressures: tuple[float, ...]  # [Pa] 12
    supply: float  # [Pa]


def period(
    loop: Loop, levers: Levers, held: bool, k: Knowledge, normals: Sequence[float], row: int
) -> tuple[Loop, Happened]:
    """Return the loop a period later, and what happened.

    Args:
        loop: as it was.
        levers: deflections, -1..1.
        held: whether the deadman is.
        k: what stays.
        normals: draws from the standard normal distribution, `CHANNEL_COUNT` for each period.
        row: number of the period, from 0.
    """
    plant = loop.simulation.plant
    angles = plant.swing.angle, plant.boom.angle, plant.stick.angle
    senses = sensed(loop.simulation, loop.senses, k, normals, CHANNEL_COUNT * row)
    seen = _seen(senses, k.sensing)
    control, velocity = guarded(loop.control, levers, held, seen, loop, k, row)
    pressures, motion = driver_inputs(seen, k.drive.idle_pressure)
    drive, volts = valve_driver.step_seen(loop.drive, control.command, pressures, motion, k.drive, PERIOD)
    simulation = loop.simulation
    for _ in range(SUBSTEPS):
        simulation = integrator.step(simulation, volts, PERIOD / SUBSTEPS, k.plant)
    happened = Happened(
        angles=angles,
        tip=tip_position(angles, k.links),
        tip_wish=velocity,
        command=control.command,
        voltages=volts,
        pressures=seen.pressures,
    )
    reports = reported(loop.reports, learnt_reach(drive.learners, k.drive.axes))
    return Loop(simulation, senses, control, drive, reports), happened


def guarded(
    before: Guarded, levers: Levers, held: bool, seen: Seen, loop: Loop, k: Knowledge, row: int
) -> tuple[Guarded, Vec3]:
    """Return the guarded controller a step on, and the tip's reference velocity [m/s].

    It does what `GuardedController` does when nothing is late.
    """
    now = row * PERIOD
    sample = Sample(
        received=now,
        stamp=(row + 1) * PERIOD_NS,
        heartbeat=row + 1,
        same=False,
        good=True,
        levers=levers,
        held=held,
    )
    joystick = heed(before.joystick, sample)
    if not plausible(seen.angles, seen.rates, k.control):
        return Guarded(joystick=joystick, checks=Checks(driver=before.checks.driver)), ZERO
    driver = DriverSample(loop.drive.voltages, now)
    checks = checked(before.checks, seen.angles, driver, before.command, k.control, now, PERIOD)
    sound = passes(checks, now)
    joystick, operator = judge(joystick, now, sound, WATCH)
    if not sound:
        return Guarded(joystick=joystick, checks=Checks(driver=checks.driver)), ZERO
    inputs = control_state.Inputs(
        angles=seen.angles,
        rates=seen.rates,
        levers=operator.levers,
        enabled=operator.enabled,
        cylinders=seen.cylinders,
        reach=loop.reports.reach,
        voltages=loop.drive.voltages,
    )
    state, output = controller.step(before.state, inputs, k.control, PERIOD)
    return Guarded(state, output.command, joystick, checks), output.tip_wish


def sensed(
    simulation: Simulation, senses: Senses, k: Knowledge, normals: Sequence[float], first: int
) -> Senses:
    """Return the sensors after another sample: `sensors.measure`, for some channels and without faults."""
    time = senses.time + PERIOD
    due = time > senses.next_sample - TIME_TOLERANCE
    true = _true_values(simulation, k.plant)
    before = senses.channels
    channels = tuple(
        [
            sample_if(due, k.sensing.channels[i], before[i], true[i], PERIOD, normals[first + i])[0]
            for i in range(CHANNEL_COUNT)
        ]
    )
    read = _readings(channels, k.sensing)
    e = senses.estimates
    estimates = (
        estimate_speed(e[0], read[0], PERIOD, due),
        estimate_speed(e[1], read[1], PERIOD, due),
        estimate_speed(e[2], read[2], PERIOD, due),
    )
    next_sample = max(time, senses.next_sample + k.sensing.period) if due else senses.next_sample
    return Senses(channels, estimates, time, next_sample)


def _seen(senses: Senses, sensing: Sensing) -> Seen:
    """Return what controller and driver hear in a period."""
    read, e = _readings(senses.channels, sensing), senses.estimates
    return Seen(
        angles=(read[0], read[1], read[2]),
        rates=(e[0].speed, e[1].speed, e[2].speed),
        cylinders=(read[3], read[4]),
        pressures=tuple([read[5 + i] for i in range(12)]),
        supply=read[17],
    )


def _readings(channels: tuple[SensorMemory, ...], sensing: Sensing) -> tuple[float, ...]:
    """Return what the channels say now; NaN where there is no sensor."""
    return tuple([_reading(sensing.channels[i], channels[i]) for i in range(CHANNEL_COUNT)])


def _reading(c: SensorModel, s: SensorMemory) -> float:
    return math.nan if c.mode == ABSENT else s.reading


def _true_values(simulation: Simulation, p: PlantParameters) -> tuple[float, ...]:
    """Return what exact channels would read."""
    plant, supply = simulation.plant, simulation.plant.supply.pressure
    ports = ports_at(simulation.spools, p)
    t_1, t_2, t_3 = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
    return (
        *(plant.swing.angle, plant.boom.angle, plant.stick.angle),
        *(t_2.position, t_3.position),
        *axis_pressures(plant.swing, p.swing, t_1, ports[0], supply),
        *axis_pressures(plant.boom, p.boom, t_2, ports[1], supply),
        *axis_pressures(plant.stick, p.stick, t_3, ports[2], supply),
        supply,
    )


def driver_inputs(seen: Seen, idle_pressure: float) -> tuple[valve_driver.Pressures, valve_driver.Motion]:
    """Return what the driver gets; the idle supply [Pa] where the supply is not read."""
    at, supply = seen.pressures, idle_pressure if math.isnan(seen.supply) else seen.supply
    pressures = valve_driver.Pressures((at[1], at[5], at[9]), (at[3], at[7], at[11]), supply)
    motion = valve_driver.Motion(
        positions=(seen.angles[0], seen.cylinders[0], seen.cylinders[1]),
        valve_1=(at[0], at[4], at[8]),
        valve_2=(at[2], at[6], at[10]),
    )
    return pressures, motion
