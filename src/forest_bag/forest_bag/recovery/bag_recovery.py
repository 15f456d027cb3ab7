"""A whole bag from the readable records of damaged files, one file for each."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml
from mcap.records import Attachment, Channel, Message, Metadata, Schema

from forest_bag.storage.bag_files import BagError
from forest_bag.storage.mcap_file import McapFile
from forest_bag.storage.mcap_records import MAGIC
from forest_bag.storage.mcap_recovery import RecordRecovery
from forest_bag.storage.metadata import FileEntry, OfferedTopic, information, write_metadata
from forest_msgs_py.interfaces.yaml_text import parsed
from forest_msgs_py.runtime.sequences import SequenceGaps

CHUNK_BYTES = 1 << 20
LIBRARY = "forest_msgs_py recovery"


class Recovered:
    """A recovery: what became of each file, and the topics by name."""

    def __init__(self) -> None:
        self.files: list[tuple[Path | None, RecordRecovery]] = []
        self.topics: dict[str, SequenceGaps] = {}
        self.nameless = 0  # messages of channels that nothing readable tells about
        self._offers: dict[tuple[str, ...], OfferedTopic] = {}
        self._counts: dict[OfferedTopic, int] = {}

    @property
    def messages(self) -> int:
        """Number of messages in all files."""
        return sum(self._counts.values())

    def offer(self, name: str, type_name: str, metadata: dict[str, str]) -> OfferedTopic:
        """Return the entry of a channel, the same for equal ones in several files."""
        self.topics.setdefault(name, SequenceGaps())
        key = (name, type_name, *sorted(f"{k}={v}" for k, v in metadata.items()))
        if key not in self._offers:
            qos = _profiles(metadata.get("offered_qos_profiles", ""))
            self._offers[key] = offer = OfferedTopic(
                name, type_name, qos, metadata.get("topic_type_hash", "")
            )
            self._counts[offer] = 0
        return self._offers[key]

    def count(self, offer: OfferedTopic, sequence: int) -> None:
        """Count a message, and those that are missing before it."""
        self._counts[offer] += 1
        self.topics[offer.name].observe(sequence, lambda: len(offer.qos))

    def about(
        self, files: Sequence[FileEntry], counts: dict[OfferedTopic, int] | None = None
    ) -> dict[str, Any]:
        """Return rosbag2's metadata of some files; counts by offer, if not those of all files."""
        found = self._counts if counts is None else {o: counts.get(o, 0) for o in self._counts}
        return information(files, found, {name: gaps.lost for name, gaps in self.topics.items()})


def _profiles(text: str) -> list[dict[str, Any]]:
    try:
        told = parsed(text)
    except yaml.YAMLError:
        return []
    usable = isinstance(told, list) and all(isinstance(profile, dict) for profile in told)
    return told if usable else []


def recover(files: Sequence[Path], output: Path) -> Recovered:
    """Write what is readable in some files as one bag.

    Raises:
        BagError: nothing in them is.
        OSError: the output exists, cannot be made, or its disk is full.
    """
    recovered = Recovered()
    entries: list[FileEntry] = []
    recoveries = [RecordRecovery(file) for file in files]
    if all(recovery.empty for recovery in recoveries):
        raise BagError("; ".join(map(_why_nothing, files)))
    output.mkdir(parents=True)
    for recovery in recoveries:
        path = None if recovery.empty else output / f"{output.resolve().name}_{len(entries)}.mcap"
        recovered.files.append((path, recovery))
        if path is not None:
            entries.append(_copy(recovery, path, recovered))
    write_metadata(output, recovered.about(entries))
    return recovered


def _why_nothing(file: Path) -> str:
    with file.open("rb") as stream:
        start = stream.read(len(MAGIC))
    if not start:
        return f"{file} is empty (0 bytes): nothing to recover"
    if start != MAGIC:
        return f"{file}: nothing in it can be read; is it an MCAP file?"
    return f"{file} holds neither a message nor an attachment that can be read: nothing to recover"


def _copy(recovery: RecordRecovery, path: Path, recovered: Recovered) -> FileEntry:
    """Write one file."""
    out = McapFile(path, "zstd", CHUNK_BYTES, library=LIBRARY)
    copy = _Copy(out, recovered)
    try:
        for record in recovery:
            copy.take(record)
    finally:
        out.finish(lambda: recovered.about([out.entry], copy.counts))
    return out.entry


class _Copy:
    """Puts the records of a damaged file into a new one; numbers of schemas and channels change."""

    def __init__(self, out: McapFile, recovered: Recovered) -> None:
        self.counts: dict[OfferedTopic, int] = {}
        self._out, self._recovered = out, recovered
        self._schemas: dict[int, tuple[str, int]] = {0: ("", 0)}  # the file's number: type, our number
        self._channels: dict[int, tuple[OfferedTopic, int]] = {}

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
        offer = self._recovered.offer(channel.topic, type_name, channel.metadata)
        self._channels[channel.id] = offer, number

    def _message(self, message: Message) -> None:
        if message.channel_id not in self._channels:
            self._recovered.nameless += 1
            return
        offer, channel = self._channels[message.channel_id]
        self._out.add_message(channel, message.log_time, message.data, message.publish_time, message.sequence)
        self._recovered.count(offer, message.sequence)
        self.counts[offer] = self.counts.get(offer, 0) + 1
