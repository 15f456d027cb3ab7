"""A whole bag from the readable records of damaged files, one file for each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml
from mcap.records import Attachment, Channel, Message, Metadata, Schema

from forest_msgs_py.bag_files import BagError
from forest_msgs_py.bag_metadata import FileEntry, TopicEntry, dump, information, write_metadata
from forest_msgs_py.mcap_file import McapFile
from forest_msgs_py.salvage import Salvage
from forest_msgs_py.sequences import SequenceGaps

CHUNK_BYTES = 1 << 20
LIBRARY = "forest_msgs_py recovery"


class _Topic:
    """What all files together say of one topic."""

    def __init__(self, type_name: str) -> None:
        self.type = type_name
        self.type_hash = ""
        self.qos: list[dict[str, Any]] = []
        self.messages = 0
        self._gaps = SequenceGaps()

    def learn(self, metadata: dict[str, str]) -> None:
        """Take in what a channel tells; the last one knows all publishers."""
        self.type_hash = metadata.get("topic_type_hash", self.type_hash)
        try:
            told = yaml.safe_load(metadata.get("offered_qos_profiles", ""))
        except yaml.YAMLError:
            return
        if isinstance(told, list) and all(isinstance(profile, dict) for profile in told):
            self.qos = told

    def count(self, sequence: int) -> None:
        """Take in a message."""
        self.messages += 1
        self._gaps.observe(sequence, lambda: len(self.qos))

    @property
    def lost(self) -> int:
        """Gaps in the publishers' numbers."""
        return self._gaps.lost


class Recovered:
    """A recovery: what became of each file, and the topics by name."""

    def __init__(self) -> None:
        self.files: list[tuple[Path | None, Salvage]] = []
        self.topics: dict[str, _Topic] = {}
        self.nameless = 0  # messages of channels that nothing readable tells about

    @property
    def messages(self) -> int:
        """Number of messages in all files."""
        return sum(topic.messages for topic in self.topics.values())

    def about(self, files: Sequence[FileEntry], counts: dict[str, int] | None = None) -> dict[str, Any]:
        """Return rosbag2's metadata of some files; counts by topic, if not those of all files."""
        topics = [
            TopicEntry(
                name, t.type, t.qos, t.type_hash, t.messages if counts is None else counts.get(name, 0)
            )
            for name, t in self.topics.items()
        ]
        return information(files, topics, {name: topic.lost for name, topic in self.topics.items()})


def recover(files: Sequence[Path], output: Path) -> Recovered:
    """Write what is readable in some files as one bag.

    Raises:
        BagError: nothing in them is.
        OSError: the output exists, cannot be made, or its disk is full.
    """
    recovered = Recovered()
    entries: list[FileEntry] = []
    salvages = [Salvage(file) for file in files]
    if all(salvage.empty for salvage in salvages):
        raise BagError(f"{', '.join(map(str, files))}: nothing in it can be read; is it an MCAP file?")
    output.mkdir(parents=True)
    for salvage in salvages:
        path = None if salvage.empty else output / f"{output.resolve().name}_{len(entries)}.mcap"
        recovered.files.append((path, salvage))
        if path is not None:
            entries.append(_copy(salvage, path, recovered))
    write_metadata(output, recovered.about(entries))
    return recovered


def _copy(salvage: Salvage, path: Path, recovered: Recovered) -> FileEntry:
    """Write one file."""
    out = McapFile(path, "zstd", CHUNK_BYTES, library=LIBRARY)
    copy = _Copy(out, recovered)

    def entry() -> FileEntry:
        return FileEntry(path.name, out.first_ns, out.last_ns, out.message_count)

    def say_about() -> None:
        about = recovered.about([entry()], copy.counts)
        out.note("rosbag2", {"serialized_metadata": dump(about)})

    try:
        for record in salvage:
            copy.take(record)
    finally:
        out.finish(say_about)
    return entry()


class _Copy:
    """Puts the records of a damaged file into a new one; numbers of schemas and channels change."""

    def __init__(self, out: McapFile, recovered: Recovered) -> None:
        self.counts: dict[str, int] = {}
        self._out, self._recovered = out, recovered
        self._schemas: dict[int, tuple[str, int]] = {0: ("", 0)}  # the file's number: type, our number
        self._channels: dict[int, tuple[str, int]] = {}

    def take(self, record: Any) -> None:
        """Copy one record."""
        if isinstance(record, Message):
            self._message(record)
        elif isinstance(record, Schema) and record.id not in self._schemas:
            number = self._out.add_schema(record.name, record.encoding, record.data)
            self._schemas[record.id] = record.name, number
        elif isinstance(record, Channel) and record.id not in self._channels:
            self._channel(record)
        elif isinstance(record, Attachment):
            self._out.attach(record.name, record.media_type, record.data, record.log_time)
        elif isinstance(record, Metadata) and record.name != "rosbag2":  # it counts what is no longer true
            self._out.note(record.name, record.metadata)

    def _channel(self, channel: Channel) -> None:
        if channel.schema_id not in self._schemas:
            return
        type_name, schema = self._schemas[channel.schema_id]
        number = self._out.add_channel(channel.topic, schema, channel.metadata, channel.message_encoding)
        self._channels[channel.id] = channel.topic, number
        self._recovered.topics.setdefault(channel.topic, _Topic(type_name)).learn(channel.metadata)

    def _message(self, message: Message) -> None:
        if message.channel_id not in self._channels:
            self._recovered.nameless += 1
            return
        name, channel = self._channels[message.channel_id]
        self._out.add_message(channel, message.log_time, message.data, message.publish_time, message.sequence)
        self._recovered.topics[name].count(message.sequence)
        self.counts[name] = self.counts.get(name, 0) + 1
