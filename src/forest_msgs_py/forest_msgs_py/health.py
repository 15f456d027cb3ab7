"""What a node says about its inputs and its own state: a throttled warning, and a diagnostic on /diagnostics.

A node notes for each of its parts what is wrong with it, or "" when it is well. The first note of a sort of
trouble is logged, repetitions at most once a second; /diagnostics gets all parts when one of them changes
between well and unwell, and once a second. Its periods are counted in stamps, so that a run repeats.
"""

from __future__ import annotations

import re
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from forest_msgs_py import topics
from forest_msgs_py.messages import NS_PER_S, ns_to_stamp
from forest_msgs_py.node import publisher

WELL = "well"
LOG_PERIOD = 1.0  # [s]
DIGIT, MOST_SORTS = re.compile(r"\d"), 8  # of trouble, logged in a period
LONGEST = 400  # characters of what is wrong: somebody's message may hold a million numbers


class Health:
    """Keeps the notes of one node.

    Args:
        node: whose health it is.
        parts: what can fail, in the order in which it is told.
        consequence: what the node does about any trouble; begins every warning.
        said: publisher of /diagnostics, if the node has one of its own pace.
    """

    def __init__(self, node: Node, parts: tuple[str, ...], consequence: str, said: Any = None) -> None:
        self._node, self._consequence = node, consequence
        self._problems = dict.fromkeys(parts, "")
        self._logged: dict[tuple[str, str], float] = {}  # when, by part and sort of trouble
        self._publisher = publisher(node, topics.DIAGNOSTICS) if said is None else said
        self._changed, self._published = True, 0

    def note(self, part: str, problem: str) -> None:
        """Note what is wrong with a part, "" for nothing."""
        problem = problem if len(problem) <= LONGEST else f"{problem[:LONGEST]}..."
        if bool(problem) != bool(self._problems[part]):
            self._changed = True
        self._problems[part] = problem
        if problem and self._is_news(part, problem):
            self._node.get_logger().warning(f"{self._consequence}: {problem}")

    def _is_news(self, part: str, problem: str) -> bool:
        """Tell whether a trouble of this sort, its text up to the first number, was not logged just now."""
        now, sort = time.monotonic(), (part, DIGIT.split(problem, maxsplit=1)[0])
        self._logged = {key: when for key, when in self._logged.items() if now - when < LOG_PERIOD}
        if sort in self._logged or len(self._logged) >= MOST_SORTS:
            return False
        self._logged[sort] = now
        return True

    def publish(self, stamp_ns: int) -> None:
        """Tell, if there is news or the last time is a second ago."""
        if self._changed or abs(stamp_ns - self._published) >= NS_PER_S:
            self._changed, self._published = False, stamp_ns
            self._publisher.publish(self._message(stamp_ns))

    def _message(self, stamp_ns: int) -> Any:
        message = DiagnosticArray()
        message.header.stamp = ns_to_stamp(stamp_ns)
        name = self._node.get_fully_qualified_name().lstrip("/")
        for part, problem in self._problems.items():
            level = DiagnosticStatus.ERROR if problem else DiagnosticStatus.OK
            status = DiagnosticStatus(level=level, name=f"{name}: {part}", message=problem or WELL)
            status.hardware_id = name
            message.status.append(status)
        return message
