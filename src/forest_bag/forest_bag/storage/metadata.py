"""``metadata.yaml`` of a bag as rosbag2 of Jazzy writes it (version 9), key by key in its order."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml

METADATA_VERSION = 9
METADATA_FILE = "metadata.yaml"
LOST = "lost_messages"  # in custom_data: of all topics, and after a colon of one


class FileEntry(NamedTuple):
    """One file of a bag; times are log times [ns], meaningless while it has no messages."""

    path: str
    first_ns: int
    last_ns: int
    messages: int


class OfferedTopic:
    """A topic as some publishers offer it: a channel in a file, an entry in ``metadata.yaml``.

    Both say the same of them: rosbags leaves out the messages of a channel that has no entry like it.

    Args:
        name: resolved topic name.
        type_name: like ``sensor_msgs/msg/JointState``.
        qos: what each publisher offers, with rosbag2's keys.
        type_hash: of the type's description, ``RIHS01_...``.
        encoding: of the messages.
        definition: format and text of the type; None: as it is installed.
    """

    def __init__(
        self,
        name: str,
        type_name: str,
        qos: Sequence[Mapping[str, Any]],
        type_hash: str,
        encoding: str = "cdr",
        definition: tuple[str, str] | None = None,
    ) -> None:
        self.name = name
        self.type, self.qos, self.type_hash = type_name, list(qos), type_hash
        self.encoding, self.definition = encoding, definition
        self.channel = 0  # in the present file

    def covers(self, other: "OfferedTopic") -> bool:
        """Whether this one's channel tells what there is to tell of the other, too."""
        same = self.type_hash == other.type_hash
        return same and all(profile in self.qos for profile in other.qos)


def information(
    files: Sequence[FileEntry],
    counts: Mapping[OfferedTopic, int],
    lost: Mapping[str, int],
    storage: str = "mcap",
) -> dict[str, Any]:
    """Return what stands below ``rosbag2_bagfile_information``.

    Args:
        files: in the order in which they were written.
        counts: number of messages of each topic in all these files.
        lost: number of lost messages by topic.
        storage: rosbag2's name of the files' format.
    """
    custom = {LOST: str(sum(lost.values()))}
    custom.update({f"{LOST}:{name}": str(count) for name, count in lost.items()})
    return {
        "version": METADATA_VERSION,
        "storage_identifier": storage,
        **_span(files),
        "topics_with_message_count": [_topic(offer, count) for offer, count in counts.items()],
        "compression_format": "",  # MCAP compresses within the file, which needs no word here
        "compression_mode": "",
        "relative_file_paths": [file.path for file in files],
        "files": [_file(file) for file in files],
        "custom_data": custom,
        "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
    }


def _span(files: Sequence[FileEntry]) -> dict[str, Any]:
    filled = [file for file in files if file.messages]
    first = min((file.first_ns for file in filled), default=0)
    last = max((file.last_ns for file in filled), default=0)
    return {
        "duration": {"nanoseconds": last - first},
        "starting_time": {"nanoseconds_since_epoch": first},
        "message_count": sum(file.messages for file in filled),
    }


def _file(file: FileEntry) -> dict[str, Any]:
    span = _span([file])
    keys = ("starting_time", "duration", "message_count")
    return {"path": file.path, **{key: span[key] for key in keys}}


def _topic(offer: OfferedTopic, count: int) -> dict[str, Any]:
    metadata = {
        "name": offer.name,
        "type": offer.type,
        "serialization_format": offer.encoding,
        "offered_qos_profiles": [dict(profile) for profile in offer.qos],
        "type_description_hash": offer.type_hash,
    }
    return {"topic_metadata": metadata, "message_count": count}


def recorded_losses(about: Mapping[str, Any]) -> dict[str, int]:
    """Return the recorder's own counts of lost messages by topic, out of what `information` made.

    Args:
        about: whatever stands in somebody's file; what cannot be understood is left out.
    """
    custom, prefix = about.get("custom_data"), f"{LOST}:"
    told = custom.items() if isinstance(custom, dict) else ()
    return {
        key.removeprefix(prefix): int(count)
        for key, count in told
        if isinstance(key, str) and key.startswith(prefix) and str(count).isdecimal()
    }


def write_metadata(directory: Path, about: dict[str, Any]) -> None:
    """Write the file whole or, should the power fail meanwhile, not at all.

    Raises:
        OSError: the disk is full.
    """
    unfinished = directory / f".{METADATA_FILE}"
    try:
        with unfinished.open("w", encoding="utf-8") as stream:
            stream.write(dump({"rosbag2_bagfile_information": about}))
            stream.flush()
            os.fsync(stream.fileno())
        unfinished.replace(directory / METADATA_FILE)
    except OSError:
        unfinished.unlink(missing_ok=True)
        raise
    sync_directory(directory)


def sync_directory(directory: Path) -> None:
    """Force the names of the files in a directory to the disk; their bytes alone are not found again."""
    descriptor = os.open(directory, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


class _PlainDumper(yaml.SafeDumper):
    """Anchors and aliases are legal YAML, but rosbag2 writes none."""

    def ignore_aliases(self, _data: Any) -> bool:
        return True


def dump(value: Any) -> str:
    """Return YAML text without anchors, keys in their order."""
    return str(yaml.dump(value, Dumper=_PlainDumper, sort_keys=False))
