"""One period of machine, sensors, controller and driver: a function of numbers, for machine code.

    loop, levers -> sensors -> controller -> driver -> plant -> loop, what happened

It does what a `closed_loop` period does, number by number, with those of the sensors that control reads.
Everything here is pure and stays in the subset of Python that `forest_compile.translate` takes; `loop_kernel`
makes the machine code.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from forest_control.operator.levers import Levers
from forest_control.pipeline import controller
from forest_control.safety.state_checks import plausible
from forest_control.valve import valve_driver
from forest_control.valve.tracking_limit import Reports, learnt_reach, reported
from forest_description.geometry.kinematics import Links, tip_position
from forest_description.types import ZERO, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.sensors.sensor_model import ABSENT, Channel, ChannelState, sample_if
from forest_sim.sensors.sensor_readings import axis_pressures
from forest_sim.sensors.sensor_suite import PLACES, TIME_TOLERANCE
from forest_sim.sensors.signal_processing import SpeedEstimate, estimate_speed
from forest_sim.solver import integrator
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.plant import ports_at, transmissions
from forest_sim.solver.plant_parameters import PlantParameters
from forest_study.closed_loop.closed_loop import SUBSTEPS

CHANNEL_COUNT = PLACES["pressure"].stop  # resolvers, transducers, pressures: the suite's first channels


class Sensing(NamedTuple):
    """The sensors that control reads, and their sampling period [s]."""

    channels: tuple[Channel, ...]
    period: float


class Senses(NamedTuple):
    """What sensors and estimators of the joints' rates remember."""

    channels: tuple[ChannelState, ...]
    estimates: tuple[SpeedEstimate, SpeedEstimate, SpeedEstimate]
    time: float  # [s]
    next_sample: float  # [s]


class Loop(NamedTuple):
    """All that is remembered between two periods."""

    simulation: Simulation
    senses: Senses
    control: controller.State
    drive: valve_driver.State
    reports: Reports


class Knowledge(NamedTuple):
    """All that stays: the machine, its sensors, and what controller and driver believe."""

    plant: PlantParameters
    links: Links  # of the machine
    sensing: Sensing
    control: controller.Parameters
    drive: valve_driver.Parameters


class Happened(NamedTuple):
    """What is recorded of a period."""

    angles: Vec3  # [rad] true
    tip: Vec3  # [m] true
    tip_wish: Vec3  # [m/s]
    command: Vec3  # [V]
    voltages: Vec3  # [V]
    pressures: tuple[float, ...]  # [Pa] read, 12


def period(
    loop: Loop, levers: Levers, enabled: bool, k: Knowledge, normals: Sequence[float], first: int
) -> tuple[Loop, Happened]:
    """Return the loop a period later, and what happened.

    Args:
        loop: as it was.
        levers: deflections, -1..1.
        enabled: whether the deadman is held.
        k: what stays.
        normals: draws from the standard normal distribution.
        first: where in `normals` this period's begin, one for each channel.
    """
    plant = loop.simulation.plant
    angles = plant.swing.angle, plant.boom.angle, plant.stick.angle
    senses = sensed(loop.simulation, loop.senses, k, normals, first)
    read, seen = readings(senses, k.sensing), (senses.estimates[0], senses.estimates[1], senses.estimates[2])
    position, speed = (read[0], read[1], read[2]), (seen[0].speed, seen[1].speed, seen[2].speed)
    control, wish, command = controller.REST, ZERO, ZERO
    if plausible(position, speed, k.control):
        reach, volts = loop.reports.reach, loop.drive.voltages
        inputs = controller.Inputs(position, speed, levers, enabled, (read[3], read[4]), reach, volts)
        control, output = controller.step(loop.control, inputs, k.control, PERIOD)
        wish, command = output.tip_wish, output.command
    pressures, motion = driven_by(read, k.drive.idle_pressure)
    drive, volts = valve_driver.step_measured(loop.drive, command, pressures, motion, k.drive, PERIOD)
    simulation = loop.simulation
    for _ in range(SUBSTEPS):
        simulation = integrator.step(simulation, volts, PERIOD / SUBSTEPS, k.plant)
    happened = Happened(
        angles, tip_position(angles, k.links), wish, command, volts, tuple([read[5 + i] for i in range(12)])
    )
    reports = reported(loop.reports, learnt_reach(drive.estimates, k.drive.axes))
    return Loop(simulation, senses, control, drive, reports), happened


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
    read = readings(Senses(channels, senses.estimates, time, 0.0), k.sensing)
    e = senses.estimates
    estimates = (
        estimate_speed(e[0], read[0], PERIOD, due),
        estimate_speed(e[1], read[1], PERIOD, due),
        estimate_speed(e[2], read[2], PERIOD, due),
    )
    next_sample = max(time, senses.next_sample + k.sensing.period) if due else senses.next_sample
    return Senses(channels, estimates, time, next_sample)


def readings(senses: Senses, sensing: Sensing) -> tuple[float, ...]:
    """Return what the channels say now; NaN where there is no sensor."""
    return tuple([_reading(sensing.channels[i], senses.channels[i]) for i in range(CHANNEL_COUNT)])


def _reading(c: Channel, s: ChannelState) -> float:
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


def driven_by(
    read: tuple[float, ...], idle_pressure: float
) -> tuple[valve_driver.Pressures, valve_driver.Motion]:
    """Return what the driver gets; the idle supply [Pa] where the supply is not read."""
    supply = idle_pressure if math.isnan(read[17]) else read[17]
    pressures = valve_driver.Pressures((read[6], read[10], read[14]), (read[8], read[12], read[16]), supply)
    motion = valve_driver.Motion(
        (read[0], read[3], read[4]), (read[5], read[9], read[13]), (read[7], read[11], read[15])
    )
    return pressures, motion
