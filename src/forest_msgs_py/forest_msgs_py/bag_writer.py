"""The bag writer: raw CDR bytes into MCAP files in a directory shaped as rosbag2 of Jazzy writes it.

===============  ===========================================================================================
symbol           meaning
===============  ===========================================================================================
log time         when a recorder received a message, system time, ns; a simulation: its stamp
publish time     when its publisher sent it (DDS source timestamp), ns
sequence         the publisher's count of its messages; gaps are losses
QoS profile      dict with the keys of rosbag2's metadata version 9
split            one of a bag's files; each is whole by itself: types, topics, latched messages, context
===============  ===========================================================================================

No ROS in here. A killed process leaves every finished chunk behind, so chunks are kept small and are
flushed by the clock.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from forest_msgs_py.bag_metadata import (
    FileEntry,
    TopicEntry,
    dump,
    information,
    sync_directory,
    write_metadata,
)
from forest_msgs_py.definitions import message_definition
from forest_msgs_py.latched import Latched, Sample
from forest_msgs_py.mcap_file import CHUNK_BYTES, McapFile

FLUSH_PERIOD_S = 0.1  # what a killed recorder loses at most
CHUNKS_PER_FILE = 100_000  # three hours of flushes: a file's index is bounded in memory, here and in readers
LIBRARY = "forest_msgs_py bag_writer"


class Attached(NamedTuple):
    """A file within the bag, told once and repeated in every split; time in ns."""

    name: str
    media_type: str
    data: bytes
    time_ns: int


class Layout(NamedTuple):
    """How a bag is laid out in files; 0 means no limit."""

    compression: str = "zstd"
    max_bytes: int = 0
    max_ns: int = 0
    chunk_bytes: int = CHUNK_BYTES
    durable: bool = False


ONE_FILE = Layout()


class _Recorded:
    """One topic of the bag."""

    def __init__(self, type_name: str, qos: Sequence[Mapping[str, Any]], type_hash: str) -> None:
        self.type, self.qos, self.type_hash = type_name, list(qos), type_hash
        self.channel = 0  # in the present file

    def says_all(self, other: _Recorded) -> bool:
        """Whether this one's channel tells what there is to tell of the other, too."""
        same = self.type_hash == other.type_hash
        return same and all(profile in self.qos for profile in other.qos)


class BagWriter:
    """Writes one bag: a new directory with ``<name>_0.mcap``, ... and, once closed, ``metadata.yaml``.

    Args:
        directory: to be made.
        layout: compression, and when the next file begins.
        latched: what the latched topics hold already.

    Raises:
        FileExistsError: the directory exists: a record is never overwritten.
        OSError: it cannot be made.
    """

    def __init__(
        self, directory: str | Path, layout: Layout = ONE_FILE, latched: Latched | None = None
    ) -> None:
        self.directory = Path(directory).absolute()
        try:
            self.directory.mkdir(parents=True)
        except FileExistsError:
            raise FileExistsError(f"{directory} exists; allowed: a directory to be made") from None
        self.lost: dict[str, int] = {}
        self.counts: dict[str, int] = {}  # taken in, by topic; the last of them may not be written yet
        self.latched = Latched() if latched is None else latched
        self.files: list[FileEntry] = []  # finished
        self._layout = layout
        self._topics: dict[str, _Recorded] = {}
        self._context: dict[str, Attached | dict[str, str]] = {}
        self._written: dict[str, int] = {}  # in finished files
        self._size_before = 0
        self._closed = False
        self._file = self._next_file()
        sync_directory(self.directory.parent)

    @property
    def message_count(self) -> int:
        """Messages taken in so far, without those repeated at the beginning of splits."""
        return sum(self.counts.values())

    @property
    def written(self) -> int:
        """Messages in finished files."""
        return sum(file.messages for file in self.files)

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return self._size_before + (0 if self._file.finished else self._file.size)

    @property
    def file_name(self) -> str:
        """Name of the present file."""
        return f"{self.directory.name}_{len(self.files)}.mcap"

    def add_topic(self, name: str, type_name: str, qos: Sequence[Mapping[str, Any]], type_hash: str) -> bool:
        """Open a channel for a topic, or a further one because a publisher came that offers something else.

        Args:
            name: resolved topic name.
            type_name: like ``sensor_msgs/msg/JointState``.
            qos: what each publisher offers, with the keys of rosbag2's metadata.
            type_hash: hash of the type's description, ``RIHS01_...``.

        Returns:
            False if the message definition is not installed; the bytes are kept all the same.
        """
        before = self._topics.get(name)
        topic = self._topics[name] = _Recorded(type_name, qos, type_hash)
        self.latched.watch(name, qos)
        self.counts.setdefault(name, 0)
        self.lost.setdefault(name, 0)
        if before is not None and before.says_all(topic):
            topic.channel = before.channel
            return True
        return self._open_channel(name, topic)

    def attach(self, file: Attached) -> None:
        """Put a file into the bag, into every split of it.

        Raises:
            OSError: the disk is full.
        """
        self._context[file.name] = file
        self._file.attach(*file)

    def note(self, name: str, values: dict[str, str]) -> None:
        """Put a metadata record into the bag, into every split of it.

        Raises:
            OSError: the disk is full.
        """
        self._context[name] = values
        self._file.note(name, values)

    def write(self, name: str, data: bytes, log_ns: int, publish_ns: int, sequence: int = 0) -> None:
        """Store one message's bytes.

        Raises:
            OSError: the disk is full, or the file cannot be written.
        """
        if log_ns >= self._end_ns or self._file.size + len(data) > self._end_bytes:
            self.split()
        if self._empty:
            self._begin(log_ns)
        self._file.add_message(self._topics[name].channel, log_ns, data, publish_ns, sequence)
        self.counts[name] += 1
        if name in self.latched:
            self.latched.keep(Sample(name, data, log_ns, publish_ns, sequence))

    def flush(self) -> None:
        """Finish the open chunk and hand it to the operating system: from here on a kill cannot take it.

        Raises:
            OSError: the disk is full, or the file cannot be written.
        """
        self._file.flush()
        if self._file.chunks >= CHUNKS_PER_FILE:
            self.split()

    def split(self) -> None:
        """Finish the present file and begin the next one; nothing happens if the present one is empty.

        Raises:
            OSError: the disk is full, or the file cannot be written.
        """
        if not self._empty:
            self._finish_file()
            self._file = self._next_file()

    def close(self) -> None:
        """Finish the file, force it to the disk and write ``metadata.yaml``; a second call does nothing.

        Raises:
            OSError: the disk is full; the file is closed nevertheless.
        """
        if self._closed:
            return
        self._closed = True
        try:
            self._finish_file()
        finally:
            if self._empty and len(self.files) > 1:
                (self.directory / self.files.pop().path).unlink()
            write_metadata(self.directory, self._about(self.files, self._written))

    def _next_file(self) -> McapFile:
        layout = self._layout
        path = self.directory / self.file_name
        file = self._file = McapFile(path, layout.compression, layout.chunk_bytes, layout.durable, LIBRARY)
        self._schemas: dict[str, int] = {}
        self._names: dict[int, str] = {}  # of the topics, by channel
        self._empty = True
        self._end_ns: float = math.inf
        self._end_bytes: float = math.inf
        for name, topic in self._topics.items():
            self._open_channel(name, topic)
        for name, told in self._context.items():
            if isinstance(told, Attached):
                file.attach(*told)
            else:
                file.note(name, told)
        return file

    def _open_channel(self, name: str, topic: _Recorded) -> bool:
        known = True
        if topic.type not in self._schemas:
            try:
                text, encoding = message_definition(topic.type), "ros2msg"
            except FileNotFoundError:
                text, encoding, known = "", "", False
            self._schemas[topic.type] = self._file.add_schema(topic.type, encoding, text.encode())
        metadata = {"offered_qos_profiles": dump(topic.qos), "topic_type_hash": topic.type_hash}
        topic.channel = self._file.add_channel(name, self._schemas[topic.type], metadata)
        self._names[topic.channel] = name
        return known

    def _begin(self, log_ns: int) -> None:
        """Have the file begin with what the latched topics hold, as a subscriber would be told."""
        self._empty = False
        for sample in self.latched:
            if sample.name in self._topics:
                channel = self._topics[sample.name].channel
                self._file.add_message(channel, log_ns, sample.data, sample.publish_ns, sample.sequence)
        if self._layout.max_ns:
            self._end_ns = log_ns + self._layout.max_ns
        if self._layout.max_bytes:  # but what every split begins with is no reason for the next one
            self._end_bytes = max(self._layout.max_bytes, 2 * self._file.size)

    def _finish_file(self) -> None:
        file, name = self._file, self.file_name

        def counts() -> dict[str, int]:
            topics: dict[str, int] = {}
            for channel, count in file.counts.items():
                topics[self._names[channel]] = topics.get(self._names[channel], 0) + count
            return topics

        def entry() -> FileEntry:
            return FileEntry(name, file.first_ns, file.last_ns, file.message_count)

        def say_about() -> None:
            file.note("rosbag2", {"serialized_metadata": dump(self._about([entry()], counts()))})

        try:
            file.finish(say_about)
        finally:
            self.files.append(entry())
            self._size_before += file.size
            for topic, count in counts().items():
                self._written[topic] = self._written.get(topic, 0) + count

    def _about(self, files: list[FileEntry], counts: dict[str, int]) -> dict[str, Any]:
        topics = [
            TopicEntry(name, topic.type, topic.qos, topic.type_hash, counts.get(name, 0))
            for name, topic in self._topics.items()
        ]
        return information(files, topics, self.lost)
