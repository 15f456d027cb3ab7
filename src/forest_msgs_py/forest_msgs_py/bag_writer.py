"""The bag writer: raw CDR bytes into an MCAP file in a directory shaped as rosbag2 of Jazzy writes it.

===============  ===========================================================================================
symbol           meaning
===============  ===========================================================================================
log time         when a recorder received a message, system time, ns; a simulation: its stamp
publish time     when its publisher sent it (DDS source timestamp), ns
sequence         the publisher's count of its messages; gaps are losses
QoS profile      dict with the keys of rosbag2's metadata version 9
===============  ===========================================================================================

No ROS in here. A killed process leaves every finished chunk behind, so chunks are kept small and are
flushed by the clock. The file is opened buffered: an unbuffered one would lose its footer.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from mcap.writer import CompressionType, Writer

CHUNK_BYTES = 64 * 1024
FLUSH_PERIOD_S = 0.1  # what a killed recorder loses at most
METADATA_VERSION = 9
LIBRARY = "forest_msgs_py bag_writer"
SEPARATOR = "=" * 80

_PRIMITIVES = frozenset(
    (
        *("bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16"),
        *("int32", "uint32", "int64", "uint64", "string", "wstring"),
    )
)
_TYPE = re.compile(r"^\s*([A-Za-z][\w/]*)")


class _Recorded(NamedTuple):
    channel: int
    type: str
    qos: list[dict[str, Any]]
    type_hash: str


def share_directories() -> list[Path]:
    """Where installed packages keep their files: the sourced ROS first, then this Python environment."""
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    return [Path(prefix) / "share" for prefix in prefixes if prefix]


def message_definition(type_name: str) -> str:
    """The text of a message type and of all types in it, in MCAP's ``ros2msg`` form.

    Args:
        type_name: like ``sensor_msgs/msg/JointState``.

    Raises:
        FileNotFoundError: the .msg file of the type, or of one within it, is not installed.
    """
    package, _, name = type_name.split("/")
    texts: dict[tuple[str, str], str] = {}
    _collect(package, name, texts)
    (_, first), *others = texts.items()
    return "\n".join([first, *(f"{SEPARATOR}\nMSG: {pkg}/{typ}\n{text}" for (pkg, typ), text in others)])


def _collect(package: str, name: str, texts: dict[tuple[str, str], str]) -> None:
    if (package, name) in texts:
        return
    texts[package, name] = text = _message_text(package, name)
    for line in text.splitlines():
        match = _TYPE.match(line.split("#")[0])
        if match and match[1] not in _PRIMITIVES:
            *owner, inner = match[1].split("/")
            _collect(owner[0] if owner else package, inner, texts)


def _message_text(package: str, name: str) -> str:
    for share in share_directories():
        file = share / package / "msg" / f"{name}.msg"
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise FileNotFoundError(f"{package}/msg/{name}.msg is in no share directory of this environment")


class BagWriter:
    """Writes one bag: a new directory with ``<name>_0.mcap`` and, once closed, ``metadata.yaml``."""

    def __init__(self, directory: str | Path, chunk_bytes: int = CHUNK_BYTES) -> None:
        """Create the directory and open the file.

        Args:
            directory: to be made.
            chunk_bytes: size of a chunk; what writes for hours without a live reader takes larger ones,
                because the file's index, an entry for each chunk, stays in memory until the end.

        Raises:
            FileExistsError: the directory exists: a record is never overwritten.
            OSError: it cannot be made.
        """
        self.directory = Path(directory).absolute()
        try:
            self.directory.mkdir(parents=True)
        except FileExistsError:
            raise FileExistsError(f"{directory} exists; allowed: a directory to be made") from None
        self.file_name = f"{self.directory.name}_0.mcap"
        self.counts: dict[str, int] = {}
        self.lost: dict[str, int] = {}
        self._first_ns: int | None = None
        self._last_ns = 0
        self._topics: dict[str, _Recorded] = {}
        self._schemas: dict[str, int] = {}
        self._stream = (self.directory / self.file_name).open("wb")
        self._writer = Writer(self._stream, chunk_size=chunk_bytes, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library=LIBRARY)
        self._stream.flush()

    @property
    def message_count(self) -> int:
        """Messages written so far."""
        return sum(self.counts.values())

    def add_topic(self, name: str, type_name: str, qos: list[dict[str, Any]], type_hash: str) -> bool:
        """Open a channel for a topic.

        Args:
            name: resolved topic name.
            type_name: like ``sensor_msgs/msg/JointState``.
            qos: what each publisher offers, with the keys of rosbag2's metadata.
            type_hash: hash of the type's description, ``RIHS01_...``.

        Returns:
            False if the message definition is not installed; the bytes are kept all the same.
        """
        known = True
        if type_name not in self._schemas:
            try:
                text, encoding = message_definition(type_name), "ros2msg"
            except FileNotFoundError:
                text, encoding, known = "", "", False
            self._schemas[type_name] = self._writer.register_schema(type_name, encoding, text.encode())
        metadata = {
            "offered_qos_profiles": yaml.safe_dump(qos, sort_keys=False),
            "topic_type_hash": type_hash,
        }
        channel = self._writer.register_channel(name, "cdr", self._schemas[type_name], metadata)
        self._topics[name] = _Recorded(channel, type_name, qos, type_hash)
        self.counts[name] = self.lost[name] = 0
        return known

    def write(self, name: str, data: bytes, log_ns: int, publish_ns: int, sequence: int = 0) -> None:
        """Store one message's bytes.

        Raises:
            OSError: the disk is full, or the file cannot be written.
        """
        self._writer.add_message(self._topics[name].channel, log_ns, data, publish_ns, sequence & 0xFFFFFFFF)
        self._first_ns = log_ns if self._first_ns is None else min(self._first_ns, log_ns)
        self._last_ns = max(self._last_ns, log_ns)
        self.counts[name] += 1

    def flush(self) -> None:
        """Finish the open chunk and hand it to the operating system: from here on a kill cannot take it."""
        self._writer.flush()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Finish the file, force it to the disk and write ``metadata.yaml``; a second call does nothing.

        Raises:
            OSError: the disk is full; the file is closed nevertheless.
        """
        if self._stream.closed:
            return
        with contextlib.closing(self._stream):
            information = self._information()
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._writer.add_metadata("rosbag2", {"serialized_metadata": _dump(information)})
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.flush()
            os.fsync(self._stream.fileno())
        text = _dump({"rosbag2_bagfile_information": information})
        (self.directory / "metadata.yaml").write_text(text, encoding="utf-8")

    def _information(self) -> dict[str, Any]:
        """rosbag2's metadata, key by key in its order."""
        first = self._first_ns or 0
        span = {
            "duration": {"nanoseconds": self._last_ns - first},
            "starting_time": {"nanoseconds_since_epoch": first},
            "message_count": self.message_count,
        }
        file = {
            "path": self.file_name,
            "starting_time": span["starting_time"],
            "duration": span["duration"],
            "message_count": span["message_count"],
        }
        lost = {"lost_messages": str(sum(self.lost.values()))}
        lost.update({f"lost_messages:{name}": str(count) for name, count in self.lost.items()})
        return {
            "version": METADATA_VERSION,
            "storage_identifier": "mcap",
            **span,
            "topics_with_message_count": [self._topic_information(name) for name in self._topics],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self.file_name],
            "files": [file],
            "custom_data": lost,
            "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
        }

    def _topic_information(self, name: str) -> dict[str, Any]:
        topic = self._topics[name]
        metadata = {
            "name": name,
            "type": topic.type,
            "serialization_format": "cdr",
            "offered_qos_profiles": topic.qos,
            "type_description_hash": topic.type_hash,
        }
        return {"topic_metadata": metadata, "message_count": self.counts[name]}


class _PlainDumper(yaml.SafeDumper):
    """Anchors and aliases are legal YAML, but rosbag2 writes none."""

    def ignore_aliases(self, _data: Any) -> bool:
        return True


def _dump(value: dict[str, Any]) -> str:
    return str(yaml.dump(value, Dumper=_PlainDumper, sort_keys=False))
