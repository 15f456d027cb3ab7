"""tf2_msgs/TFMessage as bytes: for /tf where tf2_msgs is installed, and for viewers where it is not."""

import struct
from collections.abc import Iterable
from typing import Protocol

from forest_msgs_py.serialization.cdr import ENCAPSULATION
from forest_msgs_py.types import NS_PER_S


class Frame(Protocol):
    """Where frame `child` is in frame `parent`: [m], quaternion x, y, z, w."""

    @property
    def parent(self) -> str:
        """Name of the frame that is known."""

    @property
    def child(self) -> str:
        """Name of the frame that is told."""

    @property
    def translation(self) -> tuple[float, float, float]:
        """Its origin."""

    @property
    def rotation(self) -> tuple[float, float, float, float]:
        """Its orientation."""


def pack_transforms(stamp_ns: int, frames: Iterable[Frame]) -> bytes:
    """A TFMessage; `stamp_ns` is the time of all frames."""
    told = list(frames)
    body = bytearray(struct.pack("<I", len(told)))
    for frame in told:
        _align(body, 4)
        body += struct.pack("<iI", *divmod(stamp_ns, NS_PER_S))
        for name in (frame.parent, frame.child):
            text = name.encode() + b"\0"
            _align(body, 4)
            body += struct.pack("<I", len(text)) + text
        _align(body, 8)
        body += struct.pack("<7d", *frame.translation, *frame.rotation)
    return ENCAPSULATION + bytes(body)


def _align(body: bytearray, size: int) -> None:
    body += bytes(-len(body) % size)
