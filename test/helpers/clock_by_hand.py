"""Time and subscriptions by hand, for what a node reads: no process, no middleware."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from forest_msgs_py.serialization.cdr import to_cdr


class Arrival(NamedTuple):
    message: bytes
    time: float


class HandSubscription:
    """A subscription into which a test puts what arrives."""

    def __init__(self) -> None:
        self.arrival: Arrival | None = None
        self.heard: Any = None

    def newest(self) -> Arrival | None:
        arrival, self.arrival = self.arrival, None
        return arrival

    def arrivals(self) -> Iterator[Arrival]:
        if arrival := self.newest():
            yield arrival


class HandClock:
    """Time and subscriptions by hand."""

    def __init__(self) -> None:
        self.boxes: dict[str, HandSubscription] = {}
        self.answered: set[str] = set()
        self.time = 0.0

    def polled_subscription(self, topic: Any, answered: bool = False) -> HandSubscription:
        if answered:
            self.answered.add(topic.name)
        return self.boxes.setdefault(topic.name, HandSubscription())

    def now(self) -> float:
        return self.time

    def put(self, topic: Any, message: Any) -> None:
        self.boxes[topic.name].arrival = Arrival(to_cdr(message), self.time)
