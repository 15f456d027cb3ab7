"""The messages of a lockstep run in an order that does not depend on when they arrived.

A step is complete when every node of the run has announced its outputs and sent its batch of the step.
Complete steps come out one after the other, their messages in the order of the topic table. Messages of
transient-local topics that are announced belong to step 0. See :mod:`forest_msgs_py.clock.lockstep`.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

from forest_msgs_py.interfaces.topics import TOPICS, find

TRANSIENT_LOCAL = " latched"  # behind a topic's name and type in an announcement


class BatchMessage(NamedTuple):
    """One message of a node's batch."""

    place: int  # of its topic on the node's announcement, transient-local ones left out
    step: int
    data: bytes


class StepOrder:
    """Sorts what arrives.

    Args:
        nodes: of the run, whose batches are waited for.
    """

    def __init__(self, nodes: Sequence[str]) -> None:
        self._absent = set(nodes)
        self._told = dict.fromkeys(nodes, 0)  # last step of the node's batch
        self.types: dict[str, str] = {}  # by topic announced
        self.transient_local: set[str] = set()
        self._outputs: dict[str, list[str]] = {}  # by node: topics, in the order of its announcement
        self._messages: dict[int, list[tuple[str, bytes]]] = defaultdict(list)  # by step
        # First messages of transient-local topics, one of each publisher; below zero: it came before
        # its node's announcement.
        self._awaited: Counter[str] = Counter()
        self._next = 0  # step
        self.lost = ""  # which batch, in words

    @property
    def reached(self) -> int:
        """The last complete step; before the first, 0."""
        return max(0, self._next - 1)

    @property
    def is_begun(self) -> bool:
        """Whether every node has told its outputs."""
        return not self._absent

    def add_announcement(self, text: str) -> None:
        """Take in a node's name and its outputs, a line each: topic, type, whether transient local."""
        node, *outputs = text.split("\n")
        if node not in self._absent:
            return
        self._absent.remove(node)
        self._outputs[node] = []
        for output in outputs:
            name, type_name = output.removesuffix(TRANSIENT_LOCAL).split(" ")
            self.types[name] = type_name
            if output.endswith(TRANSIENT_LOCAL):
                self.transient_local.add(name)
                self._awaited[name] += 1
            else:
                self._outputs[node].append(name)

    def add_transient_local(self, name: str, data: bytes) -> None:
        """Take in a message of a transient-local topic; in the middle of a run it counts in that step."""
        self._messages[self._next].append((name, data))
        self._awaited[name] -= 1

    def add_batch(self, node: str, since: int, until: int, said: Iterable[BatchMessage]) -> None:
        """Take in all that a node said after one step and up to another.

        A stranger's batch is none of the run's. Once a batch is lost, its node's steps are complete up
        to there and never again.
        """
        if node not in self._outputs:
            return
        if since > self._told[node]:
            self.lost = (
                self.lost or f"the account of {node} of steps {self._told[node] + 1} to {since} was lost"
            )
            return
        names = self._outputs[node]
        for place, step, data in said:
            self._messages[step].append((names[place], data))
        self._told[node] = max(self._told[node], until)

    def missing(self) -> str:
        """What the next step waits for, in words."""
        if self._absent:
            return f"step {self._next}: no outputs told by {', '.join(sorted(self._absent))}"
        if self._next == 0:
            return f"step 0: no message on {', '.join(sorted(self._transient_local_missing()))}"
        return f"step {self._next}: no account of {', '.join(sorted(self._behind()))}"

    def complete(self) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, step and bytes of the messages of every step that is complete by now."""
        if self._absent or self._transient_local_missing():
            return
        for step in range(self._next, min(self._told.values()) + 1):
            for name, data in sorted(self._messages.pop(step, []), key=_place):
                yield name, step, data
            self._next = step + 1

    def _transient_local_missing(self) -> list[str]:
        return [name for name, count in self._awaited.items() if count > 0]

    def _behind(self) -> list[str]:
        return [node for node, told in self._told.items() if told < self._next]


@cache
def _row(name: str) -> int:
    """Where a topic stands in the table."""
    row = find(name)
    return len(TOPICS) if row is None else TOPICS.index(row)


def _place(message: tuple[str, bytes]) -> tuple[int, str, bytes]:
    """By the topic table; what is said twice on a topic, by its bytes."""
    return _row(message[0]), *message
