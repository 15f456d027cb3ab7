"""The messages that every file of a bag begins with: what a subscriber who comes late is told first."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

FOREVER_S = 1_000_000_000  # rosbag2 writes "no limit" as 9223372036 s, others as 2147483647 s
MANY = 100  # messages kept of a topic whose publishers are several: whose a message is, nobody says


class Sample(NamedTuple):
    """One message as it is recorded."""

    name: str
    data: bytes
    log_ns: int
    publish_ns: int
    sequence: int


def is_transient_local(qos: Sequence[Mapping[str, Any]]) -> bool:
    """Whether a publisher keeps its last messages for those who come late, for good (/rosout's expire)."""
    return any(
        profile["durability"] == "transient_local" and _lifespan(profile) in (0, FOREVER_S) for profile in qos
    )


def _lifespan(profile: Mapping[str, Any]) -> int:
    return min(int(profile["lifespan"]["sec"]), FOREVER_S)


class _LastMessages:
    """The last messages of one topic, each content once."""

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self._samples: dict[bytes, Sample] = {}

    def add(self, sample: Sample) -> None:
        self._samples.pop(sample.data, None)  # said again: now the last
        self._samples[sample.data] = sample
        if len(self._samples) > self.limit:
            del self._samples[next(iter(self._samples))]

    def __iter__(self) -> Iterator[Sample]:
        yield from self._samples.values()


class TransientLocal:
    """Keeps what the transient-local topics hold at present."""

    def __init__(self) -> None:
        self._kept: dict[str, _LastMessages] = {}

    def watch(self, name: str, qos: Sequence[Mapping[str, Any]]) -> None:
        """Learn what the publishers of a topic offer."""
        if is_transient_local(qos):
            depth = int(qos[0]["depth"]) if len(qos) == 1 else MANY  # 0: the middleware does not tell
            kept = self._kept.setdefault(name, _LastMessages(1))
            kept.limit = max(1, min(MANY, depth))

    def keep(self, sample: Sample) -> None:
        """Take in a message; forgotten at once if its topic is not transient local."""
        kept = self._kept.get(sample.name)
        if kept is not None:
            kept.add(sample)

    def __contains__(self, name: str) -> bool:
        return name in self._kept

    def __iter__(self) -> Iterator[Sample]:
        for kept in self._kept.values():
            yield from kept
