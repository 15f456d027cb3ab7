"""What nodes say of themselves: /diagnostics, and the warnings and errors of /rosout."""

import re
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.node import Node

from forest_control.safety.motion_guard import LOST_STATE
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import subscription

WARNING = 30  # of rcl_interfaces/Log
LEVELS = {30: "warning", 40: "error", 50: "fatal"}
STALE = "stale"
STATES = {0: "ok", 1: "warning", 2: "error", 3: STALE}
STARTING = 10.0  # [s] from a part's first word, in which what is missing may still be on its way
MISSING = re.compile(rf"{LOST_STATE}$|waiting for (?!a joystick)")  # a joystick is a person's matter
SILENT = 3.0  # [s] without a word of a part, which our nodes tell of every second
GONE = "nothing has been heard of it for a while"
LONGEST = 400  # characters of a text that goes to the pages
MOST = 100  # parts that are told, and values of each: anybody may publish diagnostics


class PartStatus(NamedTuple):
    """How a part of a node is."""

    name: str
    level: str
    text: str
    values: dict[str, str]


def at_start(part: PartStatus, age: float) -> PartStatus:
    """Return a part as people are told of it, some time [s] after its first word.

    While a graph starts, what is missing is no trouble yet: nothing has failed, and there is nothing to mend.
    """
    if age >= STARTING or not MISSING.match(part.text):
        return part
    return part._replace(level="warning", text=f"the graph starts: {part.text}")


class Notices:
    """Keeps the newest status of each part, and hands on what is logged.

    Args:
        node: that listens.
        told: is called in the executor's thread with each part's status.
        logged: is called in the executor's thread with node, level and text.
    """

    def __init__(
        self, node: Node, told: Callable[[PartStatus], None], logged: Callable[[str, str, str], None]
    ) -> None:
        self.parts: dict[str, PartStatus] = {}
        self._begun: dict[str, float] = {}  # when each part was first told, since it was silent [s]
        self._heard: dict[str, float] = {}  # when each part was last told [s]
        self._told, self._logged = told, logged
        self._subscriptions = (
            subscription(node, topics.DIAGNOSTICS, self._hear_diagnostics),
            subscription(node, topics.ROSOUT, self._hear_log),
        )

    def _hear_diagnostics(self, message: Any) -> None:
        for status in message.status:
            level = status.level if isinstance(status.level, int) else int.from_bytes(status.level, "little")
            values = {pair.key[:LONGEST]: pair.value[:LONGEST] for pair in status.values[:MOST]}
            part = PartStatus(
                status.name[:LONGEST], STATES.get(level, STALE), status.message[:LONGEST], values
            )
            if part.name in self.parts or len(self.parts) < MOST:
                now = time.monotonic()
                if part.name not in self.parts or self.parts[part.name].level == STALE:
                    self._begun[part.name] = now
                self._heard[part.name] = now
                self._keep(at_start(part, now - self._begun[part.name]))

    def look(self, now: float) -> None:
        """Take parts that have fallen silent by a time [s] as stale."""
        for name, part in self.parts.items():
            if part.level != STALE and now - self._heard[name] > SILENT:
                self._keep(part._replace(level=STALE, text=GONE))

    def _keep(self, part: PartStatus) -> None:
        self.parts = {**self.parts, part.name: part}
        self._told(part)

    def _hear_log(self, message: Any) -> None:
        if message.level >= WARNING:
            self._logged(message.name, LEVELS.get(int(message.level), "error"), message.msg[:LONGEST])
