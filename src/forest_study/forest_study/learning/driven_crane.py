"""The crane under an action, a step of 20 ms at a time: through our controller, or by valve voltages alone.

| actions | an action's three numbers, -1..1 | what they go to |
|---|---|---|
| tip | tip velocity along x, y, z, by `TIP_SPEED` | levers, controller (coordinated), valve driver |
| joint | levers of swing, boom, stick; by 0.8, 0.25, 0.25 rad/s | levers, controller (joint), valve driver |
| voltages | voltages of swing, boom, stick, by each valve's rated voltage | the valves |

The joystick speaks once a step, as one of 50 Hz: between two words the controller interpolates.
Sensors and plant are the same in all three. What is sensed and where the tip is are of the last of the four
periods of a step.
"""

from typing import NamedTuple, Protocol

import numpy as np

from forest_compile import flat_layout
from forest_control.config.controller_settings import Settings
from forest_control.operator.levers import Levers
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors.sensor_readings import NOMINAL
from forest_sim.sensors.sensor_run import SensorRun
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.closed_loop import until_first_report
from forest_study.closed_loop.loop_core import SUBSTEPS

PERIODS = 4  # of a step: 20 ms, as an operator's looks in the log work
TIP_SPEED = 1.0  # [m/s] at a full action
JOINT_RATES = Settings().joint_rates  # [rad/s] at a full action
ACTUATORS = (1, 3, 5, 7, 9, 11)  # of twelve pressures: ports 1 and 2 of swing, boom, stick at the actuator
ESTIMATES = tuple(f"loop.sensors.estimates[{i}].{part}" for part in ("position", "speed") for i in range(3))
ARMED = "loop.control.permission.joystick.armed"
NAMES = ("tip", "joint", "voltages")


class Sensed(NamedTuple):
    """What a step ends with."""

    angles: Vec3  # [rad] measured
    rates: Vec3  # [rad/s] measured
    pressures: tuple[float, ...]  # [Pa] measured, six; NaN where there is no transducer
    tip: Vec3  # [m] true


class DrivenCrane(Protocol):
    """A crane that an action moves."""

    @property
    def stopped(self) -> bool:
        """Whether the controller's guard has taken the levers away."""

    def move(self, action: Vec3) -> Sensed:
        """Move over a step."""


class LeverCrane:
    """A crane with our controller.

    Args:
        machine: what is simulated, and what the controller believes.
        actions: tip or joint.
        start: joint angles [rad], at rest.
        suite: sensors.
        steps: that it moves at most.
        plant: what is simulated instead of the machine's own parameters.
    """

    def __init__(
        self,
        machine: Machine,
        actions: str,
        start: Vec3,
        suite: Suite,
        steps: int,
        plant: PlantParameters | None = None,
    ) -> None:
        self._tip = actions == "tip"
        scheme = Scheme.COORDINATED if self._tip else Scheme.JOINT
        held = np.tile(np.array([0.0, 0.0, 0.0, 1.0]), (PERIODS * steps, 1))
        settings, driver = Settings(scheme=scheme, tip_speed=TIP_SPEED), valve_driver_parameters.Settings()
        prepared = compiled_loop.prepared(machine, held, start, settings, driver, suite=suite, plant=plant)
        self._session = compiled_loop.Session(prepared, every=PERIODS)
        names = [path for path, _ in flat_layout.leaves(self._session.loop, "loop")]
        self._read, self._armed = [names.index(name) for name in ESTIMATES], names.index(ARMED)

    @property
    def stopped(self) -> bool:
        """Whether the controller's guard has taken the levers away."""
        return not self._session.state[self._armed]

    def move(self, action: Vec3) -> Sensed:
        """Move over a step."""
        x, y, z = action
        levers = Levers(y, z, x) if self._tip else Levers(x, y, z)
        session, row = self._session, self._session.row
        session.levers[row : row + PERIODS, :3] = levers
        session.advance(row + PERIODS)
        happened = session.newest
        a, b, c, u, v, w = session.state[self._read].tolist()
        pressures = tuple(happened.pressures[i] for i in ACTUATORS)
        return Sensed((a, b, c), (u, v, w), pressures, happened.tip)


class ValveCrane:
    """A crane without any controller; arguments as `LeverCrane`."""

    stopped = False

    def __init__(
        self, machine: Machine, start: Vec3, suite: Suite, plant: PlantParameters | None = None
    ) -> None:
        self._plant = plant_parameters(machine) if plant is None else plant
        self._links = machine.manipulator.links
        self._rated = [machine.valve_of(axis).rated_voltage for axis in range(3)]
        rest = equilibrium(start, self._plant)
        self._sensors = SensorRun(rest, self._plant, self._links, suite, NOMINAL)
        self._simulation, self._advance = until_first_report(rest, self._plant), compiled_advance()

    def move(self, action: Vec3) -> Sensed:
        """Move over a step."""
        one, two, three = (share * rated for share, rated in zip(action, self._rated, strict=True))
        for _ in range(PERIODS):
            seen = self._sensors.sample(self._simulation, PERIOD).seen
            plant = self._simulation.plant
            volts, dt = (one, two, three), PERIOD / SUBSTEPS
            self._simulation = self._advance(self._simulation, volts, dt, SUBSTEPS, self._plant)
        tip = tip_position((plant.swing.angle, plant.boom.angle, plant.stick.angle), self._links)
        pressures = tuple(seen.pressures[i] for i in ACTUATORS)
        return Sensed(seen.joints.position, seen.joints.speed, pressures, tip)
