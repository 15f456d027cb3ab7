"""An MCAP file as pieces of messages that can be read in any order.

===========  ===============================================================================================
symbol       meaning
===========  ===============================================================================================
log time     when the recorder received a message, ns
piece        messages that lie together: a chunk of an MCAP file, or some thousand loose messages
complete     the file ends as a finished file does, and everything in it could be read
===========  ===============================================================================================

Read by record headers rather than through the mcap package's reader: that one needs the summary, orders the
messages of one file only, and spends five times longer on each. No ROS in here.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel as ChannelRecord
from mcap.records import Chunk, Metadata, Schema, Statistics

from forest_bag.storage.bag_files import BagError
from forest_bag.storage.mcap_records import HEAD, MAGIC, MESSAGE, attachment, chunk_records
from forest_bag.storage.raw_messages import Channel, Damaged, Piece, RawMessage, full_type

LOOSE_BYTES = 1 << 20  # of loose messages make one piece
_SPAN = struct.Struct("<QQ")  # of a chunk: first and last log time; of an index: offset and length
_FOOTER = struct.Struct("<QQI")  # start of the summary, of its offsets, checksum
_CHECKSUM = struct.Struct("<I")
_DATA_END = struct.Struct("<BQI")  # opcode, length, checksum of the data section
_CHUNK_INDEX = struct.Struct("<QQQQI")  # first and last log time, offset, length, bytes of channels
_CHANNEL_PLACE = struct.Struct("<HQ")


class McapPieces:
    """An MCAP file: chunks or loose messages, with or without index, finished or cut off."""

    def __init__(self, path: Path, plain: Path) -> None:
        """Open a file and find its pieces.

        Args:
            path: of the bag's file, by which it is named.
            plain: where it lies decompressed; the same if it is not compressed.

        Raises:
            BagError: it is not an MCAP file, or less than the start of one.
            OSError: it cannot be read.
        """
        self.path = path
        self.channels: dict[int, Channel] = {}
        self.pieces: list[Piece] = []
        self.problems: list[str] = []
        self.notes: list[str] = []
        self.attachments: list[tuple[str, bytes]] = []
        self.metadata: list[tuple[str, dict[str, str]]] = []
        self._counts: dict[int, int] | None = None  # by channel; None: nobody counted
        self._schemas: dict[int, Schema] = {}
        self._sets: dict[frozenset[int], frozenset[int]] = {}  # equal ones are one: chunks are many
        with plain.open("rb") as stream:
            start = stream.read(len(MAGIC))
            if start != MAGIC:
                if MAGIC.startswith(start):
                    raise Damaged(f"{path} is cut off: it holds {len(start)} bytes")
                raise BagError(f"{path} is not an MCAP file: it does not begin with MCAP's magic bytes")
            self._bytes = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
            self.complete = self._bytes[-len(MAGIC) :] == MAGIC and len(self._bytes) > 2 * len(MAGIC)
            if not (self.complete and self._use_index()):
                self._scan()
        if not self.complete and not self.problems:
            self.problems.append("it has no end: the recorder was killed, or is still at work")

    def close(self) -> None:
        """Let go of the file."""
        self._bytes.close()

    def read(self, piece: Piece) -> list[RawMessage]:
        """Read the messages of a piece, in the file's order.

        Raises:
            Damaged: its bytes are not what was written.
        """
        data = self._bytes[piece.offset : piece.offset + piece.length]
        try:
            if data[0] == Opcode.CHUNK:
                data = _unpacked(data)
            return self._walk(data)
        except _BROKEN as error:
            raise Damaged(f"{self.path} is damaged at byte {piece.offset}: {error}") from error

    def check(self) -> None:
        """Test all checksums; what has none is tested for its structure.

        Raises:
            Damaged: the file is not what was written.
        """
        for piece in self.pieces:
            data = self._bytes[piece.offset : piece.offset + piece.length]
            try:
                self._check(piece, data)
            except _BROKEN as error:
                raise Damaged(f"{self.path} is damaged at byte {piece.offset}: {error}") from error
        self._check_data_section()

    def _check(self, piece: Piece, data: bytes) -> None:
        for channel in piece.channels or ():
            if channel not in self.channels:
                raise ValueError(f"a message names channel {channel}, which nothing declares")
        if data[0] != Opcode.CHUNK:
            self._walk(data)
            return
        chunk = Chunk.read(ReadDataStream(BytesIO(data[HEAD.size :])))
        records = chunk_records(chunk)
        if not chunk.uncompressed_crc:
            self._walk(records)

    def _check_data_section(self) -> None:
        """Test its checksum, which few writers keep: all that loose messages may have."""
        footer = len(self._bytes) - len(MAGIC) - HEAD.size - _FOOTER.size
        if not self.complete or footer < len(MAGIC) + _DATA_END.size:
            return
        end = (_FOOTER.unpack_from(self._bytes, footer + HEAD.size)[0] or footer) - _DATA_END.size
        opcode, _, checksum = _DATA_END.unpack_from(self._bytes, max(end, 0))
        with memoryview(self._bytes) as data:
            if opcode == Opcode.DATA_END and checksum not in (0, zlib.crc32(data[:end])):
                raise Damaged(f"{self.path} is damaged: the checksum of its data section is wrong")

    def _use_index(self) -> bool:
        """Take channels and chunks from the summary; False where it does not suffice."""
        try:
            footer = len(self._bytes) - len(MAGIC) - HEAD.size - _FOOTER.size
            opcode, _ = HEAD.unpack_from(self._bytes, footer)
            start, _, checksum = _FOOTER.unpack_from(self._bytes, footer + HEAD.size)
            if opcode != Opcode.FOOTER or start > footer:
                raise ValueError("no footer")
            covered = self._bytes[start or footer : -len(MAGIC) - _CHECKSUM.size]
            if checksum not in (0, zlib.crc32(covered)):
                raise ValueError("the summary's checksum is wrong")
            summary = self._bytes[start:footer] if start else b""
            for opcode, offset, end in _records(summary, 0):
                self._take_summary(opcode, summary[offset + HEAD.size : end])
        except _BROKEN:
            self.complete = False
            self.problems.append("its index is damaged")
            return False
        return (
            self._counts is not None
            and bool(self.channels)
            and (bool(self.pieces) or not any(self._counts.values()))
        )

    def _take_summary(self, opcode: int, body: bytes) -> None:
        if opcode == Opcode.CHUNK_INDEX:
            first, last, offset, length, size = _CHUNK_INDEX.unpack_from(body)
            places = body[_CHUNK_INDEX.size : _CHUNK_INDEX.size + size]
            found = frozenset(number for number, _ in _CHANNEL_PLACE.iter_unpack(places))
            if found or last:  # else there are nothing but schemas in it
                self.pieces.append(
                    Piece(
                        first_ns=first,
                        last_ns=last,
                        offset=offset,
                        length=length,
                        channels=self._sets.setdefault(found, found) or None,
                    )
                )
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            self._declare(opcode, body)
        elif opcode == Opcode.STATISTICS:
            statistics = Statistics.read(ReadDataStream(BytesIO(body)))
            self._counts = statistics.channel_message_counts
        elif opcode in (Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX):
            offset, length = _SPAN.unpack_from(body)
            record, _ = HEAD.unpack_from(self._bytes, offset)
            self._take(record, offset, offset + length)

    def _scan(self) -> None:
        """Find channels and pieces by going through the file, as far as it is whole."""
        self.pieces, self._counts, self.channels, self._schemas = [], None, {}, {}
        self.attachments, self.metadata = [], []
        loose: list[int] = []  # first and last log time, offset
        end = 0
        try:
            for opcode, offset, end in _records(self._bytes, len(MAGIC)):
                if opcode == Opcode.MESSAGE:
                    log_ns = MESSAGE.unpack_from(self._bytes, offset + HEAD.size)[2]
                    loose = loose or [log_ns, log_ns, offset]
                    loose[:2] = [min(loose[0], log_ns), max(loose[1], log_ns)]
                if loose and (opcode != Opcode.MESSAGE or end - loose[2] > LOOSE_BYTES):
                    stop = end if opcode == Opcode.MESSAGE else offset
                    self.pieces.append(Piece(loose[0], loose[1], loose[2], stop - loose[2]))
                    loose = []
                if opcode != Opcode.MESSAGE and not self._take(opcode, offset, end):
                    return
        except ValueError as error:
            self.problems.append(str(error))
        if loose:
            self.pieces.append(Piece(loose[0], loose[1], loose[2], end - loose[2]))
        self.complete = False

    def _take(self, opcode: int, offset: int, end: int) -> bool:
        """Look at one record outside of chunks; False behind the last that holds data."""
        body = self._bytes[offset + HEAD.size : end]
        try:
            if opcode == Opcode.CHUNK:
                if self._walk(_unpacked(self._bytes[offset:end])):
                    first_ns, last_ns = _SPAN.unpack_from(body)
                    self.pieces.append(Piece(first_ns, last_ns, offset, end - offset))
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._declare(opcode, body)
            elif opcode == Opcode.ATTACHMENT:
                found = attachment(body)
                self.attachments.append((found.name, found.data))
            elif opcode == Opcode.METADATA:
                metadata = Metadata.read(ReadDataStream(BytesIO(body)))
                self.metadata.append((metadata.name, metadata.metadata))
        except _BROKEN as error:
            self.complete = False
            self.problems.append(f"a record at byte {offset} is damaged: {error}")
        return opcode != Opcode.DATA_END

    def _walk(self, data: bytes) -> list[RawMessage]:
        """Messages in a run of records; channels on the way are learned."""
        found, end = [], 0
        try:
            for opcode, offset, end in _records(data, 0):
                if opcode == Opcode.MESSAGE:
                    channel, sequence, log_ns, publish_ns = MESSAGE.unpack_from(data, offset + HEAD.size)
                    body = data[offset + HEAD.size + MESSAGE.size : end]
                    found.append(RawMessage(log_ns, publish_ns, sequence, self.channels[channel], body))
                elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    self._declare(opcode, data[offset + HEAD.size : end])
        except KeyError as error:
            raise ValueError(f"a message names channel {error}, which nothing declares") from error
        if end != len(data):
            raise ValueError(f"what begins at its byte {end} is no record")
        return found

    def _declare(self, opcode: int, body: bytes) -> None:
        stream = ReadDataStream(BytesIO(body))
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            self._schemas[schema.id] = schema
        else:
            self._meet(ChannelRecord.read(stream))

    def _meet(self, record: ChannelRecord) -> None:
        if record.id in self.channels:
            return
        schema = self._schemas.get(record.schema_id)
        name, text = ("", b"") if schema is None else (schema.name, schema.data)
        self.channels[record.id] = Channel(
            topic=record.topic,
            type=full_type(name, record.message_encoding),
            encoding=record.message_encoding,
            qos=record.metadata.get("offered_qos_profiles", ""),
            type_hash=record.metadata.get("topic_type_hash", ""),
            definition=text.decode("utf-8", "replace"),
        )


# What the layers below raise over bytes that make no sense.
_BROKEN = (McapError, struct.error, ValueError, KeyError, EOFError)


def _records(data: Any, start: int) -> Iterator[tuple[int, int, int]]:
    """Opcode, offset and end of every whole record.

    Raises:
        ValueError: a message's record is too short for one.
    """
    while start + HEAD.size <= len(data):
        opcode, length = HEAD.unpack_from(data, start)
        end = start + HEAD.size + length
        if end > len(data) or opcode == 0:
            return
        if opcode == Opcode.MESSAGE and length < MESSAGE.size:
            raise ValueError(f"the message at byte {start} has a length of {length} bytes")
        yield opcode, start, end
        start = end


def _unpacked(data: bytes) -> bytes:
    """The records inside a chunk's record."""
    return chunk_records(Chunk.read(ReadDataStream(BytesIO(data[HEAD.size :]))))
