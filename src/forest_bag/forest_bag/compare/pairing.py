"""Two bags as two streams side by side: messages of the same topic and stamp make a pair and are compared.

Only what still waits for its partner is in memory. Messages are decoded only where bytes differ; of a type
that is neither installed nor defined in the bag, bytes are all that counts.

Not compared: publish times and sequence numbers, which belong to the middleware, `WALL_CLOCK_TOPICS`, and
`WALL_CLOCK_COLUMNS` where nothing else of a message differs.
"""

import contextlib
import math
from collections import deque
from collections.abc import Callable, Collection, Iterator
from functools import cached_property
from typing import Any

from forest_bag.compare.comparison import Comparison, Place, SignalDifference, TopicDifference
from forest_bag.read.bag_reader import BagReader
from forest_bag.read.flatten import Row, texts
from forest_bag.read.timeseries import message_reader
from forest_bag.storage.raw_messages import Channel, RawMessage
from forest_msgs_py.interfaces.topics import AUXILIARY, find
from forest_msgs_py.serialization.cdr import CdrError
from forest_msgs_py.types import NS_PER_S

WALL_CLOCK_TOPICS = ("/rosout", "/parameter_events")  # stamped by the system's clock in any run
WALL_CLOCK_COLUMNS = {AUXILIARY.name: frozenset(("missed_deadlines",))}


def compare(
    a: BagReader, b: BagReader, ignore: Collection[str] = (), only: Collection[str] | None = None
) -> Comparison:
    """Compare two bags on their stamps.

    Args:
        a: one bag.
        b: the other.
        ignore: topics to leave out beside those of the wall clock.
        only: topics to compare; None: all.

    Raises:
        Damaged: bytes of a bag were changed.
    """
    topics, alone, ignored = common_topics(a, b, ignore, only)
    pairings = {name: _Pairing(result, a.channels[name][0]) for name, result in topics.items()}
    streams = [reader.messages(pairings.keys()) for reader in (a, b)]
    for side, message in _by_turns(streams):
        pairings[message.channel.topic].add(side, message)
    found = {name: pairing.finish() for name, pairing in pairings.items()}
    start = min(a.span[0], b.span[0])
    return Comparison(found, alone, ignored, (start, start))


def common_topics(
    a: BagReader, b: BagReader, ignore: Collection[str], only: Collection[str] | None
) -> tuple[dict[str, TopicDifference], tuple[tuple[str, ...], tuple[str, ...]], tuple[str, ...]]:
    """What both bags have; what one of them has; what is left out."""
    kinds = [
        {name: channels[0].type for name, channels in reader.channels.items() if only is None or name in only}
        for reader in (a, b)
    ]
    left_out = kinds[0].keys() | kinds[1].keys()
    left_out &= {*WALL_CLOCK_TOPICS, *ignore} - set(only or ())
    names = [kind.keys() - left_out for kind in kinds]
    both = {name: TopicDifference(name, kinds[0][name]) for name in sorted(names[0] & names[1])}
    for name, found in both.items():
        if (other := kinds[1][name]) != found.type:
            found.structure += 1
            found.note(0, 0, f"type {found.type or 'unknown'} and {other or 'unknown'}")
    alone = _with_messages(a, names[0] - names[1]), _with_messages(b, names[1] - names[0])
    return both, alone, tuple(sorted(left_out))


def _with_messages(reader: BagReader, names: Collection[str]) -> tuple[str, ...]:
    """Topics of which there are messages: one that was only announced says nothing."""
    return tuple(sorted(name for name in names if next(reader.messages({name}), None) is not None))


def _by_turns(streams: list[Iterator[RawMessage]]) -> Iterator[tuple[int, RawMessage]]:
    """Messages of both, one of each by turns, so that little waits for its partner."""
    running = dict(enumerate(streams))
    while running:
        for side in list(running):
            message = next(running[side], None)
            if message is None:
                del running[side]
            else:
                yield side, message


class _Waiting:
    """A message that waits for its partner; decoded when somebody looks into it, and once."""

    def __init__(self, raw: RawMessage, read: Callable[[bytes], tuple[Row, Any]] | None) -> None:
        self.raw, self._read = raw, read

    @cached_property
    def decoded(self) -> tuple[Row, Any] | None:
        """The numbers, and the whole message; None: its type is not installed, or its bytes are not of it."""
        with contextlib.suppress(CdrError):
            return None if self._read is None else self._read(self.raw.data)
        return None

    @property
    def stamp_ns(self) -> int | None:
        """Header stamp; None if it has none."""
        return None if self.decoded is None else self.decoded[0].stamp_ns

    @property
    def place_ns(self) -> int:
        """Header stamp, or the log time."""
        return self.raw.log_ns if self.stamp_ns is None else self.stamp_ns


class _Pairing:
    """One topic: messages of both bags find their partners."""

    def __init__(self, result: TopicDifference, channel: Channel) -> None:
        self._result = result
        self._waiting: tuple[deque[_Waiting], deque[_Waiting]] = (deque(), deque())
        self._taken = [0, 0]
        self._read: Callable[[bytes], tuple[Row, Any]] | None = None
        row = find(result.topic)
        self._wall_clock = WALL_CLOCK_COLUMNS.get(row.name, frozenset()) if row else frozenset()
        if not result.structure:  # of one type; if nobody knows it, bytes are compared
            with contextlib.suppress(ValueError):
                self._read = message_reader(channel)

    def add(self, side: int, message: RawMessage) -> None:
        """Take in a message of bag a (side 0) or b (side 1)."""
        self._result.counts[side] += 1
        self._waiting[side].append(_Waiting(message, self._read))
        while all(self._waiting):
            self._match(self._waiting[0][0], self._waiting[1][0])

    def finish(self) -> TopicDifference:
        """What still waits has no partner."""
        for side in (0, 1):
            while self._waiting[side]:
                self._leave_alone(side)
        return self._result

    def _match(self, a: _Waiting, b: _Waiting) -> None:
        if a.raw.data == b.raw.data and a.raw.log_ns == b.raw.log_ns:
            self._pair()
        elif a.stamp_ns is None or b.stamp_ns is None or a.stamp_ns == b.stamp_ns:
            self._judge(a, b)
            self._pair()
        else:
            self._leave_alone(0 if a.stamp_ns < b.stamp_ns else 1)

    def _pair(self) -> None:
        self._result.pairs += 1
        for side in (0, 1):
            self._waiting[side].popleft()
            self._taken[side] += 1

    def _leave_alone(self, side: int) -> None:
        message = self._waiting[side].popleft()
        self._result.alone[side] += 1
        self._result.note(self._taken[0], message.place_ns, f"a message that is only in {'AB'[side]}")
        self._taken[side] += 1

    def _judge(self, a: _Waiting, b: _Waiting) -> None:
        """Compare a pair that is not the same."""
        result, index, stamp = self._result, self._taken[0], a.place_ns
        if a.raw.data != b.raw.data:
            what = self._difference(a, b, stamp)
            if what:
                result.differing += 1
                result.note(index, stamp, what)
        if a.raw.log_ns != b.raw.log_ns:
            result.log_times += 1
            if result.first_log_time is None:
                told = f"log time {_seconds(a.raw.log_ns)} and {_seconds(b.raw.log_ns)}"
                result.first_log_time = Place(index, stamp, told)

    def _difference(self, a: _Waiting, b: _Waiting, stamp: int) -> str:
        """Say what differs between two messages of different bytes; "" if only wall-clock measurements."""
        result = self._result
        if a.decoded is None or b.decoded is None:
            result.structure += 1
            return _first_byte(a.raw.data, b.raw.data)
        (row_a, whole_a), (row_b, whole_b) = a.decoded, b.decoded
        found = texts(whole_a), texts(whole_b)
        if row_a.labels != row_b.labels or found[0] != found[1]:
            result.structure += 1
            return _structure(row_a, row_b, *found)
        changed = []
        for label, unit, x, y in zip(row_a.labels, row_a.units, row_a.values, row_b.values, strict=True):
            signal = result.signals.setdefault(label, SignalDifference(label, unit))
            if x == y or (math.isnan(x) and math.isnan(y)):
                continue
            if label in self._wall_clock:
                changed.append("")
                continue
            signal.add(y - x, stamp)
            changed.append(f"{label} {x:.9g} and {y:.9g} {unit}".rstrip())
        return next(filter(None, changed), "" if changed else "the same values in other bytes")


def _first_byte(a: bytes, b: bytes) -> str:
    place = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
    return f"bytes, from byte {place} on ({len(a)} and {len(b)} bytes)"


def _structure(row_a: Row, row_b: Row, texts_a: dict[str, Any], texts_b: dict[str, Any]) -> str:
    if row_a.labels != row_b.labels:
        missing = [name for name in row_a.labels if name not in row_b.labels]
        added = [name for name in row_b.labels if name not in row_a.labels]
        told = [f"{', '.join(names)} only in {bag}" for names, bag in ((missing, "A"), (added, "B")) if names]
        return "; ".join(told) or "the labels in another order"
    path = next(path for path in texts_a | texts_b if texts_a.get(path) != texts_b.get(path))
    return f"{path} {str(texts_a.get(path))[:40]!r} and {str(texts_b.get(path))[:40]!r}"


def _seconds(time_ns: int) -> str:
    return f"{time_ns // NS_PER_S}.{time_ns % NS_PER_S:09d} s"
