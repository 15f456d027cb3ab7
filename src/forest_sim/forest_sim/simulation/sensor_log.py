"""What the topics of a graph would carry during a run: the sensors' reports and the simulator's truth.

The one place of offline runs that knows the sensors; columns as
`forest_msgs_py.interfaces.topics.columns` has them.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from forest_description.geometry.kinematics import tip_orientation
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import Topic
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.pump_drive import pump_drive
from forest_sim.sensors import sensor_readings
from forest_sim.sensors.sensor_readings import Report
from forest_sim.sensors.sensor_run import SensorRun
from forest_sim.sensors.sensor_suite import Fault, sensor_suite
from forest_sim.sensors.signal_processing import Motion
from forest_sim.simulation.open_loop import Block
from forest_sim.simulation.simulated_machine import SimulatedMachine
from forest_sim.solver.integrator import Events, Simulation
from forest_sim.solver.oil_temperature import parameters_at
from forest_sim.solver.state_recording import restore

TopicTables = dict[Topic, Floats]
TopicValues = dict[Topic, tuple[float, ...]]
FurtherTopics = dict[Topic, Callable[[SimulatedMachine], tuple[float, ...]]]

SIMULATED_TOPICS = tuple(
    topic
    for topic in topics.TOPICS
    if "simulator" in topic.publishers and topic.labels and topic != topics.GROUND_TRUTH_LOAD
)
"""What every simulated machine tells as numbers; `topic_values` gives them."""
AUXILIARY_KINDS = ("spool_sensor", "case_drain", "thermocouple", "tachometer", "inclinometer")
LOGGED_TOPICS = (*SIMULATED_TOPICS, topics.VALVE_VOLTAGES)


class Sensing(NamedTuple):
    """How the sensors work: exact or as the machine file says of them, and what is wrong with them."""

    noise: bool = False
    seed: int = 0
    faults: tuple[Fault, ...] = ()


EXACT = Sensing()


class SensorLog:
    """Sensors along a run; they remember, so blocks come in order. NaN: there is no reading."""

    def __init__(self, machine: Machine, rate: float, sensing: Sensing = EXACT) -> None:
        self._machine, self._links = machine, machine.manipulator.links
        self._plant = plant_parameters(machine)
        self._period = 1.0 / rate
        self._suite = sensor_suite(machine, sensing.noise, sensing.seed, sensing.faults)
        self._around = sensor_readings.surroundings(machine)
        self._sensors: SensorRun | None = None

    def observe(self, block: Block) -> TopicTables:
        """Return the numbers of every topic, one row per row of the block."""
        temperature = float(block.temperature[0])
        if math.isfinite(temperature):
            self._plant = parameters_at(self._machine, temperature)
            self._around = self._around._replace(temperatures=(temperature,) * 3)
            if self._sensors is not None:
                self._sensors.set_plant(self._plant, self._around)
        rows = [self._sample(restore(row)) for row in block.states]
        observed = {topic: np.array([row[topic] for row in rows], dtype=np.float64) for topic in rows[0]}
        return observed | {topics.VALVE_VOLTAGES: block.voltages, topics.GROUND_TRUTH_LOAD: block.load}

    def _sample(self, simulation: Simulation) -> TopicValues:
        """Return one row of every topic but the voltages."""
        if self._sensors is None:
            self._sensors = SensorRun(simulation, self._plant, self._links, self._suite, self._around)
        report = self._sensors.sample(simulation, self._period)
        return topic_values(report, simulation.events)


def topic_values(report: Report, events: Events, missed_deadlines: int = 0) -> TopicValues:
    """Return the numbers of every topic that the machine's sensors and the simulator's truth have.

    In the order in which a node publishes them: the valve driver's inputs stand before
    /joint_states, which makes the controller step.
    """
    seen = report.seen
    auxiliary = [number for kind in AUXILIARY_KINDS for number in seen.of_kind(kind)]
    return {
        topics.PRESSURES: seen.pressures,
        topics.SUPPLY: (seen.supply_pressure, seen.supply_flow, seen.supply_saturation),
        topics.ACTUATOR_STATES: _motion(seen.actuators),
        topics.JOINT_STATES: _motion(seen.joints),
        topics.FLOWS: seen.of_kind("flow_meter"),
        topics.AUXILIARY: (*auxiliary, *map(float, events), float(missed_deadlines)),
        topics.GROUND_TRUTH_JOINT_STATES: _motion(report.joints),
        topics.GROUND_TRUTH_TIP_POSE: (*report.tip, *tip_orientation(report.joints.position)),
        topics.GROUND_TRUTH_TIP_TWIST: report.tip_velocity,
    }


def further_topics(machine: Machine, has_loads: bool) -> FurtherTopics:
    """Return the topics that not every simulated machine has, of parts that its file may leave out."""
    found: FurtherTopics = {}
    if machine.manipulator.pendulum is not None:
        found[topics.GROUND_TRUTH_HEAD] = lambda running: running.head_joints
    if has_loads or machine.manipulator.log is not None:
        found[topics.GROUND_TRUTH_LOAD] = lambda running: running.load
    if any(drive.elasticity is not None for drive in machine.drives):
        found[topics.GROUND_TRUTH_DEFLECTIONS] = lambda running: running.deflections
    if pump_drive(machine.pump).present:
        found[topics.GROUND_TRUTH_PUMP] = lambda running: running.pump
    if machine.tank_line is not None:
        found[topics.GROUND_TRUTH_TANK_LINE] = lambda running: running.tank_line
    if any(machine.valve_of(axis).compensator is not None for axis in range(3)):
        found[topics.GROUND_TRUTH_COMPENSATORS] = lambda running: running.compensators
    if machine.chassis is not None:
        found[topics.GROUND_TRUTH_TIP_OVER] = lambda running: running.tip_over
    return found


def _motion(motion: Motion) -> tuple[float, ...]:
    return (*motion.position, *motion.speed, *motion.effort)
