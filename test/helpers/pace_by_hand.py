"""Time and inboxes by hand, for what a node reads: no process, no middleware."""

from __future__ import annotations

from typing import Any, NamedTuple

from forest_msgs_py.serialization.cdr import to_cdr


class Arrival(NamedTuple):
    message: bytes
    time: float


class Box:
    """An inbox into which a test puts what arrives."""

    def __init__(self) -> None:
        self.arrival: Arrival | None = None

    def newest(self) -> Arrival | None:
        arrival, self.arrival = self.arrival, None
        return arrival


class Pace:
    """Time and inboxes by hand."""

    def __init__(self) -> None:
        self.boxes: dict[str, Box] = {}
        self.answered: set[str] = set()
        self.time = 0.0

    def inbox(self, topic: Any, answered: bool = False) -> Box:
        if answered:
            self.answered.add(topic.name)
        return self.boxes.setdefault(topic.name, Box())

    def now(self) -> float:
        return self.time

    def put(self, topic: Any, message: Any) -> None:
        self.boxes[topic.name].arrival = Arrival(to_cdr(message), self.time)
