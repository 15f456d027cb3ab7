"""Bags written again as other bags: filtered, merged, split, in another storage or compression.

Messages keep their bytes, their log times and, in MCAP, their publish times and sequence numbers.
"""

import shutil
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import yaml
import zstandard

from forest_bag.convert.output_options import OutputBag
from forest_bag.read.bag_reader import BagReader
from forest_bag.read.merged_bags import MergedBags
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.metadata import METADATA_FILE, OfferedTopic, recorded_losses, write_metadata
from forest_bag.storage.raw_messages import Channel
from forest_bag.write.bag_split import Attached
from forest_bag.write.bag_writer import BagWriter
from forest_msgs_py.interfaces.qos_profiles import in_words

NOT_FOR_BAGS = ("rosbag2",)  # metadata records that tell of one file, not of the bag


def rewrite(source: MergedBags, outputs: Sequence[OutputBag]) -> list[BagWriter]:
    """Write the outputs; return their writers, closed.

    Raises:
        BagError: a topic cannot be written as one, or an output would have none.
        Damaged: bytes of the source were changed.
        OSError: an output exists, or its disk is full.
    """
    chosen = [_offers(source, output) for output in outputs]
    writers: list[BagWriter] = []
    try:
        with ExitStack() as opened:
            for output, offers in zip(outputs, chosen, strict=True):
                writers.append(opened.enter_context(closing(BagWriter(output.directory, output.layout))))
                prepare(writers[-1], source, offers)
            _copy(source, outputs, writers)
        for writer, output in zip(writers, outputs, strict=True):
            if output.mode:
                _tell_compression(writer, output.mode)
    except BaseException:  # half a bag would look like a whole one
        for writer in writers:
            shutil.rmtree(writer.directory, ignore_errors=True)
        raise
    return writers


def _copy(source: MergedBags, outputs: Sequence[OutputBag], writers: Sequence[BagWriter]) -> None:
    compressor = zstandard.ZstdCompressor()
    pairs = list(zip(outputs, writers, strict=True))
    topics = {name for writer in writers for name in writer.counts}
    start_ns = max(0, min(output.start_ns for output in outputs))
    for message in source.messages(topics, start_ns):
        for output, writer in pairs:
            name, log_ns = message.channel.topic, message.log_ns
            late = output.end_ns >= 0 and log_ns > output.end_ns
            if name not in writer.counts or log_ns < output.start_ns or late:
                continue
            data = compressor.compress(message.data) if output.mode == "message" else message.data
            writer.write(name, data, log_ns, message.publish_ns, message.sequence)


def _offers(source: MergedBags, output: OutputBag) -> list[OfferedTopic]:
    wanted = {
        name: channels
        for name, channels in source.channels.items()
        if any(output.selection.wants(name, channel.type) for channel in channels)
    }
    if not wanted:
        known = ", ".join(source.channels) or "none"
        raise BagError(f"{output.directory}: no topic of {source.path} is chosen; there are {known}")
    return [offer(name, channels) for name, channels in wanted.items()]


def offer(name: str, channels: Sequence[Channel]) -> OfferedTopic:
    """Join what several files or publishers told of a topic: one entry, as rosbag2 joins them.

    Raises:
        BagError: they told different types.
    """
    kinds = {(channel.type, channel.encoding) for channel in channels}
    hashes = {channel.type_hash for channel in channels if channel.type_hash}
    if len(kinds) > 1 or len(hashes) > 1:
        told = ", ".join(sorted({f"{c.type} ({c.type_hash or c.encoding})" for c in channels}))
        raise BagError(f"{name} has several types: {told}; allowed: one, or leave it out (exclude_topics)")
    profiles: list[dict[str, Any]] = []
    for channel in channels:
        profiles += [profile for profile in in_words(channel.qos) if profile not in profiles]
    defined = next((c for c in channels if c.definition), None)
    definition = (defined.definition_format, defined.definition) if defined else None
    ((kind, encoding),) = kinds
    return OfferedTopic(name, kind, profiles, next(iter(hashes), ""), encoding, definition)


def prepare(writer: BagWriter, source: MergedBags, offers: Sequence[OfferedTopic]) -> None:
    """Put into a bag what stands beside a source's messages: topics, losses, files, metadata records.

    Raises:
        OSError: the disk is full.
    """
    for offered in offers:
        writer.add_offer(offered)
    for reader in source.readers:
        for name, count in recorded_losses(reader.information).items():
            if name in writer.lost:
                writer.lost[name] += count
    for file in _attachments(source.readers):
        writer.attach(file)
    for name, values in _notes(source.readers):
        writer.note(name, values)


def _attachments(readers: Sequence[BagReader]) -> Iterator[Attached]:
    """Give the files in the bags, each content once; of two with one name, the later bag's gets its name."""
    known: dict[str, bytes] = {}
    for reader in readers:
        for a in (a for file in reader.files for a in file.attachments):
            if known.get(a.name) == a.data:
                continue
            name = f"{reader.path.resolve().name}/{a.name}" if a.name in known else a.name
            if known.get(name) != a.data:
                known[name] = a.data
                yield Attached(name, a.media_type, a.data, a.time_ns)


def _notes(readers: Sequence[BagReader]) -> Iterator[tuple[str, dict[str, str]]]:
    """Give the metadata records of the bags; of two with one name, the later bag's gets its name."""
    known: dict[str, dict[str, str]] = {}
    for reader in readers:
        for name, values in (note for file in reader.files for note in file.metadata):
            if name in NOT_FOR_BAGS or known.get(name) == values:
                continue
            name = f"{reader.path.resolve().name}/{name}" if name in known else name
            if known.get(name) != values:
                known[name] = values
                yield name, values


def _tell_compression(writer: BagWriter, mode: str) -> None:
    """Compress whole files, if that is the mode, and have metadata.yaml tell how to read the bag."""
    text = (writer.directory / METADATA_FILE).read_text(encoding="utf-8")
    about = yaml.safe_load(text)["rosbag2_bagfile_information"]
    about |= {"compression_format": "zstd", "compression_mode": mode.upper()}
    if mode == "file":
        about["relative_file_paths"] = [f"{name}.zstd" for name in about["relative_file_paths"]]
        for file in about["files"]:
            file["path"] = _compressed(writer.directory / file["path"]).name
    write_metadata(writer.directory, about)


def _compressed(file: Path) -> Path:
    target = file.with_name(f"{file.name}.zstd")
    with file.open("rb") as source, target.open("xb") as stream:
        zstandard.ZstdCompressor().copy_stream(source, stream, size=file.stat().st_size)
    file.unlink()
    return target
