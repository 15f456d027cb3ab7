"""One period of machine, sensors, guarded controller and driver: a function of numbers, for machine code.

    loop, levers -> sensors -> may the crane move? -> controller -> driver -> plant -> loop, what happened

It does what a `closed_loop` period does without links, number by number, guard included.

Everything here stays in the subset of Python that `forest_compile` translates; `loop_kernel` makes the
machine code.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from forest_control.config import controller_settings
from forest_control.operator.joystick_watch import Sample
from forest_control.operator.levers import Levers
from forest_control.pipeline import control_state, controller
from forest_control.pipeline.guarded_controller import control_inputs
from forest_control.safety.driver_response import DriverSample
from forest_control.safety.motion_permission import (
    NOBODY,
    MachineState,
    Permission,
    PermissionParameters,
    Verdict,
    armed_watch,
    decide,
    disarmed,
    is_state_lost,
    reset_sensor_watch,
    updated_joystick,
)
from forest_control.valve import load_estimate, valve_driver, valve_driver_parameters
from forest_control.valve.tracking_limit import learnt_opening_ratio
from forest_description.geometry.kinematics import Links, tip_position
from forest_description.types import ZERO, Vec3
from forest_msgs_py.types import PERIOD, PERIOD_NS
from forest_sim.sensors.sensor_readings import CHANNEL_COUNT, Sensors, SensorState, sampled
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.sensors.signal_processing import Measurement
from forest_sim.solver import integrator
from forest_sim.solver.integrator import Simulation
from forest_study.closed_loop.link_model import Reports, reported

SUBSTEPS = 5  # of 1 ms, unless a study chooses other ones


def guard_of(suite: Suite) -> PermissionParameters:
    """Return what is set of the guard: resolvers without noise are not judged by standing still."""
    return PermissionParameters(noise_free=not any(channel.noise for channel in suite.channels[:3]))


class Guarded(NamedTuple):
    """What the controller and its guard remember."""

    permission: Permission = Permission(joystick=armed_watch())
    state: control_state.State = control_state.REST
    command: Vec3 = ZERO  # [V] the last one


def stopped(before: Guarded) -> Guarded:
    """Return the controller with all motion forgotten: the command is zero."""
    return Guarded(reset_sensor_watch(before.permission), control_state.stopped(before.state))


class Loop(NamedTuple):
    """All that is remembered between two periods."""

    simulation: Simulation
    sensors: SensorState
    control: Guarded
    drive: valve_driver.State
    reports: Reports


class Knowledge(NamedTuple):
    """All that stays: the machine, its sensors, and what controller and driver believe."""

    sensors: Sensors  # and the plant that they measure
    links: Links  # of the machine
    control: controller_settings.Parameters
    drive: valve_driver_parameters.Parameters
    guard: PermissionParameters
    substeps: int = SUBSTEPS  # of the machine, to a period


class Happened(NamedTuple):
    """What is recorded of a period."""

    angles: Vec3  # [rad] true
    tip: Vec3  # [m] true
    tip_wish: Vec3  # [m/s]
    command: Vec3  # [V]
    voltages: Vec3  # [V]
    pressures: tuple[float, ...]  # [Pa] read, 12


NOTHING = Happened(ZERO, ZERO, ZERO, ZERO, ZERO, (0.0,) * 12)


def period(
    loop: Loop, levers: Levers, held: bool, spoken: bool, k: Knowledge, normals: Sequence[float], row: int
) -> tuple[Loop, Happened]:
    """Return the loop a period later, and what happened.

    Args:
        loop: as it was.
        levers: deflections, -1..1.
        held: whether the deadman is.
        spoken: the joystick says so in this period.
        k: what stays.
        normals: draws from the standard normal distribution, `CHANNEL_COUNT` for each period.
        row: number of the period, from 0.
    """
    sensors, seen = sensed(loop, k, normals, row)
    return moved(loop, sensors, seen, levers, held, spoken, k, row)


def sensed(loop: Loop, k: Knowledge, normals: Sequence[float], row: int) -> tuple[SensorState, Measurement]:
    """Return the sensors after a period's sample, and what they say; arguments as of `period`."""
    first = CHANNEL_COUNT * row
    drawn = tuple([normals[first + i] for i in range(CHANNEL_COUNT)])
    return sampled(loop.sensors, loop.simulation, drawn, k.sensors, PERIOD)


def moved(
    loop: Loop,
    sensors: SensorState,
    seen: Measurement,
    levers: Levers,
    held: bool,
    spoken: bool,
    k: Knowledge,
    row: int,
) -> tuple[Loop, Happened]:
    """Return the loop a period later, and what happened, once the sensors have been read by `sensed`."""
    plant = loop.simulation.plant
    angles = plant.swing.angle, plant.boom.angle, plant.stick.angle
    control, velocity = guarded(loop, levers, held, spoken, seen, k, row)
    pressures, motion = driver_inputs(seen, k.drive.idle_pressure)
    drive, volts = valve_driver.step(loop.drive, control.command, pressures, motion, k.drive, PERIOD)
    simulation = loop.simulation
    for _ in range(k.substeps):
        simulation = integrator.step(simulation, volts, PERIOD / k.substeps, k.sensors.plant)
    happened = Happened(
        angles=angles,
        tip=tip_position(angles, k.links),
        tip_wish=velocity,
        command=control.command,
        voltages=volts,
        pressures=seen.pressures,
    )
    reports = reported(loop.reports, learnt_opening_ratio(drive.estimates, k.drive.axes))
    return Loop(
        simulation=simulation, sensors=sensors, control=control, drive=drive, reports=reports
    ), happened


def guarded(
    loop: Loop, levers: Levers, held: bool, spoken: bool, seen: Measurement, k: Knowledge, row: int
) -> tuple[Guarded, Vec3]:
    """Return the guarded controller a step on, and the tip's reference velocity [m/s].

    It does what `GuardedController` does when parameters stay, nothing is taught, and nobody else forbids
    motion.
    """
    control, now = loop.control, row * PERIOD
    before = control
    if spoken:
        before = control._replace(permission=updated_joystick(control.permission, sample(levers, held, row)))
    if is_state_lost(before.permission, now, k.guard):
        before = stopped(before._replace(permission=disarmed(before.permission, now, k.guard)))
    machine = machine_state(seen, (row + 1) * PERIOD_NS, now)
    driver = DriverSample(loop.drive.voltages, now)
    permission, decision = decide(
        before.permission, machine, driver, before.command, k.control, k.guard, now, NOBODY
    )
    if not decision.believed:
        return stopped(before._replace(permission=permission)), ZERO
    cylinders = seen.actuators.position[1], seen.actuators.position[2]
    inputs = control_inputs(machine, decision, cylinders, loop.reports.heard, loop.drive.voltages)
    begun = control_state.stopped(before.state) if decision.verdict == Verdict.STOP else before.state
    state, output = controller.step(begun, inputs, k.control, decision.dt)
    return Guarded(permission, state, output.command), output.tip_velocity_reference


def machine_state(seen: Measurement, stamp: int, now: float) -> MachineState:
    """Return what the controller hears of the machine by a stamp [ns], received at a time [s]."""
    return MachineState(
        angles=seen.joints.position,
        rates=seen.joints.speed,
        stamp=stamp,
        received=now,
        boom_pressures=(seen.pressures[5], seen.pressures[7]),
        supply=seen.supply_pressure,
        lengths=(seen.actuators.position[1], seen.actuators.position[2]),
    )


def sample(levers: Levers, held: bool, row: int) -> Sample:
    """Return what a joystick says in a period that it speaks in: it counts, so that it is known to live."""
    return Sample(
        received=row * PERIOD,
        stamp=(row + 1) * PERIOD_NS,
        heartbeat=row + 1,
        same=False,
        good=True,
        levers=levers,
        held=held,
    )


def driver_inputs(
    seen: Measurement, idle_pressure: float
) -> tuple[load_estimate.Pressures, load_estimate.Motion]:
    """Return what the driver gets; the idle supply [Pa] where the supply is not read."""
    at, supply = seen.pressures, idle_pressure if math.isnan(seen.supply_pressure) else seen.supply_pressure
    pressures = load_estimate.Pressures((at[1], at[5], at[9]), (at[3], at[7], at[11]), supply)
    motion = load_estimate.Motion(
        positions=seen.actuators.position, valve_1=(at[0], at[4], at[8]), valve_2=(at[2], at[6], at[10])
    )
    return pressures, motion
