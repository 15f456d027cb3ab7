"""The numbers of all topics as one row: the newest message of each topic, read when a row is wanted.

A callback for each of 200 messages a second would cost more than the graph itself. So the
subscriptions wait in the middleware, and keep one message each.
"""

import math
from typing import Any, NamedTuple

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from forest_bag.read.flatten import FLATTENERS, Row
from forest_description.machine import Machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import JOINTS, TOPICS, Topic, message_class
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_station.scene.crane_signals import crane_signals
from forest_station.scene.greatest_rates import GreatestRates

FRESH = 0.5  # [s] for which a number counts, of a topic of 6 Hz and more
PERIODS = 3.0  # of a slower topic, for which its numbers count
NUMERIC = tuple(topic for topic in TOPICS if topic.type in FLATTENERS and topic != topics.CLOCK)
CRANE = Topic(
    name="crane",
    type="",
    labels=(),
    units=(),
    rate_hz=topics.SENSOR_RATE_HZ,
    doc="",
    publishers=(),
    subscribers=(),
)


class Signal(NamedTuple):
    """A number of a topic."""

    name: str  # TOPIC/LABEL
    unit: str


class Signals:
    """Every number of the table's topics, and the crane's joints that follow from the measured ones.

    Args:
        node: that subscribes.
        machine: whose cylinders are computed.
    """

    def __init__(self, node: Node, machine: Machine) -> None:
        self._machine, self._greatest_rates = machine, GreatestRates(machine)
        profile = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._polled = [
            (topic, PolledSubscription(node, message_class(topic), topic.name, profile, raw=True))
            for topic in NUMERIC
        ]
        self._names: dict[Topic, dict[str, str]] = {}  # unit of each label heard so far
        self._rows: dict[Topic, tuple[float, Row]] = {}  # newest of each topic, and when it was sent [s]
        self.told: tuple[Signal, ...] = ()

    def read(self) -> bool:
        """Take in what has come; tell whether there are signals that were not there before."""
        for topic, polled in self._polled:
            arrival = polled.newest()
            if arrival is not None:
                message: Any = deserialize_message(arrival.message, message_class(topic))
                self._note(topic, arrival.time, FLATTENERS[topic.type](topic, message))
        if topics.JOINT_STATES in self._rows:
            self._note(CRANE, *self._crane(*self._rows[topics.JOINT_STATES]))
        count = sum(map(len, self._names.values()))
        if count == len(self.told):
            return False
        order = [topic for topic in (*NUMERIC, CRANE) if topic in self._names]
        self.told = tuple(
            Signal(f"{topic.name}/{label}", unit)
            for topic in order
            for label, unit in self._names[topic].items()
        )
        return True

    def values(self, now: float) -> list[float]:
        """Return the value of each signal told at a time [s]; NaN where nothing fresh is known."""
        found: dict[str, float] = {}
        for topic, (sent, row) in self._rows.items():
            if now - sent <= max(FRESH, PERIODS / topic.rate_hz):
                found |= zip((f"{topic.name}/{label}" for label in row.labels), row.values, strict=True)
        return [found.get(signal.name, math.nan) for signal in self.told]

    def _note(self, topic: Topic, sent: float, row: Row) -> None:
        self._rows[topic] = sent, row
        known = self._names.setdefault(topic, {})
        for label, unit in zip(row.labels, row.units, strict=True):
            known.setdefault(label, unit)

    def _crane(self, sent: float, joints: Row) -> tuple[float, Row]:
        """Return all moving joints and the driven ones' greatest rates, computed from the measured ones."""
        told = dict(zip(joints.labels, joints.values, strict=True))
        angles = {axis: told.get(f"{axis}.position", math.nan) for axis in JOINTS}
        found = crane_signals(self._machine, angles) | self._greatest_rates.signals(told)
        labels = tuple(name.removeprefix(f"{CRANE.name}/") for name in found)
        units = tuple(map(_unit, labels))
        return sent, Row(joints.stamp_ns, labels, units, tuple(found.values()))


def _unit(label: str) -> str:
    return "m" if "_rod." in label else "rad/s" if label.endswith("_rate") else "rad"
