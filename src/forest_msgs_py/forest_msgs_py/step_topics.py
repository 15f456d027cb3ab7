"""What a node reads and says in lockstep, step by step; see :mod:`forest_msgs_py.lockstep`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from forest_msgs_py.cdr import to_cdr
from forest_msgs_py.inbox import Arrival, Inbox
from forest_msgs_py.messages import NS_PER_S
from forest_msgs_py.node import raw_publish
from forest_msgs_py.stamps import stamp_in
from forest_msgs_py.topics import Topic, message_class

STEP_NS = 5_000_000
DEPTH = 1000  # steps that a publisher keeps


def lockstep_qos() -> QoSProfile:
    """Reliable, deep, and for late readers, too: discovery takes as long as it takes."""
    return QoSProfile(
        depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )


def is_awaited(topic: Topic) -> bool:
    """Whether nodes may wait for a topic, by the table; what only a recorder reads shall wake nobody else."""
    return bool(topic.subscribers)


def silences(node: Node, topic: Topic) -> Inbox:
    """A subscription to what is not said."""
    return Inbox(node, message_class(topic), topic.name, lockstep_qos())


class StepInbox:
    """Messages of one topic, by the step to which they belong."""

    def __init__(self, node: Node, topic: Topic) -> None:
        self.topic = topic
        self._inbox = Inbox(node, message_class(topic), topic.name, lockstep_qos(), raw=True)
        self.subscription = self._inbox.subscription
        self.name = self.subscription.topic_name
        self._waiting: dict[int, bytes] = {}
        self._silent: set[int] = set()
        self._current: tuple[bytes, float] | None = None

    def collect(self, until: int = -1) -> None:
        """Take what has arrived, until the message of this stamp [ns] is among it."""
        for data, _info in self._inbox.take():
            stamp = stamp_in(self.topic.type, data)
            self._waiting.setdefault(stamp, data)
            if stamp == until:
                return

    def silent(self, stamp: int) -> None:
        """Nothing will be said in the step of this stamp."""
        self._silent.add(stamp)

    def has(self, stamp: int) -> bool:
        """Whether it is known what was said in the step of this stamp."""
        return stamp in self._waiting or stamp in self._silent

    def reached(self, stamp: int) -> bool:
        """Whether something was said in the step of this stamp or later; what was before is dropped."""
        latest = max(self._waiting, default=-1)
        self._waiting = {latest: b""}
        return latest >= stamp

    def turn_to(self, stamp: int) -> None:
        """Let the message of this step, if something was said, be the newest."""
        data = self._waiting.pop(stamp, None)
        self._silent.discard(stamp)
        if data is not None:
            self._current = data, stamp / NS_PER_S

    def newest(self) -> Arrival | None:
        """Return the message of this step, once; None if nothing was said."""
        if self._current is None:
            return None
        (data, sent), self._current = self._current, None
        return Arrival(data, sent)

    def arrivals(self) -> Iterator[Arrival]:
        """Yield the message of this step, once; nothing if nothing was said."""
        if arrival := self.newest():
            yield arrival


class StepPublisher:
    """A publisher that speaks once a step; the first word counts."""

    def __init__(self, node: Node, topic: Topic, step: Callable[[], int]) -> None:
        self._publisher = node.create_publisher(message_class(topic), topic.name, lockstep_qos())
        self.name, self.type, self.awaited = self._publisher.topic_name, topic.type, is_awaited(topic)
        self._say = raw_publish(self._publisher)
        self._step = step
        self.spoke = 0  # last step in which something was said

    def publish(self, message: Any) -> None:
        """Say a message, or its bytes. Between the steps, as a stopped node's last words, nothing is said."""
        step = self._step()
        if step == self.spoke or step == 0:
            return
        self.spoke = step
        self._say(message if isinstance(message, bytes) else to_cdr(message))

    def get_subscription_count(self) -> int:
        """Readers there are."""
        return int(self._publisher.get_subscription_count())
