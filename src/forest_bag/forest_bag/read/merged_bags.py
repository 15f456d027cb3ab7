"""Several bags as one: their topics together, their messages merged by log time."""

import heapq
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack
from operator import itemgetter
from pathlib import Path
from types import TracebackType

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.raw_messages import Channel, RawMessage


class MergedBags:
    """Open bags; a context manager. One bag is as good as several.

    Args:
        paths: directories or files.

    Raises:
        BagError: one is no bag, or a damaged one.
        OSError: one cannot be read.
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        self.path = ", ".join(map(str, paths))
        with ExitStack() as opened:
            self.readers = [opened.enter_context(BagReader(path)) for path in paths]
            self._opened = opened.pop_all()
        self.size = sum(reader.size for reader in self.readers)  # bytes

    def __enter__(self) -> "MergedBags":
        """Open already."""
        return self

    def __exit__(
        self, _type: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def close(self) -> None:
        """Let go of the files."""
        self._opened.close()

    @property
    def channels(self) -> dict[str, list[Channel]]:
        """What the bags say of each topic, by name."""
        found: dict[str, list[Channel]] = {}
        for reader in self.readers:
            for name, channels in reader.channels.items():
                known = found.setdefault(name, [])
                known += [channel for channel in channels if channel not in known]
        return dict(sorted(found.items()))

    @property
    def span(self) -> tuple[int, int]:
        """First and last log time, ns; (0, 0) for bags without messages."""
        spans = [span for reader in self.readers if (span := reader.span) != (0, 0)]
        return min((span[0] for span in spans), default=0), max((span[1] for span in spans), default=0)

    def messages(self, topics: Collection[str] | None = None, start_ns: int = 0) -> Iterator[RawMessage]:
        """Yield messages in the order of their log times; equal ones in the bags' order.

        Args:
            topics: only these; None: all.
            start_ns: only from this log time on.

        Raises:
            Damaged: bytes were changed.
        """
        return heapq.merge(*(reader.messages(topics, start_ns) for reader in self.readers), key=itemgetter(0))

    def check(self) -> None:
        """Look at all of them.

        Raises:
            Damaged: bytes were changed.
        """
        for reader in self.readers:
            reader.check()
