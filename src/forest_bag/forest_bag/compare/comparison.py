"""What a comparison of two bags finds: topic by topic, signal by signal, the first place and the largest.

===============  ===========================================================================================
symbol           meaning
===============  ===========================================================================================
a, b             the two bags
stamp            header stamp, ns; where a message has none, its place in the order counts
pair             a message of each bag, of the same topic and stamp
difference       b - a, in the signal's unit
rms              sqrt(sum difference² / pairs); pairs of the same bytes differ by 0
===============  ===========================================================================================
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

Tolerance = Callable[[str, str], float]  # topic, label -> largest allowed difference


class Place(NamedTuple):
    """Where a topic differs first: ``message`` counts those of bag a from 0."""

    message: int
    stamp_ns: int
    what: str


@dataclass
class SignalDifference:
    """One signal of a topic."""

    label: str
    unit: str
    squares: float = 0.0
    largest: float = 0.0
    largest_ns: int = 0  # stamp of the largest

    def add(self, difference: float, stamp_ns: int) -> None:
        """Take in one pair's difference; a number beside none counts as infinite."""
        size = abs(difference) if not math.isnan(difference) else math.inf
        self.squares += size * size
        if size > self.largest:
            self.largest, self.largest_ns = size, stamp_ns


@dataclass
class TopicDifference:
    """All that differs between two bags in one topic."""

    topic: str
    type: str
    counts: list[int] = field(default_factory=lambda: [0, 0])
    alone: list[int] = field(default_factory=lambda: [0, 0])  # messages without a partner
    pairs: int = 0
    differing: int = 0  # pairs whose bytes differ
    log_times: int = 0  # pairs whose log times differ
    structure: int = 0  # pairs that differ in labels, texts, or in bytes that nobody can decode
    first: Place | None = None  # where content differs first
    first_log_time: Place | None = None  # where a log time does
    signals: dict[str, SignalDifference] = field(default_factory=dict)

    def note(self, index: int, stamp_ns: int, what: str) -> None:
        """Remember the first place."""
        if self.first is None:
            self.first = Place(index, stamp_ns, what)

    def rms(self, signal: SignalDifference) -> float:
        """RMS difference of one signal over all pairs."""
        return math.sqrt(signal.squares / self.pairs) if self.pairs else 0.0

    def strict(self, tolerance: Tolerance) -> bool:
        """Whether nothing is tolerated: then bytes and log times count."""
        return not (tolerance(self.topic, "") or any(tolerance(self.topic, label) for label in self.signals))

    def within(self, tolerance: Tolerance) -> bool:
        """Whether the topic is the same: to the last bit if nothing is tolerated, else in its numbers."""
        if self.structure or any(self.alone):
            return False
        if self.strict(tolerance):
            return not (self.differing or self.log_times)
        return all(s.largest <= tolerance(self.topic, label) for label, s in self.signals.items())

    def place(self, tolerance: Tolerance) -> Place | None:
        """Where the topic differs first; forgiven log times do not count."""
        places = [self.first, self.first_log_time if self.strict(tolerance) else None]
        return min(filter(None, places), key=lambda place: (place.stamp_ns, place.message), default=None)


class Comparison(NamedTuple):
    """What two bags have in common, and what not."""

    topics: dict[str, TopicDifference]
    alone: tuple[tuple[str, ...], tuple[str, ...]]  # topics of which only a, only b has messages
    ignored: tuple[str, ...]  # topics that were not compared
    origins: tuple[int, int] = (0, 0)  # stamps that count as time 0 in a and b, ns

    def same(self, tolerance: Tolerance) -> bool:
        """Whether nothing differs by more than is tolerated."""
        return not any(self.alone) and all(topic.within(tolerance) for topic in self.topics.values())

    def first(self, tolerance: Tolerance) -> tuple[str, Place] | None:
        """Return topic and place of what differs first, by stamp."""
        places = [(name, topic.place(tolerance)) for name, topic in self.topics.items()]
        found = [(name, place) for name, place in places if place is not None]
        return min(found, key=lambda named: named[1].stamp_ns, default=None)
