"""The cores of machine, guarded controller and driver in one loop without ROS: the graph in simulated time.

Each period goes round as it does live: the machine reports, controller and driver answer within the period,
the voltages act over the next one. Before the first report a period passes under shut valves. The controller
is the node's, guard included: joystick watch and interpolation, order and age of states, sensor checks. A
session begins with the deadman held and the levers centred, so that the first deflection counts.

Sensors are exact unless a suite is given. Without noise a joint that stands reads the same number again, so
such resolvers are not taken for frozen. The driver takes the nominal load while a pressure has no reading.
Links between the cores (`link_model`) may delay, jitter and lose what passes. A joystick, a state or a
command that is older than its timeout, by arrival, means zero.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from forest_control import compiled
from forest_control.config import controller_settings
from forest_control.operator.joystick_watch import Sample
from forest_control.operator.levers import Levers
from forest_control.pipeline import controller
from forest_control.pipeline.control_state import Telemetry, ValveFeedback
from forest_control.pipeline.guarded_controller import GuardedController
from forest_control.safety.driver_response import DriverSample
from forest_control.safety.motion_permission import Permission, Verdict, armed_watch
from forest_control.valve import valve_driver, valve_driver_parameters
from forest_control.valve.tracking_limit import STATUS_EVERY, learnt_opening_ratio
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import ZERO, Floats, Vec3
from forest_msgs_py.types import PERIOD, PERIOD_NS
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors.sensor_readings import NOMINAL
from forest_sim.sensors.sensor_run import SensorRun
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.sensors.sensor_suite import sensor_suite as suite_of
from forest_sim.sensors.signal_processing import Measurement
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.load_change import changed_load
from forest_study.closed_loop.link_model import Link, Quality, Reports, reported
from forest_study.closed_loop.loop_core import (
    SUBSTEPS,
    Happened,
    driver_inputs,
    guard_of,
    machine_state,
    sample,
)

COMMAND_TIMEOUT = 0.1  # [s] as the valve driver's default


class Operator(NamedTuple):
    """What the operator does at a time: levers, and whether the deadman is held."""

    levers: Levers
    enabled: bool = True


# What comes of the joystick in a period: what the operator does, nothing, or samples as they came.
Joystick = Operator | Sequence[Sample] | None


class Links(NamedTuple):
    """How bad the ways between the cores are."""

    joystick: Quality = Quality()  # to the controller
    state: Quality = Quality()  # of the machine, to the controller
    commands: Quality = Quality()  # to the driver
    seed: int = 0


class Lateness(NamedTuple):
    """How late each period's answers are."""

    commands: Sequence[int] = ()  # that a driver which is held up leaves unanswered
    states: Sequence[float] = ()  # [s] after its stamp that the machine's state is there


PERFECT, IN_TIME = Links(), Lateness()


class Trajectory(NamedTuple):
    """A session, one row per period."""

    time: Floats  # [N] s
    angles: Floats  # [N, 3] rad, true
    tip: Floats  # [N, 3] m, true
    tip_wish: Floats  # [N, 3] m/s, the tip's reference velocity
    commands: Floats  # [N, 3] V of ideal valves
    voltages: Floats  # [N, 3] V
    pressures: Floats  # [N, 12] Pa

    def tip_error(self) -> Floats:
        """Return true tip minus integrated reference [N, 3] m, from the first row on."""
        wished = np.vstack([np.zeros(3), np.cumsum(self.tip_wish[:-1], axis=0) * PERIOD])
        error: Floats = self.tip - self.tip[0] - wished
        return error


def run(
    machine: Machine,
    operator: Callable[[float], Joystick],
    duration: float,
    start: Vec3,
    control: controller_settings.Settings,
    drive: valve_driver_parameters.Settings,
    model: Machine | None = None,
    sensor_suite: Suite | None = None,
    ways: Links = PERFECT,
    watch: Callable[[float, Vec3], None] = lambda _time, _angles: None,
    plant: PlantParameters | None = None,
    late: Lateness = IN_TIME,
    fast: bool = False,
) -> Trajectory:
    """Run a session.

    Args:
        machine: what is simulated.
        operator: time [s] to what comes of the joystick.
        duration: [s].
        start: joint angles [rad], at rest.
        control: the controller's settings.
        drive: the valve driver's settings.
        model: what controller and driver believe; default: the machine itself.
        sensor_suite: with their errors, noise, seed and faults; default: the machine's, exact.
        ways: bad links between the cores; default: perfect ones.
        watch: is told time [s] and true joint angles [rad] after each period: an operator's eyes.
        plant: what is simulated instead of the machine's own parameters.
        late: answers that do not come within their period; default: none.
        fast: controller and driver are machine code, where that has been made.
    """
    p = plant_parameters(machine) if plant is None else plant
    believed = machine if model is None else model
    suite = suite_of(machine) if sensor_suite is None else sensor_suite
    cores = (
        controller_settings.parameters(believed, control),
        valve_driver_parameters.parameters(believed, drive),
    )
    loop = ClosedLoop(p, *cores, start, suite, ways, late, fast)
    rows = []
    for k in range(round(duration / PERIOD)):
        happened = loop.period(operator(k * PERIOD))
        rows.append(happened._replace(tip=tip_position(happened.angles, machine.manipulator.links)))
        watch(k * PERIOD, happened.angles)
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    return Trajectory(PERIOD * np.arange(len(rows), dtype=np.float64), *columns)


def until_first_report(simulation: Simulation, p: PlantParameters) -> Simulation:
    """Return a machine at rest a period later, its valves shut: live, nobody has answered it before."""
    return compiled_advance()(simulation, ZERO, PERIOD / SUBSTEPS, SUBSTEPS, p)


class ClosedLoop:
    """Machine, links, controller and driver between periods.

    Args:
        p: of the machine.
        control: the controller's parameters.
        drive: the valve driver's.
        start: joint angles [rad], at rest.
        suite: sensors.
        ways: quality of the links.
        late: answers that do not come within their period.
        fast: controller and driver are machine code, where that has been made.
        substeps: of the machine, to a period.
    """

    def __init__(
        self,
        p: PlantParameters,
        control: controller_settings.Parameters,
        drive: valve_driver_parameters.Parameters,
        start: Vec3,
        suite: Suite,
        ways: Links = PERFECT,
        late: Lateness = IN_TIME,
        fast: bool = False,
        substeps: int = SUBSTEPS,
    ) -> None:
        self._plant, self._drive, self._substeps = p, drive, substeps
        rest = equilibrium(start, p)
        self._sensors = SensorRun(rest, p, control.links, suite, NOMINAL)
        self._simulation, self._advance = until_first_report(rest, p), compiled_advance()
        self._step = compiled.controller_step() if fast else controller.step_with_telemetry
        self._answer = compiled.driver_step() if fast else valve_driver.step
        self.controller = GuardedController(control, guard_of(suite), self._step)
        self.controller.guard.permission = Permission(joystick=armed_watch())
        self.telemetry: Telemetry | None = None  # of the last state that was believed
        self._driver, self._reports, self._reference = valve_driver.REST, Reports(), ZERO
        self._joystick: Link[Sample] = Link(ways.joystick, 3 * ways.seed)
        self._states: Link[tuple[int, Measurement]] = Link(ways.state, 3 * ways.seed + 1)
        self._commands: Link[tuple[float, Vec3]] = Link(ways.commands, 3 * ways.seed + 2)
        self._newest: tuple[float, Vec3] = (-math.inf, ZERO)  # command at the driver, after when it was sent
        self._command_received = -math.inf
        self._behind, self._late = iter(late.commands), iter(late.states)
        self._waiting: list[Vec3] = []  # commands that a driver which is held up has not answered
        self._volts, self._held, self._count = ZERO, 0, 0  # given last, in force for so many periods

    @property
    def simulation(self) -> Simulation:
        """The machine as it is now."""
        return self._simulation

    def change_load(self, plant: PlantParameters) -> None:
        """Go on with the parameters of a machine whose head holds another log."""
        self._simulation = changed_load(self._simulation, self._plant, plant).simulation
        self._plant = plant
        self._sensors.set_plant(plant, NOMINAL)

    def period(self, joystick: Joystick) -> Happened:
        """Return what happened in a period, and move the machine over it; the tip is left out."""
        heard = self._count * PERIOD + next(self._late, 0.0)
        seen = self._sense()
        true = self._simulation.plant
        angles = true.swing.angle, true.boom.angle, true.stick.angle
        self._hear(joystick, heard)
        self._report((self._count + 1) * PERIOD_NS, seen, heard)
        self._control(heard)
        command = self._command(heard)
        volts = self._in_force(command, seen)
        learnt = self._reports.newer
        if self._reports.step % STATUS_EVERY == 0:  # else the driver's next step says nothing of it
            learnt = learnt_opening_ratio(self._driver.estimates, self._drive.axes)
        self._reports = reported(self._reports, learnt)
        self._move(volts)
        self._count += 1
        return Happened(
            angles=angles,
            tip=ZERO,
            tip_wish=self._reference,
            command=command,
            voltages=volts,
            pressures=seen.pressures,
        )

    def _sense(self) -> Measurement:
        """Return what the sensors say."""
        return self._sensors.sample(self._simulation, PERIOD).seen

    def _report(self, stamp: int, seen: Measurement, now: float) -> None:
        """Put what the sensors say on its way to the controller, under a stamp [ns]."""
        self._states.send(now, (stamp, seen))

    def _move(self, volts: Vec3) -> None:
        """Move the machine over a period under the valves' voltages [V]."""
        step = PERIOD / self._substeps
        self._simulation = self._advance(self._simulation, volts, step, self._substeps, self._plant)

    def _hear(self, joystick: Joystick, now: float) -> None:
        """Have the controller hear what has come of the joystick."""
        if isinstance(joystick, Operator):
            self._joystick.send(now, sample(joystick.levers, joystick.enabled, self._count))
            joystick = None
        arrived = [one._replace(received=now) for one in self._joystick.arrived(now)]
        for one in (*arrived, *(joystick or ())):
            self.controller.guard.hear(one)

    def _control(self, now: float) -> None:
        """Have the controller answer the states that have arrived, or their absence."""
        driver = DriverSample(self._driver.voltages, now)
        valves = ValveFeedback(self._reports.heard, self._driver.voltages, driver)
        lost = self.controller.stops_without_state(now)
        for stamp, seen in self._states.arrived(now):
            machine = machine_state(seen, stamp, now)
            cylinders = seen.actuators.position[1], seen.actuators.position[2]
            decision, telemetry = self.controller.advance(machine, valves, now, cylinders)
            if decision.verdict != Verdict.SKIP:
                self._commands.send(now, (now, self.controller.command))
                self._reference = telemetry.output.tip_velocity_reference if telemetry else ZERO
                self.telemetry = telemetry or self.telemetry
                lost = False
        if lost:
            self._commands.send(now, (now, ZERO))
            self._reference = ZERO

    def _command(self, now: float) -> Vec3:
        """Return the command that the driver goes by: the newest, until it is too old."""
        for command in self._commands.arrived(now):
            if command[0] >= self._newest[0]:
                self._newest, self._command_received = command, now
        return self._newest[1] if now - self._command_received <= COMMAND_TIMEOUT else ZERO

    def _in_force(self, command: Vec3, seen: Measurement) -> Vec3:
        """Return the voltages under which the machine moves over this period; a held-up driver's last."""
        self._waiting.append(command)
        self._held += 1
        behind = next(self._behind, 0)
        while len(self._waiting) > behind:
            pressures, motion = driver_inputs(seen, self._drive.idle_pressure)
            command, dt = self._waiting.pop(0), self._held * PERIOD
            self._driver, self._volts = self._answer(
                self._driver, command, pressures, motion, self._drive, dt
            )
            self._held = 0
        return self._volts
