"""A bag as the player needs it: read ahead by a thread, and what transient-local topics hold."""

import contextlib
import threading
from collections.abc import Collection, Iterator
from queue import Empty, Full, Queue

from forest_bag.read.merged_bags import MergedBags
from forest_bag.storage.raw_messages import RawMessage
from forest_msgs_py.interfaces.qos_profiles import Qos

BATCH = 100  # messages handed over at once, at most
BATCH_BYTES = 1 << 20  # from which a batch is handed over with fewer
AHEAD_BYTES = 16 << 20  # read ahead, before the last batch: four seconds of the demo's messages
OBJECT_BYTES = 500  # of a message beside its data
PATIENCE_S = 0.1
ARRIVAL_NS = 1_000_000_000  # of the bag's begin, in which a recorder hears what was published before it came


class BagSource:
    """The chosen topics of a bag."""

    def __init__(self, reader: MergedBags, profiles: dict[str, Qos]) -> None:
        """Read what transient-local topics hold.

        Args:
            reader: the open bags.
            profiles: topics to be played, with their QoS.

        Raises:
            Damaged: bytes of the bag were changed.
        """
        self._reader = reader
        self._topics = set(profiles)
        self._settled_ns = reader.span[0] + ARRIVAL_NS
        self._transient_local: dict[str, list[RawMessage]] = {
            name: [] for name, profile in profiles.items() if profile.transient_local
        }
        self._depths = {name: profiles[name].depth for name in self._transient_local}
        if self._transient_local:
            for message in reader.messages(self._transient_local.keys()):
                self._transient_local[message.channel.topic].append(message)

    def messages(self, start_ns: int) -> Iterator[RawMessage]:
        """Messages from a log time on, in order."""
        return read_ahead(self._reader.messages(self._topics, start_ns))

    def transient_local(self, position_ns: int, renew: bool) -> list[RawMessage]:
        """What transient-local topics held before a log time, as many messages as their publishers kept.

        Args:
            position_ns: log time.
            renew: a topic that held nothing yet gives its first message if that came with the bag's begin:
                its publisher had it before the recorder was there. A later one was news when it came.
        """
        held = []
        for name, messages in self._transient_local.items():
            before = _distinct([message for message in messages if message.log_ns < position_ns])
            known = [message for message in messages[:1] if renew and message.log_ns < self._settled_ns]
            held += before[-self._depths[name] :] or known
        return sorted(held, key=lambda message: message.log_ns)


def _distinct(messages: Collection[RawMessage]) -> list[RawMessage]:
    """The last of equal messages: a recorder writes a transient-local one into every split."""
    last = {message.data: message for message in messages}
    return sorted(last.values(), key=lambda message: message.log_ns)


class _Batches(Queue["list[RawMessage] | BaseException"]):
    """Batches that wait; the queue is as long as what they hold [bytes]."""

    def _init(self, maxsize: int) -> None:
        super()._init(maxsize)
        self._held = 0

    def _qsize(self) -> int:
        return self._held

    def _put(self, item: list[RawMessage] | BaseException) -> None:
        super()._put(item)
        self._held += _bytes(item)

    def _get(self) -> list[RawMessage] | BaseException:
        item: list[RawMessage] | BaseException = super()._get()
        self._held -= _bytes(item)
        return item


def _bytes(batch: list[RawMessage] | BaseException) -> int:
    """Return what a batch holds [bytes]; at least 1, or it would not be seen to wait."""
    return 1 + (0 if isinstance(batch, BaseException) else sum(map(_size, batch)))


def _size(message: RawMessage) -> int:
    return len(message.data) + OBJECT_BYTES


def _in_batches(messages: Iterator[RawMessage]) -> Iterator[list[RawMessage]]:
    """Yield the messages in batches, at last an empty one."""
    batch: list[RawMessage] = []
    held = 0
    for message in messages:
        batch.append(message)
        held += _size(message)
        if len(batch) == BATCH or held >= BATCH_BYTES:
            yield batch
            batch, held = [], 0
    if batch:
        yield batch
    yield []


def read_ahead(messages: Iterator[RawMessage]) -> Iterator[RawMessage]:
    """Yield messages that a thread has read beforehand: decompressing a chunk must delay none of them.

    At most `AHEAD_BYTES` and a batch are read ahead, whatever the size of a message.
    """
    batches = _Batches(AHEAD_BYTES)
    closed = threading.Event()

    def read() -> None:
        try:
            for batch in _in_batches(messages):
                if not _put(batches, batch, closed):
                    return
        except BaseException as error:  # noqa: BLE001  whatever it is, the reader of the batches gets it
            _put(batches, error, closed)

    thread = threading.Thread(target=read, name="read-ahead", daemon=True)
    thread.start()
    try:
        while batch := batches.get():
            if isinstance(batch, BaseException):
                raise batch
            yield from batch
    finally:
        closed.set()
        while thread.is_alive():
            with contextlib.suppress(Empty):
                batches.get_nowait()
            thread.join(PATIENCE_S if batches.empty() else 0.0)


def _put(
    batches: _Batches,
    batch: list[RawMessage] | BaseException,
    closed: threading.Event,
) -> bool:
    while not closed.is_set():
        try:
            batches.put(batch, timeout=PATIENCE_S)
        except Full:
            continue
        return True
    return False
