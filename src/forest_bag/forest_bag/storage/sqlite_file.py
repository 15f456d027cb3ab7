"""One file of a bag in rosbag2's SQLite format (.db3, schema 4 as of Jazzy), written as an MCAP file is.

The format has no place for publish times, sequence numbers, attachments and notes.
"""

import os
import sqlite3
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from forest_bag.storage.metadata import METADATA_VERSION, FileEntry, dump

SCHEMA_VERSION = 4
ROW_BYTES = 40  # of a message beside its data: numbers, entry of the index; for the size alone
TABLES = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(
    id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL
);
CREATE TABLE topics(
    id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
    offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL
);
CREATE TABLE message_definitions(
    id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
    encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL
);
CREATE TABLE messages(
    id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL
);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""


class SqliteFile:
    """Writes one file, in one transaction; what `McapFile` does, as far as the format has a place for it.

    Args:
        path: to be made.

    Raises:
        OSError: the file exists, or cannot be made.
    """

    chunks = 0

    def __init__(self, path: Path) -> None:
        path.open("xb").close()
        self.counts: dict[int, int] = {}  # messages written, by channel
        self.first_ns, self.last_ns = 0, 0  # log times of what is written
        self.size = 0  # bytes, about
        self.finished = False
        self._path = path
        self._schemas: list[tuple[str, str, str]] = []
        self._database = sqlite3.connect(path, isolation_level=None)
        self._run("BEGIN")
        for statement in TABLES.split(";"):
            self._run(statement)
        self._run("INSERT INTO schema VALUES (?, ?)", SCHEMA_VERSION, os.environ.get("ROS_DISTRO", "jazzy"))

    @property
    def entry(self) -> FileEntry:
        """What ``metadata.yaml`` says of the file."""
        return FileEntry(self._path.name, self.first_ns, self.last_ns, sum(self.counts.values()))

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Take in a message type's definition; return its number."""
        self._schemas.append((name, encoding, data.decode("utf-8", "replace")))
        return len(self._schemas)

    def add_channel(self, topic: str, schema: int, metadata: Mapping[str, str], encoding: str = "cdr") -> int:
        """Write a topic and its type's definition; return its number."""
        name, form, text = self._schemas[schema - 1]
        type_hash, channel = metadata["topic_type_hash"], len(self.counts) + 1
        profiles = metadata["offered_qos_profiles"]
        self._run(
            "INSERT INTO topics VALUES (?, ?, ?, ?, ?, ?)",
            channel,
            topic,
            name,
            encoding,
            profiles,
            type_hash,
        )
        self._run(
            "INSERT INTO message_definitions VALUES (?, ?, ?, ?, ?)", channel, name, form, text, type_hash
        )
        self.counts[channel] = 0
        self.size += len(text) + len(profiles)
        return channel

    def add_message(self, channel: int, log_ns: int, data: bytes, _publish_ns: int, _sequence: int) -> None:
        """Write a message.

        Raises:
            OSError: the disk is full.
        """
        self._run("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", channel, log_ns, data)
        known = any(self.counts.values())
        self.first_ns = min(self.first_ns, log_ns) if known else log_ns
        self.last_ns = max(self.last_ns, log_ns) if known else log_ns
        self.counts[channel] += 1
        self.size += len(data) + ROW_BYTES

    def attach(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Leave a file out: the format has no place for it."""

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Leave a metadata record out: the format has no place for it."""

    def flush(self) -> None:
        """Hand what was written to the operating system.

        Raises:
            OSError: the disk is full.
        """
        self._run("COMMIT")
        self._run("BEGIN")

    def finish(self, information: Callable[[], Mapping[str, Any]] | None = None) -> None:
        """Write rosbag2's metadata, force the file to the disk and close it; a second call does nothing.

        Raises:
            OSError: the disk is full; the file is closed all the same.
        """
        if self.finished:
            return
        self.finished = True
        try:
            if information is not None:
                text = dump(information())
                self._run("INSERT INTO metadata VALUES (1, ?, ?)", METADATA_VERSION, text)
            self._run("COMMIT")
        finally:
            self._database.close()

    def _run(self, statement: str, *values: object) -> None:
        try:
            self._database.execute(statement, values)
        except sqlite3.OperationalError as error:  # a full disk
            raise OSError(f"{self._path}: {error}") from error
