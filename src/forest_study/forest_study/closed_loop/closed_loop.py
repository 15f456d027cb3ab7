"""The cores of machine, controller and driver in one loop without ROS: the graph in simulated time.

Each period goes round as it does live: the machine reports, controller and driver answer within the period,
the voltages act over the next one; before the first report a period passes under shut valves. Sensors are
exact unless a suite is given. As live, the controller stands still while a joint has no reading, and the
driver takes the nominal load while a pressure has none.

Links between the cores may delay, jitter and lose what passes. A reader takes the newest that has arrived; a
joystick, a state or a command that is older than its timeout, by arrival, means zero.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from forest_control.operator.levers import REST, Levers
from forest_control.pipeline import controller
from forest_control.safety.state_checks import implausible
from forest_control.valve import valve_driver
from forest_control.valve.tracking_limit import UNREPORTED, learnt_reach, reported
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import ZERO, Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.sensors import sensor_readings
from forest_sim.sensors.sensor_suite import Suite, draw, noise_generator
from forest_sim.sensors.sensor_suite import sensor_suite as suite_of
from forest_sim.sensors.signal_processing import Measurement
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.plant_kernel import compiled_advance
from forest_sim.solver.plant_parameters import PlantParameters, plant_parameters
from forest_study.closed_loop.link_model import Quality, Reader

SUBSTEPS = 5  # of 1 ms


class Operator(NamedTuple):
    """What the operator does at a time: levers, and whether the deadman is held."""

    levers: Levers
    enabled: bool = True


class Links(NamedTuple):
    """How bad the ways between the cores are."""

    joystick: Quality = Quality()  # to the controller
    state: Quality = Quality()  # of the machine, to the controller
    commands: Quality = Quality()  # to the driver
    seed: int = 0


JOY_TIMEOUT, STATE_TIMEOUT, COMMAND_TIMEOUT = 0.15, 0.1, 0.1  # [s] as the nodes' defaults
RELEASED = Operator(REST, False)


class Trajectory(NamedTuple):
    """A session, one row per period."""

    time: Floats  # [N] s
    angles: Floats  # [N, 3] rad, true
    tip: Floats  # [N, 3] m, true
    tip_wish: Floats  # [N, 3] m/s, governed
    commands: Floats  # [N, 3] V of ideal valves
    voltages: Floats  # [N, 3] V
    pressures: Floats  # [N, 12] Pa

    def tip_error(self) -> Floats:
        """Return true tip minus integrated wish [N, 3] m, from the first row on."""
        wished = np.vstack([np.zeros(3), np.cumsum(self.tip_wish[:-1], axis=0) * PERIOD])
        error: Floats = self.tip - self.tip[0] - wished
        return error


def run(
    machine: Machine,
    operator: Callable[[float], Operator],
    duration: float,
    start: Vec3,
    control: controller.Settings,
    drive: valve_driver.Settings,
    model: Machine | None = None,
    sensor_suite: Suite | None = None,
    ways: Links | None = None,
    watch: Callable[[float, Vec3], None] = lambda _time, _angles: None,
    plant: PlantParameters | None = None,
    behind: Sequence[int] = (),
) -> Trajectory:
    """Run a session.

    Args:
        machine: what is simulated.
        operator: time [s] to levers and deadman.
        duration: [s].
        start: joint angles [rad], at rest.
        control: the controller's settings.
        drive: the valve driver's settings.
        model: what controller and driver believe; default: the machine itself.
        sensor_suite: with their errors, noise, seed and faults; default: the machine's, exact.
        ways: bad links between the cores; default: perfect ones.
        watch: is told time [s] and true joint angles [rad] after each period: an operator's eyes.
        plant: what is simulated instead of the machine's own parameters.
        behind: of each period, how many commands a driver that is held up leaves unanswered.
    """
    p = plant_parameters(machine) if plant is None else plant
    believed = machine if model is None else model
    suite = suite_of(machine) if sensor_suite is None else sensor_suite
    cores = controller.parameters(believed, control), valve_driver.parameters(believed, drive)
    begun = p, *cores, start, suite, behind
    loop = _Loop(*begun) if ways is None else _LateLoop(*begun, ways)
    rows = []
    for k in range(round(duration / PERIOD)):
        rows.append(loop.period(operator(k * PERIOD)))
        watch(k * PERIOD, rows[-1][0])
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    links = machine.manipulator.links
    tip = np.array([tip_position(tuple(q), links) for q in columns[0].tolist()])
    return Trajectory(PERIOD * np.arange(len(rows), dtype=np.float64), columns[0], tip, *columns[1:])


def until_first_report(simulation: Simulation, p: PlantParameters) -> Simulation:
    """Return a machine at rest a period later, its valves shut: live, nobody has answered it before."""
    return compiled_advance()(simulation, ZERO, PERIOD / SUBSTEPS, SUBSTEPS, p)


class _Loop:
    """State of the three cores between periods."""

    def __init__(
        self,
        p: PlantParameters,
        control: controller.Parameters,
        drive: valve_driver.Parameters,
        start: Vec3,
        suite: Suite,
        behind: Sequence[int] = (),
    ) -> None:
        self._plant, self._control, self._drive = p, control, drive
        rest = equilibrium(start, p)
        self._suite, self._generator = suite, noise_generator(suite)
        self._sensors = sensor_readings.at_rest(rest, p, suite)
        self._simulation = until_first_report(rest, p)
        self._controller, self._driver = controller.REST, valve_driver.REST
        self._reports = UNREPORTED
        self._behind = iter(behind)
        self._waiting: list[Vec3] = []  # commands
        self._volts, self._held = ZERO, 0  # given last, in force for so many periods
        self._advance = compiled_advance()

    def period(self, operator: Operator) -> tuple[Vec3, Vec3, Vec3, Vec3, tuple[float, ...]]:
        """Return a period's angles, tip wish, commands, voltages, pressures, and move the machine over it."""
        self._sensors, seen = sensor_readings.measure(
            self._simulation, self._sensors, self._plant, PERIOD, self._suite, draw(self._generator)
        )
        angles = sensor_readings.true_joints(self._simulation, self._plant).position
        wish, command = self._answer(seen, operator)
        volts = self._in_force(command, seen)
        self._reports = reported(self._reports, learnt_reach(self._driver.estimates, self._drive.axes))
        self._simulation = self._advance(self._simulation, volts, PERIOD / SUBSTEPS, SUBSTEPS, self._plant)
        return angles, wish, command, volts, seen.pressures

    def _answer(self, seen: Measurement, operator: Operator) -> tuple[Vec3, Vec3]:
        """Return the tip's wish, and the command that reaches the driver."""
        return self._control_step(seen, operator)

    def _in_force(self, command: Vec3, seen: Measurement) -> Vec3:
        """Return the voltages under which the machine moves over this period; a held-up driver's last."""
        self._waiting.append(command)
        self._held += 1
        behind = next(self._behind, 0)
        while len(self._waiting) > behind:
            self._driver, self._volts = valve_driver.step(
                self._driver,
                self._waiting.pop(0),
                _pressures(seen, self._drive.idle_pressure),
                self._drive,
                self._held * PERIOD,
                _motion(seen),
            )
            self._held = 0
        return self._volts

    def _control_step(self, seen: Measurement, operator: Operator) -> tuple[Vec3, Vec3]:
        """Return the tip's wish and the command; both zero while the joints' state cannot be believed."""
        if implausible(seen.joints.position, seen.joints.speed, self._control):
            self._controller = controller.REST
            return ZERO, ZERO
        lengths = seen.actuators.position[1], seen.actuators.position[2]
        reach, volts = self._reports.reach, self._driver.voltages
        inputs = controller.Inputs(seen.joints.position, seen.joints.speed, *operator, lengths, reach, volts)
        self._controller, output = controller.step(self._controller, inputs, self._control, PERIOD)
        return output.tip_wish, output.command


class _LateLoop(_Loop):
    """The same with links between operator, machine, controller and driver."""

    def __init__(
        self,
        p: PlantParameters,
        control: controller.Parameters,
        drive: valve_driver.Parameters,
        start: Vec3,
        suite: Suite,
        behind: Sequence[int],
        ways: Links,
    ) -> None:
        super().__init__(p, control, drive, start, suite, behind)
        self._joystick: Reader[Operator] = Reader(ways.joystick, 3 * ways.seed, JOY_TIMEOUT)
        self._states: Reader[Measurement] = Reader(ways.state, 3 * ways.seed + 1, STATE_TIMEOUT)
        self._commands: Reader[Vec3] = Reader(ways.commands, 3 * ways.seed + 2, COMMAND_TIMEOUT)
        self._now, self._wish = 0.0, ZERO

    def _answer(self, seen: Measurement, operator: Operator) -> tuple[Vec3, Vec3]:
        self._now += PERIOD
        hand, _ = self._joystick.passed(self._now, operator)
        state, is_new = self._states.passed(self._now, seen)
        if state is None:
            self._controller, self._wish = controller.REST, ZERO
            command, _ = self._commands.passed(self._now, ZERO)
        elif is_new:  # the controller steps when a state arrives
            self._wish, wanted = self._control_step(state, RELEASED if hand is None else hand)
            command, _ = self._commands.passed(self._now, wanted)
        else:
            command, _ = self._commands.passed(self._now, None)
        return self._wish, ZERO if command is None else command


def _pressures(seen: Measurement, supply: float) -> valve_driver.Pressures | None:
    """Return what the driver may believe: all ports or none; the idle supply [Pa] where it is not read."""
    ports = _at_port(seen, 1), _at_port(seen, 2)
    if any(map(math.isnan, (*ports[0], *ports[1]))):
        return None
    return valve_driver.Pressures(
        *ports, supply if math.isnan(seen.supply_pressure) else seen.supply_pressure
    )


def _motion(seen: Measurement) -> valve_driver.Motion:
    """Return what the driver learns from; what is not read is NaN, from which it learns nothing."""
    return valve_driver.Motion(seen.actuators.position, _at_port(seen, 1, 0), _at_port(seen, 2, 0))


def _at_port(seen: Measurement, port: int, place: int = 1) -> Vec3:
    """Return the pressures [Pa] of one port, swing, boom, stick; place: 0 at the valve, 1 at the actuator."""
    first = place if port == 1 else 2 + place
    return seen.pressures[first], seen.pressures[first + 4], seen.pressures[first + 8]
