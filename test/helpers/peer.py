"""The rest of the graph, as a node under test sees it."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from stall import Stall

from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import Topic, message_class


class Peer:
    """Says what others would say, keeps what it hears, and waits for conditions while it spins."""

    def __init__(self, context: Any, wait: Callable[..., None]) -> None:
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node

        self.node = Node("peer", context=context, enable_rosout=False, start_parameter_services=False)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self._wait = wait

    def hear(self, topic: Topic, name: str | None = None) -> list[Any]:
        """Return the list in which everything said on a topic will be found."""
        heard: list[Any] = []

        def hear(message: Any) -> None:
            # All that waits: at one message a turn a busy machine never comes to the newest.
            heard.append(message)
            with ear.handle:
                while (taken := ear.handle.take_message(ear.msg_type, False)) is not None:
                    heard.append(taken[0])

        ear = self.node.create_subscription(message_class(topic), name or topic.name, hear, qos(topic))
        return heard

    def speak(self, topic: Topic, name: str | None = None) -> Any:
        """Return a publisher that somebody listens to."""
        publisher = self.node.create_publisher(message_class(topic), name or topic.name, qos(topic))
        self.until(publisher.get_subscription_count)
        return publisher

    def repeat(self, topic: Topic, make: Callable[[int], Any], rate_hz: float = 100.0) -> Any:
        """Say what ``make(now [ns])`` returns at a rate, until the returned timer is cancelled."""
        publisher = self.speak(topic)

        def say() -> None:
            publisher.publish(make(self.node.get_clock().now().nanoseconds))

        return self.node.create_timer(1.0 / rate_hz, say)

    def until(self, predicate: Callable[[], Any]) -> float:
        """Spin until the predicate holds; return how long that took [s]."""
        begun = time.monotonic()
        self._wait(predicate, executor=self.executor)
        return time.monotonic() - begun

    def reaction(self, predicate: Callable[[], Any], process: Any) -> float:
        """Spin until the predicate holds; return how long that took a process and us on a machine of our own.

        The time for which a busy machine let us wait for a processor does not count [s].
        """
        stall = Stall(process.pid)
        elapsed = self.until(predicate)
        return elapsed - stall.seconds()

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
