"""The frame of a node that looks on: it steps with each joint state, and with what is newest of all else."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from forest_msgs_py.clock.lockstep import LockstepClock
from forest_msgs_py.clock.node_clock import LiveClock
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import JointValues
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.runtime import stamped_period
from forest_msgs_py.serialization.part_reader import PartReader
from forest_msgs_py.serialization.unpacking import JointReader


class Wanted(NamedTuple):
    """What is read of a topic, and the age at which that is lost."""

    labels: tuple[str, ...]
    timeout: float  # [s]


class SampledTopics:
    """Calls with each joint state, and tells the newest values of other topics.

    Args:
        clock: of the node.
        wanted: the other topics.
        step: called with each joint state and the time since the last one [s].
        period: nominal time between two joint states [s].
        report: called with a joint state's stamp [ns], after its step.
        report_period: least time between two reports, by the stamps [s].
    """

    def __init__(
        self,
        clock: LiveClock | LockstepClock,
        wanted: Mapping[Topic, Wanted],
        *,
        step: Callable[[JointValues, float], None],
        period: float,
        report: Callable[[int], None],
        report_period: float,
    ) -> None:
        self._clock, self._wanted = clock, wanted
        self._step, self._nominal = step, period
        self._report, self._every, self._since = report, report_period, 0.0
        self._period = stamped_period.BEGIN
        self._joints = JointReader(topics.JOINTS)
        self._readers = {topic: PartReader(topic, of.labels) for topic, of in wanted.items()}
        self._last: dict[Topic, tuple[bytes, float]] = {}  # message, when it was sent
        for topic in wanted:
            clock.on(topic, partial(self._keep, topic))
        clock.on(topics.JOINT_STATES, self._on_joints)

    def newest(self, topic: Topic) -> tuple[float, ...]:
        """Return a topic's newest values by the wanted labels; NaN of what is bad, too old or not there."""
        labels, timeout = self._wanted[topic]
        data, sent = self._last.get(topic, (b"", -math.inf))
        if not data or self._clock.now() - sent > timeout:
            return (math.nan,) * len(labels)
        return self._readers[topic].read(data)

    def _keep(self, topic: Topic, data: bytes, sent: float) -> None:
        self._last[topic] = data, sent

    def _on_joints(self, data: bytes, _sent: float) -> None:
        reading = self._joints.read(data)
        if reading.problem:
            return
        self._period, dt = stamped_period.clipped_period(self._period, reading.stamp_ns, self._nominal)
        self._step(reading.values, dt)
        self._since += dt
        if self._since >= self._every:
            self._since = 0.0
            self._report(reading.stamp_ns)
