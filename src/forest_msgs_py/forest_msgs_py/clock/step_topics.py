"""What a node reads and publishes in lockstep, step by step; see :mod:`forest_msgs_py.clock.lockstep`."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from forest_msgs_py.interfaces.messages import ns_to_stamp, stamp_to_ns
from forest_msgs_py.interfaces.stamps import stamp_in
from forest_msgs_py.interfaces.topics import IDLE, NO_OUTPUT, Topic, message_class
from forest_msgs_py.runtime.node import raw_publish
from forest_msgs_py.runtime.polled_subscription import Arrival, PolledSubscription
from forest_msgs_py.serialization.cdr import to_cdr
from forest_msgs_py.types import NS_PER_S, PERIOD_NS

DEPTH = 1000  # steps that a publisher keeps
LATE = 40  # steps: until then it is known, too, on which topics of `IdleReport` nothing was said
LIVE = " (live)"  # behind the name of a node that no lockstep has, in the table
SPAN = "@"  # between a topic's name and the steps in which it has no output; in no name


def lockstep_qos(depth: int = DEPTH) -> QoSProfile:
    """Reliable, deep, and for late readers, too: discovery takes as long as it takes."""
    return QoSProfile(
        depth=depth, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )


def is_awaited(topic: Topic) -> bool:
    """Whether nodes may wait for a topic, by the table; what only a recorder reads shall wake nobody else."""
    return any(not name.endswith(LIVE) for name in topic.subscribers) and not topic.late


def no_output_subscription(node: Node, topic: Topic) -> PolledSubscription:
    """A subscription to the messages that name topics without output."""
    return PolledSubscription(node, message_class(topic), topic.name, lockstep_qos())


def steps_without_output(header: Any) -> Iterator[tuple[str, int]]:
    """Topics and stamps [ns] of which a message on lockstep/silence or lockstep/quiet tells."""
    for told in header.frame_id.split(" "):
        name, _, span = told.partition(SPAN)
        if not span:
            yield name, stamp_to_ns(header.stamp)
            continue
        first, last = span.split("-")
        for step in range(int(first), int(last) + 1):
            yield name, step * PERIOD_NS


class IdleReport:
    """Reports steps without output of topics that no node waits for, many at once.

    Only a node that reads them late needs the report. Most of these topics have no output in most steps, and
    a message costs as much as those that matter.

    Args:
        node: that publishes.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(message_class(IDLE), IDLE.name, lockstep_qos())
        self._spans: list[list[Any]] = []  # name, first and last step

    def note(self, step: int, names: Sequence[str]) -> None:
        """Note on which topics nothing was published in a step."""
        for name in names:
            span = next((span for span in self._spans if span[0] == name and span[2] == step - 1), None)
            if span is None:
                self._spans.append([name, step, step])
            else:
                span[2] = step

    def tell(self, step: int) -> None:
        """Publish what was noted since the last report."""
        if self._spans:
            text = " ".join(f"{name}{SPAN}{first}-{last}" for name, first, last in self._spans)
            self._spans.clear()
            self._publisher.publish(no_output(text, step))


def no_output(text: str, step: int) -> bytes:
    """A message on lockstep/silence or lockstep/quiet."""
    header = message_class(NO_OUTPUT)(frame_id=text)
    header.stamp = ns_to_stamp(step * PERIOD_NS)
    return to_cdr(header)


class StepSubscription:
    """Messages of one topic, by the step to which they belong.

    Args:
        node: that reads.
        topic: row of the table.
        lag: steps after which a message counts: who is answered cannot wait for the answer in its own step.
    """

    def __init__(self, node: Node, topic: Topic, lag: int = 0) -> None:
        self.topic, self._lag_ns = topic, lag * PERIOD_NS
        self._polled = PolledSubscription(node, message_class(topic), topic.name, lockstep_qos(), raw=True)
        self.subscription = self._polled.subscription
        self.name = self.subscription.topic_name
        self._waiting: dict[int, bytes] = {}
        self._without_output: set[int] = set()
        self._current: tuple[bytes, float] | None = None
        self.count, self._step_ns, self._said_ns = 0, 0, 0

    def collect(self, until: int = -1) -> None:
        """Take what has arrived, until it is known what counts in the step of this stamp [ns]."""
        if until > 0 and self.has(until):
            return
        for data, _info in self._polled.take():
            stamp = stamp_in(self.topic.type, data)
            self._waiting.setdefault(stamp, data)
            if stamp == until - self._lag_ns:
                return

    def without_output(self, stamp: int) -> None:
        """Note that nothing will be published in the step of this stamp."""
        self._without_output.add(stamp)

    def has(self, stamp: int) -> bool:
        """Whether it is known what counts in the step of this stamp."""
        said = stamp - self._lag_ns
        return said in self._waiting or said in self._without_output or (self._lag_ns > 0 and said <= 0)

    def reached(self, stamp: int) -> bool:
        """Whether something was said in the step of this stamp or later; what was before is dropped."""
        latest = max(self._waiting, default=-1)
        self._waiting = {latest: b""}
        return latest >= stamp

    def turn_to(self, stamp: int) -> None:
        """Let the message that counts in this step, if there is one, be the newest."""
        said = stamp - self._lag_ns
        data = self._waiting.pop(said, None)
        self._without_output.discard(said)
        self._step_ns = stamp
        if data is not None:
            self._current = data, said / NS_PER_S
            self.count, self._said_ns = self.count + 1, said

    def age(self) -> float:
        """Return for how long the newest message has been said, in simulated time [s]; inf: there is none."""
        return (self._step_ns - self._said_ns) / NS_PER_S if self.count else math.inf

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
    """A publisher of one message a step; the first counts.

    Messages that no node waits for are kept until `tell`: one after the other, messages cost less.

    Args:
        node: that publishes.
        topic: row of the table.
        step: the step that is being made; 0 between the steps.
        note: is given the step and the bytes of all that is published.
    """

    def __init__(
        self, node: Node, topic: Topic, step: Callable[[], int], note: Callable[[int, bytes], None]
    ) -> None:
        self._publisher = node.create_publisher(message_class(topic), topic.name, lockstep_qos())
        self.name, self.type, self.awaited = self._publisher.topic_name, topic.type, is_awaited(topic)
        self._say = raw_publish(self._publisher)
        self._step, self._note = step, note
        self._kept: list[bytes] = []
        self.published_step = 0  # last step in which something was published

    def publish(self, message: Any) -> None:
        """Publish a message, or its bytes; nothing between the steps, as when a stopped node ends."""
        step = self._step()
        if step == self.published_step or step == 0:
            return
        self.published_step = step
        data = message if isinstance(message, bytes) else to_cdr(message)
        if self.awaited:
            self._say(data)
        else:
            self._kept.append(data)
        self._note(step, data)

    def tell(self) -> None:
        """Publish what was kept."""
        for data in self._kept:
            self._say(data)
        self._kept.clear()

    def get_subscription_count(self) -> int:
        """Readers there are."""
        return int(self._publisher.get_subscription_count())
