"""Recorded messages as bytes, and what the kinds of files that hold them have in common.

============  ==============================================================================================
symbol        meaning
============  ==============================================================================================
log time      when the recorder received a message, ns
publish time  when its publisher sent it, ns
piece         messages that lie together: a chunk of an MCAP file, or some thousand loose messages
complete      the file ends as a finished file does, and everything in it could be read
============  ==============================================================================================
"""

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, NamedTuple

from forest_bag.storage.bag_files import BagError


class Damaged(BagError):
    """A file was cut off, or bytes of it were changed."""


class Channel(NamedTuple):
    """What a file says of one topic; ``qos`` is the YAML text, or the list, that rosbag2 keeps."""

    topic: str
    type: str
    encoding: str = "cdr"
    qos: Any = ""
    type_hash: str = ""
    definition: str = ""
    definition_format: str = ""  # ros2msg or ros2idl


class Attachment(NamedTuple):
    """A file within a file; time in ns."""

    name: str
    data: bytes
    media_type: str = ""
    time_ns: int = 0


class RawMessage(NamedTuple):
    """One recorded message; ``data`` is CDR unless the channel says otherwise."""

    log_ns: int
    publish_ns: int
    sequence: int
    channel: Channel
    data: bytes


class Piece(NamedTuple):
    """Where some messages lie; ``channels`` None: of any channel."""

    first_ns: int
    last_ns: int
    offset: int
    length: int
    channels: frozenset[int] | None = None


class BagFile(ABC):
    """What the two kinds of files have in common.

    Args:
        path: of the bag's file, by which it is named.
        plain: where it lies decompressed; the same if it is not compressed.
        magic: bytes with which a file of the kind begins.
        kind: of the file, and whose magic bytes these are.

    Raises:
        BagError: it begins otherwise.
        OSError: it cannot be read.
    """

    def __init__(self, path: Path, plain: Path, magic: bytes, kind: tuple[str, str]) -> None:
        self.path = path
        self.channels: dict[int, Channel] = {}
        self.pieces: list[Piece] = []
        self.complete = True
        self.problems: list[str] = []
        self.notes: list[str] = []  # what the user should know, although nothing is wrong
        self.attachments: list[Attachment] = []
        self.metadata: list[tuple[str, dict[str, str]]] = []
        with plain.open("rb") as stream:
            start = stream.read(len(magic))
        if start != magic and magic.startswith(start):
            raise Damaged(f"{path} is cut off: it holds {len(start)} bytes")
        if start != magic:
            raise BagError(f"{path} is not {kind[0]}: it does not begin with {kind[1]}'s magic bytes")

    @abstractmethod
    def read(self, piece: Piece) -> list[RawMessage]:
        """Read the messages of a piece, in the file's order.

        Raises:
            Damaged: its bytes are not what was written.
        """

    @abstractmethod
    def check(self) -> None:
        """Test all there is of checksums, and the structure.

        Raises:
            Damaged: the file is not what was written.
        """

    @abstractmethod
    def close(self) -> None:
        """Let go of the file."""


def full_type(name: str, encoding: str) -> str:
    """A ROS 2 type as Dashing's bags name it, ``std_msgs/String``, with the ``msg`` that came later."""
    package, _, kind = name.partition("/")
    return f"{package}/msg/{kind}" if encoding == "cdr" and kind and "/" not in kind else name
