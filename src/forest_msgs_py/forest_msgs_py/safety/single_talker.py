"""The rule that one node alone commands: a second one stops the crane, and both are named until a reset."""

import time
from typing import Any

from rclpy.node import Node

from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.runtime.publishers import UNKNOWN, publishers_of
from forest_msgs_py.safety.emergency_stop import EmergencyStop
from forest_msgs_py.safety.talkers import Publishers

PRESSED = "emergency stop pressed"
ASK_PERIOD = 0.2  # [s] between two questions for names: a node's name is found later than its messages


class SingleTalker:
    """Presses a node's emergency stop when two talk on a topic.

    Args:
        node: that subscribes.
        topic: on which one node alone may talk.
        received: what counts its messages.
        stop: the node's emergency stop; it refuses a reset as long as two talk.
    """

    def __init__(self, node: Node, topic: Topic, received: Any, stop: EmergencyStop) -> None:
        self._node, self._topic, self._stop = node, topic, stop
        self._publishers, self._said, self._asked = Publishers(), "", -ASK_PERIOD
        self._names: set[str] = set()  # of all that were there since it was found: a rival may have gone
        received.heard = self._hear
        stop.refuse_while(self._objection)

    def trouble(self) -> str:
        """Return what is wrong while the stop is pressed, with the names of who caused it; else ""."""
        if not self._stop.pressed:
            self._said, self._names = "", set()
            return ""
        self._objection()
        return "; ".join(filter(None, (PRESSED, self._said)))

    def _objection(self) -> str:
        """Return who talks beside whom, as long as they do; "" where one talks alone."""
        if not self._publishers.are_several():
            return ""
        now = time.monotonic()
        if now - self._asked >= ASK_PERIOD:
            self._asked, found = now, set(publishers_of(self._node, self._topic))
            self._names |= found - {UNKNOWN}
            nameless = ("a node that was just found",) if UNKNOWN in found else ()
            named = ", ".join((*sorted(self._names), *nameless))
            self._said = f"more than one node publishes {self._topic.name}: {named}"
        return self._said

    def _hear(self, info: dict[str, int]) -> None:
        self._publishers.hear(info)
        if self._publishers.are_several() and not self._stop.pressed:
            self._stop.press()
