"""The machine as a node: takes /valve_voltages, keeps the graph's time, publishes what its sensors report.

Physics at 1 kHz inside, topics at 200 Hz, in a thread that sleeps from deadline to deadline: an executor
would spend more on waking up than the machine costs. Deadlines stand on the monotonic clock; a late wake-up
is caught up with correctly stamped samples, and counted. Voltages older than the machine's command timeout
count as zero.

Sensors are exact unless `sensor_noise` is set; `sensor_faults` hold either way. A sensor that is absent, or
drops its sample, is missing from its message; a message of which nothing is left is not sent. `stuck_spools`
and `tip_force` may be set while the node runs.
"""

import math
import sys
import threading
import time
from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node

from forest_description.derived.limits import pose_at, start_tip
from forest_description.geometry.kinematics import tip_orientation
from forest_description.machine import Machine, load_machine
from forest_description.types import ZERO, Vec3
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.clock.node_clock import pace, speaker
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter, ParameterError
from forest_msgs_py.runtime.stamp_order import StampOrder
from forest_msgs_py.safety.diagnostics import Health, beyond, rating_values
from forest_msgs_py.safety.input_status import InputStatus
from forest_msgs_py.serialization.unpacking import ArrayReader
from forest_sim.run.disturbance import Disturbance, checked_tip_force, parse_stuck_spools
from forest_sim.run.simulated_machine import SimulatedMachine
from forest_sim.run.simulator_parameters import SimulatorParameters
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_readings import Report
from forest_sim.sensors.sensor_suite import Suite, calibrated, sensor_suite
from forest_sim.sensors.signal_processing import Motion

FRAME = "base_link"
FRAMED = (topics.POSE, topics.TWIST)  # types
PERIOD_NS = 5_000_000
CATCH_UP = 20  # periods; what is later than that is left out rather than rushed through


class SimulatorNode(Node):
    """Shell around `SimulatedMachine`."""

    def __init__(self) -> None:
        super().__init__("simulator")
        self._pace = pace(self, leads=True)
        self.run = self._pace.run or self._keep_time
        machine = load_machine(declare(self, MachineParameter).machine)
        p = declare(self, SimulatorParameters, initial_tip=start_tip(machine))
        suite, angles = _sensor_suite(machine, p), _start_angles(machine, p.initial_tip)
        self._machine = SimulatedMachine(
            machine, angles, suite, PERIOD_NS * 1e-9, p.oil_warms, p.rig, p.noise_run
        )
        if not self._machine.is_compiled:
            self.get_logger().info(
                "the plant is interpreted; `python -m forest_sim.compiled` makes it fast, once"
            )
        self._changing = threading.Lock()  # parameters come in the executor's thread
        self._disturb(p)
        self._voltages, self._received = ZERO, -math.inf
        self._order = StampOrder(self._machine.machine.command_timeout)
        self._missed = 0
        self._speakers = {
            topic: speaker(self._pace, topic, FRAME if topic.type in FRAMED else "", p.plain_arrays)
            for topic in topics.TOPICS
            if "simulator" in topic.publishers and topic not in (topics.DIAGNOSTICS, topics.ROBOT_DESCRIPTION)
        }
        said = self._pace.publisher(topics.DIAGNOSTICS)
        self._health = Health(self, ("voltages", "machine"), "valves centred", said)
        self._description = self._pace.publisher(topics.ROBOT_DESCRIPTION)
        text = message_class(topics.ROBOT_DESCRIPTION)(data=robot_description(machine))
        self._description.publish(text)
        self._voltage_reader = ArrayReader(topics.VALVE_VOLTAGES)
        self._voltage_inbox = self._pace.inbox(topics.VALVE_VOLTAGES)
        self._watch_voltages(machine)
        self._stamp = self._pace.stamp()
        self._next = time.monotonic_ns() + PERIOD_NS
        if self._pace.lockstep:
            self._pace.every(0.0, self._make_step)

    def _disturb(self, p: SimulatorParameters) -> None:
        try:
            self._machine.disturb(_disturbance(p.stuck_spools, p.tip_force))
        except ValueError as error:
            raise ParameterError(f"parameter {error}") from error
        self.add_on_set_parameters_callback(self._on_parameters)

    def _on_parameters(self, changed: list[Any]) -> SetParametersResult:
        values = {name: self.get_parameter(name).value for name in ("stuck_spools", "tip_force")}
        values.update((parameter.name, parameter.value) for parameter in changed if parameter.name in values)
        try:
            disturbance = _disturbance(values["stuck_spools"], values["tip_force"])
            with self._changing:
                self._machine.disturb(disturbance)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=f"parameter {error}")
        return SetParametersResult(successful=True)

    def _watch_voltages(self, machine: Machine) -> None:
        """Have /diagnostics tell of the voltages, and of what goes on in the machine."""
        self._ratings, self._clipped = [machine.valve_of(axis).rated_voltage for axis in range(3)], 0
        heard = InputStatus(self, self._pace, self._voltage_inbox, "voltages", self._is_unattended)
        self._health.watch("voltages", heard, values=self._voltage_values)
        self._health.watch("machine", values=self._machine_values)

    def _voltage_values(self) -> dict[str, Any]:
        timeout = {"command_timeout [s]": self._machine.machine.command_timeout}
        return timeout | rating_values(self._ratings) | {"clipped since start": self._clipped}

    def _machine_values(self) -> dict[str, Any]:
        counts = self._machine.events._asdict() | {"missed_deadlines": self._missed}
        named = {f"{what.replace('_', ' ')} since start": count for what, count in counts.items()}
        return {"machine": self._machine.machine.name} | named

    def _is_unattended(self) -> bool:
        return self._pace.now() - self._received > self._machine.machine.command_timeout

    def _read_voltages(self) -> None:
        """Take the newest command; a bad one, and one that is too old, centres the valves."""
        arrival = self._voltage_inbox.newest()
        if arrival is not None:
            reading = self._voltage_reader.read(arrival.message, 0)
            problem = reading.problem
            if not problem and reading.values != ZERO:  # zero is obeyed in any order
                problem = self._order.problem("valve_voltages", reading.stamp_ns, arrival.time)
            self._health.note("voltages", problem)
            clipped = "" if problem else beyond(topics.VALVE_VOLTAGES, reading.values, self._ratings)
            self._health.warn("voltages", clipped)
            self._clipped += bool(clipped)
            self._voltages = ZERO if problem else reading.values
            self._received = arrival.time
        if self._is_unattended():
            self._voltages = ZERO
            self._health.warn("voltages", "")

    def _keep_time(self, stopping: threading.Event) -> None:
        """Keep the time, live, until the node stops."""
        while not stopping.is_set():
            time.sleep(max(0, self._next - time.monotonic_ns()) * 1e-9)
            self._catch_up()

    def _catch_up(self) -> None:
        due = max(0, (time.monotonic_ns() - self._next) // PERIOD_NS + 1)
        self._missed += max(0, due - 1)
        skipped = max(0, due - CATCH_UP)
        self._next += skipped * PERIOD_NS
        self._stamp += skipped * PERIOD_NS
        for _ in range(due - skipped):
            self._next += PERIOD_NS
            self._stamp += PERIOD_NS
            self._advance()

    def _make_step(self) -> None:
        """Move on by a period in lockstep: there are no deadlines to be missed."""
        self._stamp = self._pace.stamp()
        self._advance()

    def _advance(self) -> None:
        self._read_voltages()
        with self._changing:
            report = self._machine.step(self._voltages)
        self._publish(report)
        self._health.publish(self._stamp)  # last: nobody waits for it

    def _publish(self, report: Report) -> None:
        """Publish one sample; what the driver needs goes before what makes the controller step."""
        seen = report.seen
        auxiliary = (*seen.spools, seen.case_drain_flow, *seen.temperatures, seen.engine_speed, *seen.tilt)
        self._say(topics.PRESSURES, seen.pressures)
        self._say(topics.SUPPLY, (seen.supply_pressure, seen.supply_flow, seen.supply_saturation))
        self._say(topics.ACTUATOR_STATES, _flat(seen.actuators))
        self._say(topics.JOINT_STATES, _flat(seen.joints))  # last of what the controller reads: it steps then
        self._say(topics.FLOWS, seen.flows)
        self._say(topics.AUXILIARY, (*auxiliary, *map(float, self._machine.events), float(self._missed)))
        self._say(topics.GROUND_TRUTH_JOINT_STATES, _flat(report.joints))
        orientation = tip_orientation(report.joints.position)
        self._say(topics.GROUND_TRUTH_TIP_POSE, (*report.tip, *orientation))
        self._say(topics.GROUND_TRUTH_TIP_TWIST, report.tip_velocity)

    def _say(self, topic: topics.Topic, values: tuple[float, ...]) -> None:
        self._speakers[topic].say(self._stamp, values)


def _flat(motion: Motion) -> tuple[float, ...]:
    return *motion.position, *motion.speed, *motion.effort


def _sensor_suite(machine: Machine, p: SimulatorParameters) -> Suite:
    try:
        suite = sensor_suite(machine, p.sensor_noise, p.seed, parse_faults(p.sensor_faults))
    except ValueError as error:
        raise ParameterError(f"parameter 'sensor_faults': {error}") from error
    return suite if p.sensor_static_errors else calibrated(suite)


def _start_angles(machine: Machine, tip: Vec3) -> Vec3:
    try:
        return pose_at(tip, machine)
    except ValueError as error:
        raise ParameterError(f"parameter 'initial_tip' is {list(tip)}: {error}") from error


def _disturbance(stuck_spools: str, tip_force: Sequence[float]) -> Disturbance:
    try:
        stuck = parse_stuck_spools(stuck_spools)
    except ValueError as error:
        raise ValueError(f"'stuck_spools': {error}") from error
    try:
        return Disturbance(stuck, checked_tip_force(tip_force))
    except ValueError as error:
        raise ValueError(f"'tip_force' is {error}") from error


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(SimulatorNode))


if __name__ == "__main__":
    main()
