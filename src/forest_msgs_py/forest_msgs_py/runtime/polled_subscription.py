"""A subscription that is read when its messages are needed, instead of waking the node for each of them.

rclpy's executor spends far longer on waking up for a message than on taking it. A node that steps on one
topic reads its other inputs here, at the moment of the step: the newest state of affairs, at a fraction of
the cost.
"""

import math
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from rclpy.callback_groups import CallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile

from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import Topic, message_class

CLOCK_TOLERANCE = 0.05  # [s] between the clocks of publisher and reader


class Arrival(NamedTuple):
    """A message, or its bytes, and when it was sent [s, time.monotonic], however long it waited since."""

    message: Any
    time: float


def sent_at(info: dict[str, int]) -> float:
    """Return when a message was sent, by this process' monotonic clock [s]; -inf if that cannot be told.

    A message may have waited in a queue, or this process may have been frozen: what counts is its age since
    it was published. Publisher and reader are on one machine, or on machines with synchronised clocks; a
    message from the future means that a clock was set, and is as good as old.
    """
    now = time.monotonic()  # read first: a stall between the two clocks makes the message older, not newer
    age = (time.time_ns() - info["source_timestamp"]) * 1e-9
    return now - age if age > -CLOCK_TOLERANCE else -math.inf


class _NotInWaitSet(CallbackGroup):
    """Keeps its subscriptions out of the executor's wait set: none of them ever begins or ends."""

    def can_execute(self, _entity: object) -> bool:
        return False


class ReceivedCount:
    """How many messages of a topic were taken, how old the newest is, and how long they were on their way."""

    subscription: Any = None  # that brings them
    heard: Callable[[dict[str, int]], None] | None = None  # is given the info about each message

    def __init__(self) -> None:
        self.count, self._sent_ns, self._way_ns = 0, 0, math.inf

    def note(self, info: dict[str, int]) -> None:
        """Count a message by the middleware's info about it."""
        self.count += 1
        self._sent_ns = info["source_timestamp"]
        self._way_ns = min(self._way_ns, info.get("received_timestamp", math.inf) - self._sent_ns)
        if self.heard is not None:
            self.heard(info)

    def age(self) -> float:
        """Return for how long the newest message has been sent [s]; inf if there is none."""
        return (time.time_ns() - self._sent_ns) * 1e-9 if self.count else math.inf

    def shortest_way(self) -> float:
        """Return how long the fastest message since the last call took, by both hosts' clocks [s]; inf: none.

        What waited in a queue of ours does not count. Less than nothing: the sender's clock is ahead.
        """
        shortest, self._way_ns = self._way_ns * 1e-9, math.inf
        return shortest


class PolledSubscription(ReceivedCount):
    """Messages of one topic, waiting in the middleware's queue until they are taken.

    Args:
        node: that subscribes.
        message: class of the messages.
        name: of the topic, relative or absolute.
        profile: QoS; its depth is how many messages wait before the oldest is dropped.
        raw: take serialized bytes instead of messages.
    """

    def __init__(self, node: Node, message: Any, name: str, profile: QoSProfile, raw: bool = False) -> None:
        super().__init__()
        self.subscription = node.create_subscription(
            message,
            name,
            lambda _: None,
            profile,
            callback_group=_NotInWaitSet(),
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),  # nobody would take them
            raw=raw,
        )

    def take(self) -> Iterator[tuple[Any, dict[str, int]]]:
        """Yield all waiting messages, oldest first, each with the middleware's info about it."""
        handle, message, raw = self.subscription.handle, self.subscription.msg_type, self.subscription.raw
        with handle:
            while (taken := handle.take_message(message, raw)) is not None:
                self.note(taken[1])
                yield taken

    def arrivals(self) -> Iterator[Arrival]:
        """Yield all waiting messages, oldest first, each with the time at which it was sent."""
        for message, info in self.take():
            yield Arrival(message, sent_at(info))

    def newest(self) -> Arrival | None:
        """Return the newest waiting message, or None; older ones are dropped."""
        newest = None
        for taken in self.take():
            newest = taken
        if newest is None:
            return None
        return Arrival(newest[0], sent_at(newest[1]))


def polled_subscription(node: Node, topic: Topic) -> PolledSubscription:
    """A polled subscription with the type and the QoS of the table, for the bytes of messages."""
    return PolledSubscription(node, message_class(topic), topic.name, qos(topic, reading=True), raw=True)
