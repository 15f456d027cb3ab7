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

Kept beside mcap's own writer for crash safety: after a failed write of that one, half a record stays behind.
Here every write is whole records or is taken back. It also builds no object for each message, and keeps less
than the 2 kB of objects for each chunk.
Schemas and channels stand between the chunks, so that a topic without messages is in the file, too. The bytes
for the summary are kept free on the disk: a file on a full disk still gets one.
"""

import struct
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

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

from forest_bag.storage.append_file import AppendFile
from forest_bag.storage.mcap_chunk import OpenChunk, compressor
from forest_bag.storage.mcap_records import MAGIC
from forest_bag.storage.metadata import FileEntry, dump

CHUNK_BYTES = 64 * 1024
RESERVE_BYTES = 16 * 1024  # kept free for the summary, besides definitions and the index of chunks
ENDING_BYTES = 1024  # statistics, offsets and footer


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
        self._compression = compression
        self._chunk_bytes = chunk_bytes
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._attachments: list[AttachmentIndex] = []
        self._notes: list[MetadataIndex] = []
        self._chunk_index = bytearray()
        self._defined = 0
        self._chunk = OpenChunk()
        self._path, self._file = path, AppendFile(path, durable)
        self._file.append(MAGIC + _encoded(Header("ros2", library)))

    @property
    def finished(self) -> bool:
        """Whether `finish` was called."""
        return self._file.closed

    @property
    def size(self) -> int:
        """Bytes of the file if it ended now, or a little less; the open chunk is not compressed yet."""
        if self.finished:
            return self._file.size
        indexes = len(self._chunk_index) + ENDING_BYTES
        return self._file.size + self._chunk.size + indexes + self._defined

    @property
    def message_count(self) -> int:
        """Messages written; those of the open chunk are not."""
        return sum(self.counts.values())

    @property
    def entry(self) -> FileEntry:
        """What ``metadata.yaml`` says of the file."""
        return FileEntry(self._path.name, self.first_ns, self.last_ns, self.message_count)

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
        self._chunk.add(channel, log_ns, data, publish_ns, sequence)
        if self._chunk.size >= self._chunk_bytes:
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

    def finish(self, information: Callable[[], Mapping[str, Any]] | None = None) -> None:
        """Write summary and footer, force the file to the disk and close it; a second call does nothing.

        Args:
            information: rosbag2's metadata of the file, asked for when every message is written.

        Raises:
            OSError: the disk is full; what was written whole is kept and the file closed all the same.
        """
        if self._file.closed:
            return

        def write_information() -> None:
            if information is not None:
                self.note("rosbag2", {"serialized_metadata": dump(information())})

        steps = (self._write_chunk, self._file.release, write_information, self._end, self._file.close)
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

    def _write_chunk(self) -> None:
        """Write the open chunk and the index of its messages, both or neither."""
        if not self._chunk.size:
            return
        sealed = self._chunk.sealed(self._compression, self._compress, self._file.size)
        self._chunk = OpenChunk()  # whatever happens: what a full disk refuses is not offered again
        self._file.keep_free(RESERVE_BYTES + self._defined + len(self._chunk_index) + len(sealed.entry))
        self._file.append(sealed.records)
        self._chunk_index += sealed.entry
        self.first_ns = min(self.first_ns, sealed.first_ns) if self.chunks else sealed.first_ns
        self.last_ns = max(self.last_ns, sealed.last_ns)
        self.chunks += 1
        for channel, count in sealed.counts.items():
            self.counts[channel] += count

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


def _refused(step: Callable[[], None]) -> OSError | None:
    try:
        step()
    except OSError as error:
        return error
    return None


def _encoded(record: McapRecord) -> bytes:
    builder: Any = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
