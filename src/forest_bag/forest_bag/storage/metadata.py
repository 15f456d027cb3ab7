"""``metadata.yaml`` of a bag as rosbag2 of Jazzy writes it (version 9), key by key in its order."""

from __future__ import annotations

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


class TopicEntry(NamedTuple):
    """One topic: type, what each publisher offers with rosbag2's keys, type hash, number of messages."""

    name: str
    type: str
    qos: Sequence[Mapping[str, Any]]
    type_hash: str
    messages: int


def information(
    files: Sequence[FileEntry], topics: Sequence[TopicEntry], lost: Mapping[str, int]
) -> dict[str, Any]:
    """Return what stands below ``rosbag2_bagfile_information``.

    Args:
        files: in the order in which they were written.
        topics: of all files together.
        lost: number of lost messages by topic.
    """
    custom = {LOST: str(sum(lost.values()))}
    custom.update({f"{LOST}:{name}": str(count) for name, count in lost.items()})
    return {
        "version": METADATA_VERSION,
        "storage_identifier": "mcap",
        **_span(files),
        "topics_with_message_count": [_topic(topic) for topic in topics],
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


def _topic(topic: TopicEntry) -> dict[str, Any]:
    metadata = {
        "name": topic.name,
        "type": topic.type,
        "serialization_format": "cdr",
        "offered_qos_profiles": [dict(profile) for profile in topic.qos],
        "type_description_hash": topic.type_hash,
    }
    return {"topic_metadata": metadata, "message_count": topic.messages}


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
