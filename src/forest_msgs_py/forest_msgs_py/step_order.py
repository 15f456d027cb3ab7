"""The messages of a lockstep run in an order that does not depend on when they arrived.

A step is complete when every node of the run has told its outputs (the roll), and each of them has been said,
or kept silent, in this step. Complete steps come out one after the other, their messages in the order of the
topic table. Latched topics on the roll are step 0. See :mod:`forest_msgs_py.lockstep`.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from functools import cache

from forest_msgs_py.topics import TOPICS, find

LATCHED = " latched"  # behind a topic's name and type on the roll


class StepOrder:
    """Sorts what arrives.

    Args:
        nodes: of the run, whose outputs are waited for.
        step_ns: time between two steps [ns].
    """

    def __init__(self, nodes: Sequence[str], step_ns: int) -> None:
        self._absent, self._step_ns = set(nodes), step_ns
        self.types: dict[str, str] = {}  # by topic on the roll
        self.latched: set[str] = set()
        self._speakers: Counter[str] = Counter()  # nodes that speak on a topic in every step
        self._messages: dict[int, list[tuple[str, bytes]]] = defaultdict(list)  # by stamp
        self._heard: dict[int, Counter[str]] = defaultdict(Counter)  # by stamp: words and silences
        self._next = 0  # stamp [ns]

    @property
    def reached(self) -> int:
        """Stamp of the last complete step [ns]; before the first, 0."""
        return max(0, self._next - self._step_ns)

    @property
    def is_begun(self) -> bool:
        """Whether every node has told its outputs."""
        return not self._absent

    def answer_the_roll(self, text: str) -> None:
        """Take in a node's name and its outputs, line by line: topic, type, and whether it is latched."""
        node, *outputs = text.split("\n")
        if node not in self._absent:
            return
        self._absent.remove(node)
        for output in outputs:
            name, type_name = output.removesuffix(LATCHED).split(" ")
            self.types[name] = type_name
            if output.endswith(LATCHED):
                self.latched.add(name)
            else:
                self._speakers[name] += 1

    def add(self, name: str, stamp: int, data: bytes) -> None:
        """Take in a message; of a latched topic, the stamp is 0 [ns]."""
        self._messages[stamp].append((name, data))
        self._heard[stamp][name] += 1

    def silence(self, names: Sequence[str], stamp: int) -> None:
        """Take in that nothing was said on these topics in the step of this stamp [ns]."""
        self._heard[stamp].update(names)

    def missing(self) -> str:
        """What the next step waits for, in words."""
        step = self._next // self._step_ns
        if self._absent:
            return f"step {step}: no outputs told by {', '.join(sorted(self._absent))}"
        wanted = Counter(self.latched) if self._next == 0 else self._speakers
        return f"step {step}: no message on {', '.join(sorted(wanted - self._heard[self._next]))}"

    def complete(self) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, stamp [ns] and bytes of the messages of every step that is complete by now."""
        while self._is_complete():
            self._heard.pop(self._next, None)
            for name, data in sorted(self._messages.pop(self._next, []), key=_place):
                yield name, self._next, data
            self._next += self._step_ns

    def _is_complete(self) -> bool:
        if self._absent:
            return False
        if self._next == 0:
            return self.latched <= self._heard[0].keys()
        return bool(self._speakers) and not self._speakers - self._heard[self._next]


@cache
def _row(name: str) -> int:
    """Where a topic stands in the table."""
    row = find(name)
    return len(TOPICS) if row is None else TOPICS.index(row)


def _place(message: tuple[str, bytes]) -> tuple[int, str, bytes]:
    """By the topic table; what is said twice on a topic, by its bytes."""
    return _row(message[0]), *message
