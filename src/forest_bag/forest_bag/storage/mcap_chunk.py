"""A chunk of an MCAP file: messages that are compressed and written together, and where each of them is."""

import struct
import zlib
from collections.abc import Callable, Mapping
from typing import NamedTuple

import lz4.frame
import zstandard
from mcap.opcode import Opcode

from forest_bag.storage.mcap_records import HEAD

COMPRESSIONS = ("none", "lz4", "zstd")
ZSTD_LEVEL = 1  # half the processor time of level 3 for 5 % more bytes

_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_FIELDS = _MESSAGE.size - HEAD.size
_INDEX = struct.Struct("<BQHI")


def compressor(name: str) -> Callable[[bytes], bytes]:
    """Return the function that compresses a chunk.

    Raises:
        ValueError: an unknown name.
    """
    if name == "none":
        return lambda data: data
    if name == "lz4":
        return lambda data: bytes(lz4.frame.compress(data))
    if name == "zstd":
        return zstandard.ZstdCompressor(level=ZSTD_LEVEL).compress
    raise ValueError(f"compression {name!r}; allowed: {', '.join(COMPRESSIONS)}")


class Sealed(NamedTuple):
    """A chunk as it is written; log times in ns, counts by channel."""

    records: bytes  # the chunk, and behind it the index of its messages
    entry: bytes  # the record for the file's summary
    first_ns: int
    last_ns: int
    counts: dict[int, int]


class OpenChunk:
    """Collects messages; ``size`` is in bytes before compression, with the index."""

    def __init__(self) -> None:
        self.size = 0
        self._place = 0
        self._parts: list[bytes] = []
        self._entries: dict[int, list[int]] = {}  # log time and place of each message, by channel

    def add(self, channel: int, log_ns: int, data: bytes, publish_ns: int, sequence: int) -> None:
        """Add a message."""
        entries = self._entries.get(channel)
        if entries is None:
            self._entries[channel] = entries = []
        entries.append(log_ns)
        entries.append(self._place)
        length = _MESSAGE_FIELDS + len(data)
        self._parts.append(
            _MESSAGE.pack(Opcode.MESSAGE, length, channel, sequence & 0xFFFFFFFF, log_ns, publish_ns)
        )
        self._parts.append(data)
        self._place += HEAD.size + length
        self.size += HEAD.size + length + 16

    def sealed(self, compression: str, compress: Callable[[bytes], bytes], start: int) -> Sealed:
        """Return the chunk as it is written at a place of the file; it has messages."""
        raw, entries = b"".join(self._parts), self._entries
        first = min(min(e[::2]) for e in entries.values())
        last = max(max(e[::2]) for e in entries.values())
        data, name = compress(raw), _text(b"" if compression == "none" else compression.encode())
        head = struct.pack("<QQQI", first, last, len(raw), zlib.crc32(raw)) + name
        head += struct.pack("<Q", len(data))
        chunk = HEAD.pack(Opcode.CHUNK, len(head) + len(data)) + head + data
        places, indexes = _message_indexes(entries, start + len(chunk))
        index = struct.pack("<QQQQI", first, last, start, len(chunk), len(places)) + places
        index += struct.pack("<Q", len(indexes)) + name + struct.pack("<QQ", len(data), len(raw))
        index = HEAD.pack(Opcode.CHUNK_INDEX, len(index)) + index
        counts = {channel: len(entry) // 2 for channel, entry in entries.items()}
        return Sealed(records=chunk + indexes, entry=index, first_ns=first, last_ns=last, counts=counts)


def _message_indexes(entries: Mapping[int, list[int]], start: int) -> tuple[bytes, bytes]:
    """The records that say where a chunk's messages are, and where in the file each of these begins."""
    places, records = b"", b""
    for channel, entry in entries.items():
        places += struct.pack("<HQ", channel, start + len(records))
        size = 8 * len(entry)
        records += _INDEX.pack(Opcode.MESSAGE_INDEX, size + 6, channel, size)
        records += struct.pack(f"<{len(entry)}Q", *entry)
    return places, records


def _text(value: bytes) -> bytes:
    return struct.pack("<I", len(value)) + value
