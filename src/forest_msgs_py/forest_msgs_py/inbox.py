"""A subscription that is read when its messages are needed, instead of waking the node for each of them.

rclpy's executor spends far longer on waking up for a message than on taking it. A node that steps on one
topic reads its other inputs here, at the moment of the step: the newest state of affairs, at a fraction of
the cost.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any, NamedTuple

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile

from forest_msgs_py.topics import Topic, message_class, qos


class Arrival(NamedTuple):
    """A message, and when it came [s, time.monotonic], however long it waited to be read."""

    message: Any
    time: float


class _NeverWoken(CallbackGroup):
    """Keeps its subscriptions out of the executor's wait set."""

    def can_execute(self, _entity: object) -> bool:
        return False

    def beginning_execution(self, _entity: object) -> bool:
        return False

    def ending_execution(self, _entity: object) -> None:
        pass


class Inbox:
    """Messages of one topic, waiting in the middleware's queue until they are taken.

    Args:
        node: that subscribes.
        message: class of the messages.
        name: of the topic, relative or absolute.
        profile: QoS; its depth is how many messages wait before the oldest is dropped.
        raw: take serialized bytes instead of messages.
    """

    def __init__(self, node: Node, message: Any, name: str, profile: QoSProfile, raw: bool = False) -> None:
        self.subscription = node.create_subscription(
            message, name, lambda _: None, profile, callback_group=_NeverWoken(), raw=raw
        )

    def take(self) -> Iterator[tuple[Any, dict[str, int]]]:
        """Yield all waiting messages, oldest first, each with the middleware's info about it."""
        handle, message, raw = self.subscription.handle, self.subscription.msg_type, self.subscription.raw
        with handle:
            while (taken := handle.take_message(message, raw)) is not None:
                yield taken

    def newest(self) -> Arrival | None:
        """Return the newest waiting message, or None; older ones are dropped."""
        newest = None
        for taken in self.take():
            newest = taken
        if newest is None:
            return None
        message, info = newest
        # The middleware's receive time is on the system's clock; clamped, because a clock may be set.
        age = max(0.0, (time.time_ns() - info["received_timestamp"]) * 1e-9)
        return Arrival(message, time.monotonic() - age)


def inbox(node: Node, topic: Topic) -> Inbox:
    """An inbox with the type and the QoS of the table."""
    return Inbox(node, message_class(topic), topic.name, qos(topic, reading=True))
