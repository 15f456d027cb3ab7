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

import mmap
import struct
import zlib
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Channel as ChannelRecord
from mcap.records import Schema

from forest_bag.storage.mcap_records import (
    BROKEN,
    HEAD,
    MAGIC,
    MESSAGE,
    chunk_records,
    footer,
    parsed,
    records,
    whole_records,
)
from forest_bag.storage.raw_messages import (
    Attachment,
    BagFile,
    Channel,
    Damaged,
    Piece,
    RawMessage,
    full_type,
)

LOOSE_BYTES = 1 << 20  # of loose messages make one piece
_SPAN = struct.Struct("<QQ")  # of a chunk: first and last log time; of an index: offset and length
_CHECKSUM = struct.Struct("<I")
_DATA_END = struct.Struct("<BQI")  # opcode, length, checksum of the data section
_CHUNK_INDEX = struct.Struct("<QQQQI")  # first and last log time, offset, length, bytes of channels
_CHANNEL_PLACE = struct.Struct("<HQ")


class McapPieces(BagFile):
    """An MCAP file: chunks or loose messages, with or without index, finished or cut off."""

    def __init__(self, path: Path, plain: Path) -> None:
        """Open a file and find its pieces; arguments and errors as `BagFile`."""
        super().__init__(path, plain, MAGIC, ("an MCAP file", "MCAP"))
        self._counts: dict[int, int] | None = None  # by channel; None: nobody counted
        self._schemas: dict[int, Schema] = {}
        self._sets: dict[frozenset[int], frozenset[int]] = {}  # equal ones are one: chunks are many
        with plain.open("rb") as stream:
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
        """Read the messages of a piece; see `BagFile`."""
        data = self._bytes[piece.offset : piece.offset + piece.length]
        try:
            if data[0] == Opcode.CHUNK:
                data = chunk_records(parsed(Opcode.CHUNK, data[HEAD.size :]))
            return self._walk(data)
        except BROKEN as error:
            raise Damaged(f"{self.path} is damaged at byte {piece.offset}: {error}") from error

    def check(self) -> None:
        """Test all checksums; what has none is tested for its structure."""
        for piece in self.pieces:
            data = self._bytes[piece.offset : piece.offset + piece.length]
            try:
                self._check(piece, data)
            except BROKEN as error:
                raise Damaged(f"{self.path} is damaged at byte {piece.offset}: {error}") from error
        self._check_data_section()

    def _check(self, piece: Piece, data: bytes) -> None:
        for channel in piece.channels or ():
            if channel not in self.channels:
                raise ValueError(f"a message names channel {channel}, which nothing declares")
        if data[0] != Opcode.CHUNK:
            self._walk(data)
            return
        chunk = parsed(Opcode.CHUNK, data[HEAD.size :])
        content = chunk_records(chunk)
        if not chunk.uncompressed_crc:
            self._walk(content)

    def _check_data_section(self) -> None:
        """Test its checksum, which few writers keep: all that loose messages may have."""
        if not self.complete:
            return
        end = max(footer(self._bytes)[1] - _DATA_END.size, 0)
        opcode, _, checksum = _DATA_END.unpack_from(self._bytes, end)
        with memoryview(self._bytes) as data:
            if opcode == Opcode.DATA_END and checksum not in (0, zlib.crc32(data[:end])):
                raise Damaged(f"{self.path} is damaged: the checksum of its data section is wrong")

    def _use_index(self) -> bool:
        """Take channels and chunks from the summary; False where it does not suffice."""
        try:
            stop, start, checksum = footer(self._bytes)
            covered = self._bytes[start : -len(MAGIC) - _CHECKSUM.size]
            if checksum not in (0, zlib.crc32(covered)):
                raise ValueError("the summary's checksum is wrong")
            for opcode, begin, end in records(self._bytes, start, stop):
                self._take_summary(opcode, self._bytes[begin:end])
        except BROKEN:
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
            self._counts = parsed(opcode, body).channel_message_counts
        elif opcode in (Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX):
            offset, length = _SPAN.unpack_from(body)
            record, _ = HEAD.unpack_from(self._bytes, offset)
            self._take(record, offset + HEAD.size, offset + length)

    def _scan(self) -> None:
        """Find channels and pieces by going through the file, as far as it is whole."""
        self.pieces, self._counts, self.channels, self._schemas = [], None, {}, {}
        self.attachments, self.metadata = [], []
        loose: list[int] = []  # first and last log time, offset
        end = 0
        try:
            for opcode, begin, end in records(self._bytes, len(MAGIC)):
                if opcode == Opcode.MESSAGE:
                    log_ns = MESSAGE.unpack_from(self._bytes, begin)[2]
                    loose = loose or [log_ns, log_ns, begin - HEAD.size]
                    loose[:2] = [min(loose[0], log_ns), max(loose[1], log_ns)]
                if loose and (opcode != Opcode.MESSAGE or end - loose[2] > LOOSE_BYTES):
                    stop = end if opcode == Opcode.MESSAGE else begin - HEAD.size
                    self.pieces.append(Piece(loose[0], loose[1], loose[2], stop - loose[2]))
                    loose = []
                if opcode != Opcode.MESSAGE and not self._take(opcode, begin, end):
                    return
        except ValueError as error:
            self.problems.append(str(error))
        if loose:
            self.pieces.append(Piece(loose[0], loose[1], loose[2], end - loose[2]))
        self.complete = False

    def _take(self, opcode: int, begin: int, end: int) -> bool:
        """Look at one record outside of chunks; False behind the last that holds data."""
        offset, body = begin - HEAD.size, self._bytes[begin:end]
        try:
            if opcode == Opcode.CHUNK:
                if messages := self._walk(chunk_records(parsed(opcode, body))):
                    first_ns, last_ns = _SPAN.unpack_from(body)
                    there = self._channels_of(messages)
                    self.pieces.append(Piece(first_ns, last_ns, offset, end - offset, there))
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._declare(opcode, body)
            elif opcode == Opcode.ATTACHMENT:
                found = parsed(opcode, body)
                self.attachments.append(Attachment(found.name, found.data, found.media_type, found.log_time))
            elif opcode == Opcode.METADATA:
                found = parsed(opcode, body)
                self.metadata.append((found.name, found.metadata))
        except BROKEN as error:
            self.complete = False
            self.problems.append(f"a record at byte {offset} is damaged: {error}")
        return opcode != Opcode.DATA_END

    def _walk(self, data: bytes) -> list[RawMessage]:
        """Messages in a run of records; channels on the way are learned."""
        found = []
        try:
            for opcode, begin, end in whole_records(data):
                if opcode == Opcode.MESSAGE:
                    channel, sequence, log_ns, publish_ns = MESSAGE.unpack_from(data, begin)
                    body = data[begin + MESSAGE.size : end]
                    found.append(RawMessage(log_ns, publish_ns, sequence, self.channels[channel], body))
                elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    self._declare(opcode, data[begin:end])
        except KeyError as error:
            raise ValueError(f"a message names channel {error}, which nothing declares") from error
        return found

    def _channels_of(self, messages: list[RawMessage]) -> frozenset[int]:
        """Numbers of the channels that messages name: of a file without an index nobody else tells."""
        met = {id(message.channel) for message in messages}
        found = frozenset(number for number, channel in self.channels.items() if id(channel) in met)
        return self._sets.setdefault(found, found)

    def _declare(self, opcode: int, body: bytes) -> None:
        record = parsed(opcode, body)
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        else:
            self._meet(record)

    def _meet(self, record: ChannelRecord) -> None:
        if record.id in self.channels:
            return
        schema = self._schemas.get(record.schema_id)
        name, form, text = ("", "", b"") if schema is None else (schema.name, schema.encoding, schema.data)
        self.channels[record.id] = Channel(
            topic=record.topic,
            type=full_type(name, record.message_encoding),
            encoding=record.message_encoding,
            qos=record.metadata.get("offered_qos_profiles", ""),
            type_hash=record.metadata.get("topic_type_hash", ""),
            definition=text.decode("utf-8", "replace"),
            definition_format=form,
        )
