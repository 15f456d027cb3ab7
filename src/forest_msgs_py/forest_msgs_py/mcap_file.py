"""One MCAP file, readable at every instant: what was flushed survives a kill, a full disk, a power cut.

=============  =============================================================================================
symbol         meaning
=============  =============================================================================================
log time       when a recorder received a message, ns
publish time   when its publisher sent it, ns
sequence       the publisher's count of its messages
chunk          messages that are compressed and written together; its index says where each of them is
record         what an MCAP file consists of: opcode (1 byte), length (8 bytes), content
=============  =============================================================================================

Why not mcap's own writer: it builds an object for each message, keeps 2 kB of objects for each chunk, and
after a failed write the middle of a record stays behind. Here every write is whole records or is taken back.
Schemas and channels stand between the chunks, so that a topic without messages is in the file, too. The bytes
for the summary are kept free on the disk: a file on a full disk still gets one.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import lz4.frame
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from forest_msgs_py.append_file import AppendFile

MAGIC = b"\x89MCAP0\r\n"
CHUNK_BYTES = 64 * 1024
RESERVE_BYTES = 16 * 1024  # kept free for the summary, besides definitions and the index of chunks
ENDING_BYTES = 1024  # statistics, offsets and footer
COMPRESSIONS = ("none", "lz4", "zstd")
ZSTD_LEVEL = 1  # half the processor time of level 3 for 5 % more bytes

_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_FIELDS = _MESSAGE.size - 9
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


class McapFile:
    """Writes one file.

    Args:
        path: to be made.
        compression: of the chunks: none, lz4 or zstd.
        chunk_bytes: after so many bytes a chunk is written without waiting for `flush`.
        durable: force every flush to the disk itself, in a thread beside: power may fail.

    Raises:
        OSError: the file exists, or cannot be made.
    """

    def __init__(
        self,
        path: Path,
        compression: str = "zstd",
        chunk_bytes: int = CHUNK_BYTES,
        durable: bool = False,
        library: str = "forest_msgs_py",
    ) -> None:
        self.counts: dict[int, int] = {}  # messages written, by channel
        self.chunks = 0
        self.first_ns, self.last_ns = 0, 0  # log times of what is written
        self._compress = compressor(compression)
        self._compression = b"" if compression == "none" else compression.encode()
        self._chunk_bytes = chunk_bytes
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._attachments: list[AttachmentIndex] = []
        self._notes: list[MetadataIndex] = []
        self._chunk_index = bytearray()
        self._defined = 0
        self._begin_chunk()
        self._file = AppendFile(path, durable)
        self._file.append(MAGIC + _encoded(Header("ros2", library)))

    @property
    def finished(self) -> bool:
        """Whether `finish` was called."""
        return self._file.closed

    @property
    def size(self) -> int:
        """Bytes of the file if it ended now, or a little less; the open chunk is not compressed yet."""
        indexes = len(self._chunk_index) + 8 * len(self._parts) + ENDING_BYTES
        return self._file.size + self._pending + indexes + self._defined

    @property
    def message_count(self) -> int:
        """Messages written; those of the open chunk are not."""
        return sum(self.counts.values())

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Write a message type's definition; return its number."""
        schema = Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name)
        self._define(schema)
        self._schemas.append(schema)
        return schema.id

    def add_channel(self, topic: str, schema: int, metadata: Mapping[str, str], encoding: str = "cdr") -> int:
        """Write a channel, a topic as one set of publishers speaks on it; return its number."""
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding=encoding,
            metadata=dict(metadata),
            schema_id=schema,
        )
        self._define(channel)
        self._channels.append(channel)
        self.counts[channel.id] = 0
        return channel.id

    def add_message(self, channel: int, log_ns: int, data: bytes, publish_ns: int, sequence: int) -> None:
        """Put a message into the open chunk.

        Raises:
            OSError: the chunk was full, and so is the disk.
        """
        entries = self._entries.get(channel)
        if entries is None:
            self._entries[channel] = entries = []
        entries.append(log_ns)
        entries.append(self._pending)
        length = _MESSAGE_FIELDS + len(data)
        self._parts.append(
            _MESSAGE.pack(Opcode.MESSAGE, length, channel, sequence & 0xFFFFFFFF, log_ns, publish_ns)
        )
        self._parts.append(data)
        self._pending += 9 + length
        if self._pending >= self._chunk_bytes:
            self._write_chunk()

    def attach(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Write an attachment, a file within the file."""
        record = _encoded(Attachment(time_ns, time_ns, name, media_type, data))
        index = AttachmentIndex(self._file.size, len(record), time_ns, time_ns, len(data), name, media_type)
        self._file.append(record)
        self._attachments.append(index)

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Write a metadata record."""
        record = _encoded(Metadata(name, dict(values)))
        index = MetadataIndex(self._file.size, len(record), name)
        self._file.append(record)
        self._notes.append(index)

    def flush(self) -> None:
        """Finish the open chunk and hand it to the operating system: from here on a kill cannot take it.

        Raises:
            OSError: the disk is full, or broken.
        """
        self._write_chunk()
        self._file.sync_soon()

    def finish(self, about: Callable[[], None] = lambda: None) -> None:
        """Write summary and footer, force the file to the disk and close it; a second call does nothing.

        Args:
            about: called when every message is written, for a last `note`.

        Raises:
            OSError: the disk is full; what was written whole is kept and the file closed all the same.
        """
        if self._file.closed:
            return
        steps = (self._write_chunk, self._file.release, about, self._end, self._file.close)
        errors = [error for step in steps if (error := _refused(step)) is not None]
        if errors:
            raise errors[0]

    def _end(self) -> None:
        try:
            self._file.append(self._ending())
        except OSError:
            self._file.append(_encoded(DataEnd(0)) + _encoded(Footer(0, 0, 0)) + MAGIC)

    def _define(self, record: McapRecord) -> None:
        data = _encoded(record)
        self._file.append(data)
        self._defined += 2 * len(data)  # the summary repeats it, and `metadata.yaml` says much the same

    def _begin_chunk(self) -> None:
        self._parts: list[bytes] = []
        self._entries: dict[int, list[int]] = {}  # log time and place of each message, by channel
        self._pending = 0

    def _write_chunk(self) -> None:
        """Write the open chunk and the index of its messages, both or neither."""
        if not self._parts:
            return
        raw, entries = b"".join(self._parts), self._entries
        self._begin_chunk()  # whatever happens: what a full disk refused is not offered again
        first = min(min(e[::2]) for e in entries.values())
        last = max(max(e[::2]) for e in entries.values())
        data = self._compress(raw)
        head = struct.pack("<QQQI", first, last, len(raw), zlib.crc32(raw))
        head += _text(self._compression) + struct.pack("<Q", len(data))
        chunk = struct.pack("<BQ", Opcode.CHUNK, len(head) + len(data)) + head + data
        start = self._file.size
        places, indexes = _message_indexes(entries, start + len(chunk))
        index = struct.pack("<QQQQ", first, last, start, len(chunk)) + struct.pack("<I", len(places))
        index += places + struct.pack("<Q", len(indexes)) + _text(self._compression)
        index += struct.pack("<QQ", len(data), len(raw))
        self._file.keep_free(RESERVE_BYTES + self._defined + len(self._chunk_index) + len(index))
        self._file.append(chunk + indexes)
        self._chunk_index += struct.pack("<BQ", Opcode.CHUNK_INDEX, len(index)) + index
        self.first_ns = min(self.first_ns, first) if self.chunks else first
        self.last_ns = max(self.last_ns, last)
        self.chunks += 1
        for channel, e in entries.items():
            self.counts[channel] += len(e) // 2

    def _ending(self) -> bytes:
        """The end of the data, the summary, and the footer that finds it."""
        data_end = _encoded(DataEnd(0))
        start = self._file.size + len(data_end)
        groups = (
            (Opcode.SCHEMA, b"".join(map(_encoded, self._schemas))),
            (Opcode.CHANNEL, b"".join(map(_encoded, self._channels))),
            (Opcode.STATISTICS, _encoded(self._statistics())),
            (Opcode.CHUNK_INDEX, bytes(self._chunk_index)),
            (Opcode.ATTACHMENT_INDEX, b"".join(map(_encoded, self._attachments))),
            (Opcode.METADATA_INDEX, b"".join(map(_encoded, self._notes))),
        )
        summary, offsets = b"", b""
        for opcode, records in groups:
            if records:
                offsets += _encoded(SummaryOffset(opcode, start + len(summary), len(records)))
                summary += records
        offset_start = start + len(summary)
        summary += offsets
        seen = summary + struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start)
        return data_end + summary + _encoded(Footer(start, offset_start, zlib.crc32(seen))) + MAGIC

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=dict(self.counts),
            chunk_count=self.chunks,
            message_count=self.message_count,
            metadata_count=len(self._notes),
            message_start_time=self.first_ns,
            message_end_time=self.last_ns,
            schema_count=len(self._schemas),
        )


def _message_indexes(entries: Mapping[int, list[int]], start: int) -> tuple[bytes, bytes]:
    """The records that say where a chunk's messages are, and where in the file each of these begins."""
    places, records = b"", b""
    for channel, entry in entries.items():
        places += struct.pack("<HQ", channel, start + len(records))
        size = 8 * len(entry)
        records += _INDEX.pack(Opcode.MESSAGE_INDEX, size + 6, channel, size)
        records += struct.pack(f"<{len(entry)}Q", *entry)
    return places, records


def _refused(step: Callable[[], None]) -> OSError | None:
    try:
        step()
    except OSError as error:
        return error
    return None


def _text(value: bytes) -> bytes:
    return struct.pack("<I", len(value)) + value


def _encoded(record: McapRecord) -> bytes:
    builder: Any = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
