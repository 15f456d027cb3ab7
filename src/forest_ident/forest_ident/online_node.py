"""On-line identification as a node: running estimates of overlap, gain and damping beside the off-line fit.

It never publishes to the machine. It steps when the joints' state arrives, with the pressures and
voltages that arrived last, and publishes its estimates every second.
"""

import math
import sys
from functools import partial

from rclpy.node import Node

from forest_description.machine import load_machine
from forest_description.types import Vec3
from forest_ident.online import online_estimator
from forest_ident.online.online_parameters import OnlineParameters
from forest_msgs_py.clock.node_clock import node_clock
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.runtime import stamped_period
from forest_msgs_py.runtime.node import run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader

PORTS = tuple(tuple(f"{joint}_{port}_actuator" for joint in topics.JOINTS) for port in (1, 2))


class OnlineIdentificationNode(Node):
    """Shell around `online_estimator.step`."""

    def __init__(self) -> None:
        super().__init__("online_identification")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        machine = load_machine(declare(self, MachineParameter).machine)
        p = declare(self, OnlineParameters)
        self._core = online_estimator.parameters(machine, p.memory)
        self._state = online_estimator.initial(self._core)
        self._nominal, self._timeout, self._every = p.period, p.timeout, p.report_period
        self._period = stamped_period.BEGIN
        self._since = 0.0
        self._last: dict[Topic, tuple[bytes, float]] = {}  # message, when it was sent
        self._joints = JointReader(topics.JOINTS)
        self._ports = [ArrayReader(topics.PRESSURES, labels) for labels in PORTS]
        self._supply = ArrayReader(topics.SUPPLY, ("pressure",))
        self._voltages = ArrayReader(topics.VALVE_VOLTAGES)
        self._estimates = self._node_clock.publisher(topics.IDENTIFICATION)
        for topic in (topics.PRESSURES, topics.SUPPLY, topics.VALVE_VOLTAGES):
            self._node_clock.on(topic, partial(self._keep, topic))
        self._node_clock.on(topics.JOINT_STATES, self._on_joints)

    def _keep(self, topic: Topic, data: bytes, sent: float) -> None:
        self._last[topic] = data, sent

    def _on_joints(self, data: bytes, _sent: float) -> None:
        reading = self._joints.read(data)
        if reading.problem or not reading.values.velocity:
            return
        self._period, dt = stamped_period.clipped_period(self._period, reading.stamp_ns, self._nominal)
        sample = online_estimator.Sample(
            angles=reading.values.position,
            rates=reading.values.velocity,
            pressures_1=self._triple(topics.PRESSURES, self._ports[0]),
            pressures_2=self._triple(topics.PRESSURES, self._ports[1]),
            supply=self._read(topics.SUPPLY, self._supply, 1)[0],
            voltages=self._triple(topics.VALVE_VOLTAGES, self._voltages),
        )
        self._state = online_estimator.step(self._state, sample, self._core, dt)
        self._since += dt
        if self._since >= self._every:
            self._since = 0.0
            self._publish(reading.stamp_ns)

    def _triple(self, topic: Topic, reader: ArrayReader) -> Vec3:
        one, two, three = self._read(topic, reader, 3)
        return one, two, three

    def _read(self, topic: Topic, reader: ArrayReader, count: int) -> tuple[float, ...]:
        """Return a topic's newest values; NaN if they are bad, too old or never came."""
        nothing = (math.nan,) * count
        data, sent = self._last.get(topic, (b"", -math.inf))
        if not data or self._node_clock.now() - sent > self._timeout:
            return nothing
        reading = reader.read(data, 0)
        return nothing if reading.problem else tuple(reading.values)

    def _publish(self, stamp: int) -> None:
        values = zip(online_estimator.LABELS, online_estimator.report(self._state), strict=True)
        there = {label: value for label, value in values if math.isfinite(value)}
        message = float_array(topics.IDENTIFICATION, stamp, list(there.values()), labels=tuple(there))
        self._estimates.publish(message)


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(OnlineIdentificationNode))


if __name__ == "__main__":
    main()
