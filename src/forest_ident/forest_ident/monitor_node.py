"""Self-diagnosis as a node: residuals, sensors and what they mean, on /diagnostics with what to do.

It never publishes to the machine. It steps when the joints' state arrives, with what has arrived last of
everything else; a topic that is silent is NaN.
"""

import math
import sys
from collections.abc import Mapping
from functools import partial
from typing import Any

from rclpy.node import Node

from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_ident.diagnosis import machine_numbers, monitor, recorded
from forest_ident.diagnosis.findings import MACHINE, SENSORS, alarms, findings
from forest_ident.diagnosis.limits import LIMITS
from forest_ident.diagnosis.monitor_parameters import MonitorParameters
from forest_ident.diagnosis.residuals import NAMES
from forest_ident.diagnosis.sequential_test import score
from forest_msgs_py.clock.node_clock import node_clock
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.runtime import stamped_period
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.safety.diagnostics import Diagnostics
from forest_msgs_py.serialization.part_reader import PartReader
from forest_msgs_py.serialization.unpacking import JointReader

PARTS = (MACHINE, SENSORS, *AXES)  # on /diagnostics


class MonitorNode(Node):
    """Shell around `monitor.step`."""

    def __init__(self) -> None:
        super().__init__("monitor")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        machine = load_machine(declare(self, MachineParameter).machine)
        p = declare(self, MonitorParameters)
        self._core = monitor.Parameters(machine_numbers.parameters(machine), LIMITS)
        self._state, self._every, self._since = monitor.BEGIN, p.report_period, 0.0
        self._nominal, self._timeouts = p.period, (p.timeout, p.slow_timeout)
        self._period = stamped_period.BEGIN
        self._last: dict[Topic, tuple[bytes, float]] = {}  # message, when it was sent
        self._joints = JointReader(topics.JOINTS)
        others = [part for part in recorded.PARTS if part[0] is not topics.JOINT_STATES]
        self._readers = {topic: PartReader(topic, labels) for topic, labels in others}
        said = self._node_clock.publisher(topics.DIAGNOSTICS)
        self._diagnostics = Diagnostics(self, PARTS, "the machine is watched on", said)
        self._diagnostics.watch(PARTS[0], values=self._values)
        for topic in self._readers:
            self._node_clock.on(topic, partial(self._keep, topic))
        self._node_clock.on(topics.JOINT_STATES, self._on_joints)

    def _keep(self, topic: Topic, data: bytes, sent: float) -> None:
        self._last[topic] = data, sent

    def _on_joints(self, data: bytes, _sent: float) -> None:
        reading = self._joints.read(data)
        if reading.problem:
            return
        self._period, dt = stamped_period.clipped_period(self._period, reading.stamp_ns, self._nominal)
        row: list[float] = []
        for topic, labels in recorded.PARTS:
            row += self._newest(topic, labels) if topic in self._readers else reading.values.position
        self._state = monitor.step(self._state, recorded.readings_of(row), self._core, dt)
        self._since += dt
        if self._since >= self._every:
            self._since = 0.0
            self._tell(reading.stamp_ns)

    def _newest(self, topic: Topic, labels: tuple[str, ...]) -> tuple[float, ...]:
        """Return a topic's newest values; NaN of what is bad, too old or not there."""
        data, sent = self._last.get(topic, (b"", -math.inf))
        timeout = self._timeouts[1 if topic is topics.VALVE_DRIVER_STATUS else 0]
        if not data or self._node_clock.now() - sent > timeout:
            return (math.nan,) * len(labels)
        return self._readers[topic].read(data)

    def _tell(self, stamp: int) -> None:
        told: dict[str, list[str]] = {part: [] for part in PARTS}
        for one in findings(alarms(self._state, self._core)):
            told[one.part].append(str(one))
        for part, texts in told.items():
            self._diagnostics.warn(part, "; ".join(texts))
        self._diagnostics.publish(stamp)

    def _values(self) -> Mapping[str, Any]:
        """Return the scores of the residuals that have had values: an alarm from 1 on."""
        seen = zip(NAMES, self._state.tests, LIMITS, strict=True)
        return {name: score(test, of) for name, test, of in seen if test.seen > 0.0}


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(MonitorNode))


if __name__ == "__main__":
    main()
