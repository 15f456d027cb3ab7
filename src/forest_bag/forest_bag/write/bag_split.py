"""One file of a bag, readable alone: it begins with types, topics, context and transient-local messages."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from forest_bag.storage.mcap_file import CHUNK_BYTES, McapFile
from forest_bag.storage.metadata import FileEntry, OfferedTopic, dump
from forest_bag.storage.sqlite_file import SqliteFile
from forest_bag.write.transient_local import TransientLocal
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
    storage: str = "mcap"  # rosbag2's name of the files' format
    repeats: bool = True  # each file begins with what transient-local topics hold


ONE_FILE = Layout()


@dataclass
class Contents:
    """What every file of a recording begins with: topics by name, context, transient-local messages."""

    topics: dict[str, OfferedTopic] = field(default_factory=dict)
    context: dict[str, Attached | dict[str, str]] = field(default_factory=dict)
    transient_local: TransientLocal = field(default_factory=TransientLocal)

    def add(self, offer: OfferedTopic) -> bool:
        """Take in a topic, or what a further publisher of it offers; False if that is known already."""
        before = self.topics.get(offer.name)
        self.transient_local.watch(offer.name, offer.qos)
        if before is not None and before.covers(offer):
            return False
        self.topics[offer.name] = offer
        return True


def _new_file(path: Path, layout: Layout) -> McapFile | SqliteFile:
    if layout.storage == "sqlite3":
        return SqliteFile(path)
    return McapFile(path, layout.compression, layout.chunk_bytes, layout.durable, LIBRARY)


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
        self._schemas: dict[tuple[str, tuple[str, str] | None], int] = {}
        self._topics: dict[int, OfferedTopic] = {}  # by channel
        try:
            self.file = _new_file(path, layout)
        except FileExistsError:
            raise
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def open_channel(self, topic: OfferedTopic) -> bool:
        """Open a channel for a topic; False if its type's definition is not installed."""
        known, kind = True, (topic.type, topic.definition)
        if kind not in self._schemas:
            try:
                form, text = topic.definition or ("ros2msg", message_definition(topic.type))
            except FileNotFoundError:
                form, text, known = "", "", False
            self._schemas[kind] = self.file.add_schema(topic.type, form, text.encode())
        metadata = {"offered_qos_profiles": dump(topic.qos), "topic_type_hash": topic.type_hash}
        topic.channel = self.file.add_channel(topic.name, self._schemas[kind], metadata, topic.encoding)
        self._topics[topic.channel] = topic
        return known

    def tell(self, name: str, told: Attached | dict[str, str]) -> None:
        """Write an attachment or a metadata record."""
        if isinstance(told, Attached):
            self.file.attach(*told)
        else:
            self.file.note(name, told)

    def counts(self) -> dict[OfferedTopic, int]:
        """Return the number of messages written, by topic."""
        return {topic: self.file.counts[channel] for channel, topic in self._topics.items()}

    def finish(self, about: Callable[[FileEntry, dict[OfferedTopic, int]], dict[str, Any]]) -> None:
        """Finish the file, with rosbag2's metadata of it in it.

        Raises:
            OSError: the disk is full; the file is closed all the same.
        """
        self.file.finish(lambda: about(self.file.entry, self.counts()))
