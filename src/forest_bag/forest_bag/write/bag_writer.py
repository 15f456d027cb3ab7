"""The bag writer: raw CDR bytes into MCAP files in a directory shaped as rosbag2 of Jazzy writes it.

===============  ===========================================================================================
symbol           meaning
===============  ===========================================================================================
log time         when a recorder received a message, system time, ns; a simulation: its stamp
publish time     when its publisher sent it (DDS source timestamp), ns
sequence         the publisher's count of its messages; gaps are losses
QoS profile      dict with the keys of rosbag2's metadata version 9
split            one of a bag's files; each has types, topics, context, transient-local messages
===============  ===========================================================================================

No ROS in here. A killed process leaves every finished chunk behind, so chunks are kept small and are
flushed by the clock.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from forest_bag.storage.metadata import FileEntry, OfferedTopic, information, sync_directory, write_metadata
from forest_bag.write.bag_split import ONE_FILE, Attached, Contents, Layout, Split
from forest_bag.write.transient_local import Sample

SUFFIXES = {"mcap": ".mcap", "sqlite3": ".db3"}  # by rosbag2's name of the format
FLUSH_PERIOD_S = 0.1  # what a killed recorder loses, if it was let run
CHUNKS_PER_FILE = 100_000  # three hours of flushes: a file's index is bounded in memory, here and in readers


class BagWriter:
    """Writes one bag: a new directory with ``<name>_0.mcap``, ... and, once closed, ``metadata.yaml``.

    Args:
        directory: to be made.
        layout: compression, and when the next file begins.
        contents: what every file begins with, as an earlier bag of the recording left it.

    Raises:
        FileExistsError: the directory exists: a record is never overwritten.
        OSError: it cannot be made.
    """

    def __init__(
        self, directory: str | Path, layout: Layout = ONE_FILE, contents: Contents | None = None
    ) -> None:
        self.directory = Path(directory).absolute()
        try:
            self.directory.mkdir(parents=True)
        except FileExistsError:
            raise FileExistsError(f"{directory} exists; allowed: a directory to be made") from None
        self._contents = Contents() if contents is None else contents
        self.lost = dict.fromkeys(self._contents.topics, 0)
        self.counts = dict(self.lost)  # taken in, by topic; the last of them may not be written yet
        self.files: list[FileEntry] = []  # finished
        self._layout = layout
        self._written = dict.fromkeys(self._contents.topics.values(), 0)  # in finished files, by offer
        self._size_before = 0
        self._closed = False
        self._split = self._next_split()
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
        return self._size_before + (0 if self._split.file.finished else self._split.file.size)

    @property
    def file_name(self) -> str:
        """Name of the present file."""
        return f"{self.directory.name}_{len(self.files)}{SUFFIXES[self._layout.storage]}"

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
        return self.add_offer(OfferedTopic(name, type_name, qos, type_hash))

    def add_offer(self, offer: OfferedTopic) -> bool:
        """Open a channel for a topic whose definition may come from elsewhere; see `add_topic`."""
        self.counts.setdefault(offer.name, 0)
        self.lost.setdefault(offer.name, 0)
        if not self._contents.add(offer):
            return True
        self._written[offer] = 0
        return self._split.open_channel(offer)

    def attach(self, file: Attached) -> None:
        """Put a file into the bag, into every split of it.

        Raises:
            OSError: the disk is full.
        """
        self._contents.context[file.name] = file
        self._split.file.attach(*file)

    def note(self, name: str, values: dict[str, str]) -> None:
        """Put a metadata record into the bag, into every split of it.

        Raises:
            OSError: the disk is full.
        """
        self._contents.context[name] = values
        self._split.file.note(name, values)

    def write(self, name: str, data: bytes, log_ns: int, publish_ns: int, sequence: int = 0) -> None:
        """Store one message's bytes.

        Raises:
            OSError: the disk is full, or the file cannot be written.
        """
        if log_ns >= self._end_ns or self._split.file.size + len(data) > self._end_bytes:
            self.split()
        if self._split.empty:
            self._begin(log_ns)
        self._split.file.add_message(self._contents.topics[name].channel, log_ns, data, publish_ns, sequence)
        self.counts[name] += 1
        if self._layout.repeats and name in self._contents.transient_local:
            self._contents.transient_local.keep(Sample(name, data, log_ns, publish_ns, sequence))

    def flush(self) -> None:
        """Finish the open chunk and hand it to the operating system: from here on a kill cannot take it.

        Raises:
            OSError: the disk is full, or the file cannot be written.
        """
        self._split.file.flush()
        if self._split.file.chunks >= CHUNKS_PER_FILE:
            self.split()

    def split(self) -> None:
        """Finish the present file and begin the next one; nothing happens if the present one is empty.

        Raises:
            OSError: the disk is full, or the file cannot be written.
        """
        if not self._split.empty:
            self._finish_split()
            self._split = self._next_split()

    def close(self) -> None:
        """Finish the file, force it to the disk and write ``metadata.yaml``; a second call does nothing.

        Raises:
            OSError: the disk is full; the file is closed nevertheless.
        """
        if self._closed:
            return
        self._closed = True
        try:
            self._finish_split()
        finally:
            if self._split.empty and len(self.files) > 1:
                (self.directory / self.files.pop().path).unlink()
            write_metadata(self.directory, self._about(self.files, self._written))

    def _next_split(self) -> Split:
        split = self._split = Split(self.directory / self.file_name, self._layout)
        self._end_ns: float = math.inf
        self._end_bytes: float = math.inf
        for topic in self._contents.topics.values():
            split.open_channel(topic)
        for name, told in self._contents.context.items():
            split.tell(name, told)
        return split

    def _begin(self, log_ns: int) -> None:
        """Have the file begin with what the transient-local topics hold, as a subscriber would be told."""
        self._split.empty, file = False, self._split.file
        topics = self._contents.topics
        for sample in self._contents.transient_local:
            if sample.name in topics:
                channel = topics[sample.name].channel
                file.add_message(channel, log_ns, sample.data, sample.publish_ns, sample.sequence)
        if self._layout.max_ns:
            self._end_ns = log_ns + self._layout.max_ns
        if self._layout.max_bytes:  # but what every split begins with is no reason for the next one
            self._end_bytes = max(self._layout.max_bytes, 2 * file.size)

    def _finish_split(self) -> None:
        split = self._split
        if split.file.finished:  # the next one could not be made
            return
        try:
            split.finish(lambda entry, counts: self._about([entry], counts))
        finally:
            self.files.append(split.file.entry)
            self._size_before += split.file.size
            for offer, count in split.counts().items():
                self._written[offer] += count

    def _about(self, files: list[FileEntry], counts: dict[OfferedTopic, int]) -> dict[str, Any]:
        return information(
            files, {offer: counts.get(offer, 0) for offer in self._written}, self.lost, self._layout.storage
        )
