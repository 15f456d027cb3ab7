"""A bag as time series: counts per topic, and each topic's values as arrays with stamps, labels and units.

============  ==============================================================================================
symbol        meaning
============  ==============================================================================================
time_ns       header stamp, ROS time, int64 [N]; where a message has none, its log time
log_time_ns   when the recorder received it, system time, int64 [N]
values        float64 [N, k], one column per label
============  ==============================================================================================

The file is read as a stream, front to back, so that a bag whose recorder was killed (no footer, no index, no
``metadata.yaml``) gives every finished chunk.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from mcap.exceptions import McapError
from mcap.records import Channel, Footer, Message, Schema
from mcap.stream_reader import StreamReader
from numpy.typing import NDArray

from forest_msgs_py.rows import NS_PER_S, TAKERS
from forest_msgs_py.sequences import SequenceGaps
from forest_msgs_py.topics import Topic, find, message_class, unlisted


class NotInBag(LookupError):
    """A topic or a column that the bag does not hold; the text names what there is."""


@dataclass(frozen=True)
class TopicInfo:
    """What a bag holds of one topic; ``lost`` counts gaps in the publishers' sequence numbers."""

    type: str
    count: int
    first_ns: int
    last_ns: int
    lost: int

    @property
    def rate_hz(self) -> float:
        """Mean rate between the first and the last message, by log time; 0 for fewer than two."""
        span = self.last_ns - self.first_ns
        return (self.count - 1) * NS_PER_S / span if span > 0 else 0.0


class Series(NamedTuple):
    """One topic over time; NaN where a message lacks a column, as ``incomplete`` of them do."""

    time_ns: NDArray[np.int64]
    log_time_ns: NDArray[np.int64]
    values: NDArray[np.float64]
    labels: tuple[str, ...]
    units: tuple[str, ...]
    incomplete: int

    def column(self, label: str) -> NDArray[np.float64]:
        """The values of one label, [N].

        Raises:
            NotInBag: no such label; the text names those there are.
        """
        if label not in self.labels:
            raise NotInBag(f"no column '{label}'; there are {', '.join(self.labels)}")
        return self.values[:, self.labels.index(label)]


class Bag:
    """A recorded session in memory."""

    def __init__(
        self, topics: dict[str, TopicInfo], messages: dict[str, list[Message]], complete: bool
    ) -> None:
        self.topics = topics
        self.complete = complete  # False: the recorder was killed, the file has no footer
        self._messages = messages
        self._series: dict[str, Series] = {}

    def name(self, topic: str | Topic) -> str | None:
        """The name under which the bag holds a topic, in whatever namespace; None if it does not."""
        if isinstance(topic, str):
            return topic if topic in self.topics else None
        return next((name for name in self.topics if find(name) == topic), None)

    def series(self, topic: str | Topic) -> Series:
        """The values of a topic over time.

        Raises:
            NotInBag: the bag does not hold the topic.
            ValueError: messages of this type have no numbers to plot.
        """
        name = self.name(topic)
        if name is None:
            wanted = topic if isinstance(topic, str) else topic.name
            raise NotInBag(f"no topic '{wanted}'; the bag holds {', '.join(sorted(self.topics))}")
        if name not in self._series:
            self._series[name] = _series(name, self.topics[name].type, self._messages[name])
        return self._series[name]


def bag_of(series: Mapping[Topic, Series]) -> Bag:
    """A session in memory that was never a file: its pictures are drawn like a recorded one's."""
    bag = Bag({}, {}, complete=True)
    for topic, values in series.items():
        times = values.log_time_ns
        first, last = (int(times[0]), int(times[-1])) if len(times) else (0, 0)
        bag.topics[topic.name] = TopicInfo(topic.type, len(times), first, last, 0)
        bag._series[topic.name] = values
    return bag


def read_bag(path: str | Path) -> Bag:
    """Read a bag directory or one .mcap file.

    Raises:
        FileNotFoundError: there is no .mcap file.
    """
    path = Path(path)
    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    if not files or not files[0].is_file():
        raise FileNotFoundError(f"no .mcap file in {path}")
    channels: dict[str, Channel] = {}
    types: dict[str, str] = {}
    messages: dict[str, list[Message]] = {}
    complete = True
    for file in files:
        complete &= _read_file(file, channels, types, messages)
    lost = _recorded_losses(path)
    topics = {
        name: _info(types[name], messages[name], lost.get(name), channels[name]) for name in sorted(channels)
    }
    return Bag(topics, messages, complete)


def _read_file(
    file: Path, channels: dict[str, Channel], types: dict[str, str], messages: dict[str, list[Message]]
) -> bool:
    """Collect one file's messages by topic; True if it ends as a finished file does."""
    schemas: dict[int, Schema] = {}
    names: dict[int, str] = {}
    with file.open("rb") as stream:
        try:
            for record in _records(stream):
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    names[record.id] = record.topic
                    channels.setdefault(record.topic, record)
                    types.setdefault(record.topic, schemas[record.schema_id].name)
                    messages.setdefault(record.topic, [])
                elif isinstance(record, Message):
                    messages[names[record.channel_id]].append(record)
                elif isinstance(record, Footer):
                    return True
        except (McapError, struct.error):
            pass  # cut off in the middle of a record: what came before is whole
    return False


def _records(stream: Any) -> Iterator[Any]:
    yield from StreamReader(stream).records


def _recorded_losses(path: Path) -> dict[str, int]:
    """The recorder's own counts, from metadata.yaml; {} if the bag has none."""
    file = path / "metadata.yaml"
    if not path.is_dir() or not file.is_file():
        return {}
    custom = yaml.safe_load(file.read_text())["rosbag2_bagfile_information"].get("custom_data") or {}
    prefix = "lost_messages:"
    return {key[len(prefix) :]: int(value) for key, value in custom.items() if key.startswith(prefix)}


def _info(type_name: str, messages: list[Message], lost: int | None, channel: Channel) -> TopicInfo:
    times = [message.log_time for message in messages]
    if lost is None:
        publishers = len(yaml.safe_load(channel.metadata.get("offered_qos_profiles", "")) or [None])
        gaps = SequenceGaps()
        for message in messages:
            gaps.observe(message.sequence, lambda: publishers)
        lost = gaps.lost
    return TopicInfo(type_name, len(times), min(times, default=0), max(times, default=0), lost)


def _series(name: str, type_name: str, messages: list[Message]) -> Series:
    take = TAKERS.get(type_name)
    if take is None:
        raise ValueError(f"{name}: {type_name} has no series; allowed: {', '.join(sorted(TAKERS))}")
    from rclpy.serialization import deserialize_message  # only here: counting needs no ROS

    row = find(name)
    kind = row if row is not None and row.type == type_name else unlisted(name, type_name)
    message_type = message_class(kind)
    rows = [take(kind, deserialize_message(message.data, message_type)) for message in messages]
    columns = dict(zip(kind.labels, kind.units, strict=True)) if not rows else {}
    for row_ in rows:
        if row_.labels != tuple(columns):
            columns |= dict(zip(row_.labels, row_.units, strict=True))
    places = {label: place for place, label in enumerate(columns)}
    values = np.full((len(rows), len(columns)), np.nan)
    for line, row_ in zip(values, rows, strict=True):
        line[[places[label] for label in row_.labels]] = row_.values
    log_time = np.array([message.log_time for message in messages], dtype=np.int64)
    time = np.array(
        [log if r.stamp_ns is None else r.stamp_ns for r, log in zip(rows, log_time, strict=True)],
        dtype=np.int64,
    )
    incomplete = sum(len(r.labels) < len(columns) for r in rows)
    return Series(time, log_time, values, tuple(columns), tuple(columns.values()), incomplete)
