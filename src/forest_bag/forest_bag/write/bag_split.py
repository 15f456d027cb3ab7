"""One file of a bag: whole by itself, with types, topics, context, and first what latched topics hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from forest_bag.storage.mcap_file import CHUNK_BYTES, McapFile
from forest_bag.storage.metadata import FileEntry, dump
from forest_msgs_py.interfaces.definitions import message_definition

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


class Recorded:
    """One topic of the bag, as some publishers offer it: a channel in a file, an entry in ``metadata.yaml``.

    Both say the same of them: rosbags leaves out the messages of a channel that has no entry like it.
    """

    def __init__(self, name: str, type_name: str, qos: Sequence[Mapping[str, Any]], type_hash: str) -> None:
        self.name = name
        self.type, self.qos, self.type_hash = type_name, list(qos), type_hash
        self.channel = 0  # in the present file

    def says_all(self, other: Recorded) -> bool:
        """Whether this one's channel tells what there is to tell of the other, too."""
        same = self.type_hash == other.type_hash
        return same and all(profile in self.qos for profile in other.qos)


class Split:
    """A file that knows its topics.

    Args:
        path: to be made.
        layout: of the bag.

    Raises:
        OSError: it cannot be made; nothing is left of it.
    """

    def __init__(self, path: Path, layout: Layout) -> None:
        self.empty = True
        self._path = path
        self._schemas: dict[str, int] = {}
        self._topics: dict[int, Recorded] = {}  # by channel
        try:
            self.file = McapFile(path, layout.compression, layout.chunk_bytes, layout.durable, LIBRARY)
        except FileExistsError:
            raise
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def open_channel(self, topic: Recorded) -> bool:
        """Open a channel for a topic; False if its type's definition is not installed."""
        known = True
        if topic.type not in self._schemas:
            try:
                text, encoding = message_definition(topic.type), "ros2msg"
            except FileNotFoundError:
                text, encoding, known = "", "", False
            self._schemas[topic.type] = self.file.add_schema(topic.type, encoding, text.encode())
        metadata = {"offered_qos_profiles": dump(topic.qos), "topic_type_hash": topic.type_hash}
        topic.channel = self.file.add_channel(topic.name, self._schemas[topic.type], metadata)
        self._topics[topic.channel] = topic
        return known

    def tell(self, name: str, told: Attached | dict[str, str]) -> None:
        """Write an attachment or a metadata record."""
        if isinstance(told, Attached):
            self.file.attach(*told)
        else:
            self.file.note(name, told)

    def counts(self) -> dict[Recorded, int]:
        """Return the number of messages written, by topic."""
        return {topic: self.file.counts[channel] for channel, topic in self._topics.items()}

    def entry(self) -> FileEntry:
        """Return what ``metadata.yaml`` says of the file."""
        return FileEntry(self._path.name, self.file.first_ns, self.file.last_ns, self.file.message_count)

    def finish(self, about: Callable[[FileEntry, dict[Recorded, int]], dict[str, Any]]) -> None:
        """Finish the file, with rosbag2's metadata of it in it.

        Raises:
            OSError: the disk is full; the file is closed all the same.
        """

        def say_about() -> None:
            text = dump(about(self.entry(), self.counts()))
            self.file.note("rosbag2", {"serialized_metadata": text})

        self.file.finish(say_about)
