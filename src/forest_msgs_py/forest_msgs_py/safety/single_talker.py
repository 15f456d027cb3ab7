"""The rule that one node alone commands: a second one stops the crane, and both are named until a reset."""

import time
from typing import Any

from rclpy.node import Node

from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.runtime.publishers import UNKNOWN, publishers_of
from forest_msgs_py.safety import talkers
from forest_msgs_py.safety.emergency_stop import EmergencyStop

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
        self._talkers, self._said, self._asked = talkers.NOBODY, "", -ASK_PERIOD
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
        now = time.monotonic()
        if not talkers.are_several(self._talkers, now):
            return ""
        if now - self._asked >= ASK_PERIOD:
            self._asked, found = now, set(publishers_of(self._node, self._topic))
            self._names |= found - {UNKNOWN}
            nameless = ("a node that was just found",) if UNKNOWN in found else ()
            named = ", ".join((*sorted(self._names), *nameless))
            self._said = f"more than one node publishes {self._topic.name}: {named}"
        return self._said

    def _hear(self, info: dict[str, int]) -> None:
        now = time.monotonic()
        self._talkers = talkers.heard(self._talkers, info.get("publication_sequence_number"), now)
        if talkers.are_several(self._talkers, now) and not self._stop.pressed:
            self._stop.press()
