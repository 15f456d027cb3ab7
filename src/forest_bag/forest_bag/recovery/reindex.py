"""`metadata.yaml` of a bag made anew from its files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from forest_bag.read.bag_reader import LARGEST_METADATA, BagReader
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.metadata import FileEntry, OfferedTopic, information, recorded_losses, write_metadata
from forest_bag.storage.raw_messages import BagFile, Channel
from forest_msgs_py.interfaces.qos_profiles import in_words
from forest_msgs_py.interfaces.yaml_text import parsed

ZSTD = b"\x28\xb5\x2f\xfd"  # what a message that was compressed by itself begins with; CDR begins with 0
IDENTIFIERS = {".mcap": "mcap", ".db3": "sqlite3"}


def reindex(directory: Path) -> dict[str, Any]:
    """Read a bag's files, write its metadata.yaml and return what is in it.

    Custom data comes from the old metadata.yaml or, without one, from the files.

    Raises:
        BagError: this is no directory of one kind of bag files, or one of them is damaged.
        OSError: it cannot be read or written.
    """
    if not directory.is_dir():
        raise BagError(f"{directory} is no directory; allowed: a bag's directory")
    with BagReader(directory, by_metadata=False) as reader:
        kinds = {IDENTIFIERS[Path(_plain(file.path)).suffix] for file in reader.files}
        if len(kinds) > 1:
            raise BagError(f"{directory} holds {' and '.join(sorted(kinds))}; allowed: files of one kind")
        about = _about(reader, kinds.pop())
    write_metadata(directory, about)
    return about


def _plain(file: Path) -> str:
    return file.name.removesuffix(".zstd")


def _about(reader: BagReader, storage: str) -> dict[str, Any]:
    offers: dict[Channel, OfferedTopic] = {}
    counts: dict[OfferedTopic, int] = {}
    modes: set[str] = set()
    entries = [_entry(file, offers, counts, modes) for file in reader.files]
    custom = _custom_data(reader)
    about = information(entries, counts, recorded_losses({"custom_data": custom}), storage)
    about["custom_data"] = {**custom, **about["custom_data"]}
    mode = "message" if "message" in modes else next(iter(modes), "")
    if mode:
        about |= {"compression_format": "zstd", "compression_mode": mode.upper()}
    return about


def _entry(
    file: BagFile, offers: dict[Channel, OfferedTopic], counts: dict[OfferedTopic, int], modes: set[str]
) -> FileEntry:
    """Count a file's messages; learn its topics, and how it is compressed."""
    if file.path.suffix == ".zstd":
        modes.add("file")
    for channel in file.channels.values():
        if channel not in offers:
            offer = OfferedTopic(
                channel.topic, channel.type, in_words(channel.qos), channel.type_hash, channel.encoding
            )
            counts[offers.setdefault(channel, offer)] = 0
    number, first_ns, last_ns = 0, 0, 0
    for piece in file.pieces:
        for message in file.read(piece):
            counts[offers[message.channel]] += 1
            first_ns = min(first_ns, message.log_ns) if number else message.log_ns
            last_ns = max(last_ns, message.log_ns) if number else message.log_ns
            number += 1
            if message.data[:4] == ZSTD:
                modes.add("message")
    return FileEntry(file.path.name, first_ns, last_ns, number)


def _custom_data(reader: BagReader) -> dict[str, str]:
    """Return the bag's custom data: of its metadata.yaml, else of the last file that tells any."""
    told = [reader.information.get("custom_data")]
    for file in reversed(reader.files):
        told += [_within(values).get("custom_data") for name, values in file.metadata if name == "rosbag2"]
    found = next((custom for custom in told if isinstance(custom, dict) and custom), {})
    return {str(key): str(value) for key, value in found.items()}


def _within(values: Mapping[str, str]) -> dict[str, Any]:
    """Return rosbag2's metadata of one file, which the file itself holds."""
    try:
        tree = parsed(values.get("serialized_metadata", ""), LARGEST_METADATA)
    except yaml.YAMLError:
        return {}
    tree = tree.get("rosbag2_bagfile_information", tree) if isinstance(tree, dict) else {}
    return tree if isinstance(tree, dict) else {}
