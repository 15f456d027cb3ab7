"""Self-diagnosis as a node: residuals, sensors and what they mean, on /diagnostics with what to do.

It never publishes to the machine. It steps when the joints' state arrives, with what has arrived last of
everything else; a topic that is silent is NaN.
"""

import sys
from collections import defaultdict
from collections.abc import Mapping
from typing import Any

from rclpy.node import Node

from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_ident.diagnosis import monitor, recorded_readings, residual_parameters
from forest_ident.diagnosis.findings import MACHINE, SENSORS, alarms, findings
from forest_ident.diagnosis.monitor_parameters import MonitorParameters
from forest_ident.diagnosis.residual_limits import LIMITS
from forest_ident.diagnosis.residuals import NAMES
from forest_ident.diagnosis.sequential_test import score
from forest_msgs_py.clock.node_clock import node_clock
from forest_msgs_py.clock.sampled_topics import SampledTopics, Wanted
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import JointValues
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.safety.diagnostics import Diagnostics

PARTS = (MACHINE, SENSORS, *AXES)  # on /diagnostics


class MonitorNode(Node):
    """Shell around `monitor.step`."""

    def __init__(self) -> None:
        super().__init__("monitor")
        clock = node_clock(self)
        self.run = clock.run
        machine = load_machine(declare(self, MachineParameter).machine)
        p = declare(self, MonitorParameters)
        self._core = monitor.Parameters(residual_parameters.parameters(machine), LIMITS)
        self._state = monitor.BEGIN
        said = clock.publisher(topics.DIAGNOSTICS)
        self._diagnostics = Diagnostics(self, PARTS, "the machine is watched on", said)
        self._diagnostics.watch(PARTS[0], values=self._values)
        timeouts = defaultdict(lambda: p.timeout, {topics.VALVE_DRIVER_STATUS: p.slow_timeout})
        others = [part for part in recorded_readings.PARTS if part[0] is not topics.JOINT_STATES]
        self._topics = SampledTopics(
            clock,
            {topic: Wanted(labels, timeouts[topic]) for topic, labels in others},
            step=self._step,
            period=p.period,
            report=self._tell,
            report_period=p.report_period,
        )

    def _step(self, joints: JointValues, dt: float) -> None:
        row: list[float] = []
        for topic, _ in recorded_readings.PARTS:
            row += joints.position if topic is topics.JOINT_STATES else self._topics.newest(topic)
        self._state = monitor.step(self._state, recorded_readings.readings_of(row), self._core, dt)

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
