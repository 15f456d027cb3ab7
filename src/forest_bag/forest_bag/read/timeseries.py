"""A bag as time series: counts per topic, and each topic's values as arrays with stamps, labels and units.

============  ==============================================================================================
symbol        meaning
============  ==============================================================================================
time_ns       header stamp, ROS time, int64 [N]; where a message has none, its log time
log_time_ns   when the recorder received it, system time, int64 [N]
values        float64 [N, k], one column per label
============  ==============================================================================================

A bag whose recorder was killed (no footer, no index, no ``metadata.yaml``) gives every finished chunk.
"""

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_bag.read.bag_reader import BagReader
from forest_bag.read.batch_decoder import decoded
from forest_bag.read.flatten import FLATTENERS, Row, flatten_any
from forest_bag.read.survey import TopicInfo, topic_infos, use_recorded_losses
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.raw_messages import Channel, RawMessage
from forest_description.types import Floats
from forest_msgs_py.interfaces.topics import Topic, find, unlisted
from forest_msgs_py.serialization.cdr import CdrError, cdr_type

LATEST_NS = 2**63 - 1  # of a log time in an array; MCAP's own are unsigned


class NotInBag(LookupError):
    """A topic or a column that the bag does not hold; the text names what there is."""


class Series(NamedTuple):
    """One topic over time; NaN where a message lacks a column, as ``incomplete`` of them do.

    ``unreadable`` of these are no messages of the topic's type: they have no column at all.
    """

    time_ns: NDArray[np.int64]
    log_time_ns: NDArray[np.int64]
    values: Floats
    labels: tuple[str, ...]
    units: tuple[str, ...]
    incomplete: int
    unreadable: int = 0

    def column(self, label: str) -> Floats:
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
        self,
        topics: dict[str, TopicInfo],
        channels: dict[str, Channel],
        messages: dict[str, list[RawMessage]],
        complete: bool,
    ) -> None:
        self.topics = topics
        self.complete = complete  # False: the recorder was killed, the file has no footer
        self._channels, self._messages = channels, messages
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
            self._series[name] = series_of(self._channels[name], self._messages[name])
        return self._series[name]

    def sent_ns(self, topic: Topic) -> NDArray[np.int64]:
        """When each message of a topic was published, by its publisher's system clock [ns], as `series`.

        Raises:
            NotInBag: the bag does not hold the topic.
        """
        series = self.series(topic)
        messages = self._messages.get(str(self.name(topic)))
        if messages is None:  # it was never a file
            return series.log_time_ns
        return np.array([message.publish_ns for message in messages], dtype=np.int64)


def bag_of(series: Mapping[Topic, Series]) -> Bag:
    """A session in memory that was never a file: its pictures are drawn like a recorded one's."""
    bag = Bag({}, {}, {}, complete=True)
    for topic, values in series.items():
        times = values.log_time_ns
        first, last = (int(times[0]), int(times[-1])) if len(times) else (0, 0)
        bag.topics[topic.name] = TopicInfo(topic.type, count=len(times), first_ns=first, last_ns=last)
        bag._series[topic.name] = values
    return bag


def read_bag(path: str | Path, topics: Collection[str] | None = None) -> Bag:
    """Read a bag into memory: what is whole of it.

    Args:
        path: directory or file, of any kind that `BagReader` reads.
        topics: keep the messages of these only; None: of all.

    Raises:
        FileNotFoundError: there is no bag.
    """
    try:
        with BagReader(path, lenient=True) as reader:
            messages: dict[str, list[RawMessage]] = {}
            for message in reader.messages():
                if topics is None or message.channel.topic in topics:
                    messages.setdefault(message.channel.topic, []).append(message)
            infos = topic_infos(reader)
            for name, info in infos.items():
                for message in messages.setdefault(name, []):
                    info.add(message)
            use_recorded_losses(infos, reader)
            channels = {name: found[0] for name, found in reader.channels.items()}
            return Bag(infos, channels, messages, reader.complete)
    except BagError as error:
        raise FileNotFoundError(str(error)) from error


def message_reader(channel: Channel) -> Callable[[bytes], tuple[Row, Any]]:
    """Return what turns a topic's CDR bytes into a row of labelled numbers, and the whole message.

    Raises:
        ValueError: the type is not installed here, and the bag does not hold its definition.
        CdrError: (what is returned) the bytes are no message of the type.
    """
    name, type_name = channel.topic, channel.type
    try:
        cdr = cdr_type(type_name, channel.definition)
    except ValueError:
        raise ValueError(f"{name}: {type_name or 'its type'} is not installed here") from None
    kind, take = _kind(channel), FLATTENERS.get(type_name, flatten_any)

    def read(data: bytes) -> tuple[Row, Any]:
        message = cdr.decode(data)
        return take(kind, message), message

    return read


def _kind(channel: Channel) -> Topic:
    """The row of the topic table, or one for somebody else's topic."""
    row = find(channel.topic)
    return row if row is not None and row.type == channel.type else unlisted(channel.topic, channel.type)


def series_of(channel: Channel, messages: list[RawMessage]) -> Series:
    """Return messages of one topic as arrays.

    Raises:
        ValueError: their type is not known, or has no numbers.
    """
    read, kind = message_reader(channel), _kind(channel)
    log_time = np.array([min(message.log_ns, LATEST_NS) for message in messages], dtype=np.int64)
    rows, unreadable = _rows(read, messages[:1])
    if rows and (batch := decoded(kind, [message.data for message in messages], rows[0])) is not None:
        return Series(
            time_ns=batch[0],
            log_time_ns=log_time,
            values=batch[1],
            labels=rows[0].labels,
            units=rows[0].units,
            incomplete=0,
        )
    rows, unreadable = _rows(read, messages)
    columns = dict(zip(kind.labels, kind.units, strict=True)) if not rows else {}
    for row in rows:
        if row.labels != tuple(columns):
            columns |= dict(zip(row.labels, row.units, strict=True))
    if rows and not columns:
        raise ValueError(
            f"{channel.topic}: {channel.type} has no series; allowed: messages with numbers in them"
        )
    places = {label: place for place, label in enumerate(columns)}
    values = np.full((len(rows), len(columns)), np.nan)
    for line, row in zip(values, rows, strict=True):
        line[[places[label] for label in row.labels]] = row.values
    stamps = [log if row.stamp_ns is None else row.stamp_ns for row, log in zip(rows, log_time, strict=True)]
    incomplete = sum(len(row.labels) < len(columns) for row in rows)
    time = np.array(stamps, dtype=np.int64)
    return Series(
        time_ns=time,
        log_time_ns=log_time,
        values=values,
        labels=tuple(columns),
        units=tuple(columns.values()),
        incomplete=incomplete,
        unreadable=unreadable,
    )


def _rows(read: Callable[[bytes], tuple[Row, Any]], messages: list[RawMessage]) -> tuple[list[Row], int]:
    """One row for each message, an empty one for what is unreadable, and how many of these there are."""
    found = [_row(read, message.data) for message in messages]
    return [row or Row(None, (), (), ()) for row in found], found.count(None)


def _row(read: Callable[[bytes], tuple[Row, Any]], data: bytes) -> Row | None:
    try:
        return read(data)[0]
    except CdrError:
        return None
