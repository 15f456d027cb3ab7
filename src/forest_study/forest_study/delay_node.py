"""A bad link as a node: what it hears on `topic_in` it says on `topic_out`, later, jittered, or not at all.

Put it between any two nodes by renaming the topic of one of them, e.g. of the controller `-r joy:=joy_late`
with `topic_in:=joy topic_out:=joy_late`. Bytes pass unread, so stamps stay; the time of sending is new.
"""

import sys
import time

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node

from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import TOPICS, find, message_class
from forest_msgs_py.runtime.node import run_node, timer
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import ParameterError
from forest_study.closed_loop.link_model import DelayParameters, Link, Quality

PERIOD = 0.002  # [s] in which it looks what is due


class DelayNode(Node):
    """Shell around `Link`."""

    def __init__(self) -> None:
        super().__init__("delay")
        source, target, seed = declare(self, DelayParameters)
        self._link: Link[bytes] = Link(declare(self, Quality), seed)
        row = find(self.resolve_topic_name(source))
        if row is None:
            known = ", ".join(topic.name for topic in TOPICS)
            raise ParameterError(f"parameter 'topic_in' is {source!r}; allowed: one of {known}")
        if self.resolve_topic_name(target) == self.resolve_topic_name(source):
            raise ParameterError(f"parameter 'topic_out' is {target!r}; allowed: another than topic_in")
        silent = PublisherEventCallbacks(use_default_callbacks=False)
        kind = message_class(row)
        self._out = self.create_publisher(kind, target, qos(row), event_callbacks=silent)
        self.create_subscription(kind, source, self._on_message, qos(row), raw=True)
        timer(self, PERIOD, self._on_timer)

    def _on_message(self, data: bytes) -> None:
        self._link.send(time.monotonic(), data)

    def _on_timer(self) -> None:
        for data in self._link.arrived(time.monotonic()):
            self._out.publish(data)


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(DelayNode))


if __name__ == "__main__":
    main()
