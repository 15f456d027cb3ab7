"""What is readable in an MCAP file that was cut off, or damaged in the middle: every whole record.

A reader that stops at the first thing it does not understand gives up everything behind it. Here the search
goes on for the next record that is whole: a chunk by its checksum, the others by lengths that agree.
"""

from __future__ import annotations

import mmap
import re
import struct
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, McapRecord, Message, Metadata, Schema

from forest_bag.storage.bag_files import BagError, bag_files
from forest_bag.storage.mcap_records import HEAD, MAGIC, MESSAGE, attachment, chunk_records

# How a record that is looked for begins: no length has more than five digits to the base 256.
_BEGINNING = re.compile(rb"[\x03\x04\x06\x09\x0c].{5}\x00{3}", re.DOTALL)
_READERS: dict[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.METADATA: Metadata.read,
}
_WITHOUT_USE = {Opcode.HEADER, Opcode.MESSAGE_INDEX, *range(0x80, 0x100)}  # of these: anybody's own records
_ERRORS = (McapError, struct.error, ValueError, RuntimeError, MemoryError, EOFError)


class Damage(NamedTuple):
    """Bytes that are of no use."""

    start: int
    length: int


class Salvage:
    """Reads one file; iterate over its schemas, channels, messages, attachments and metadata.

    Attributes:
        damages: places that could not be read, so far.
        complete: whether the end of the data was found, as a file that was closed has it.
        empty: whether there is neither a message nor an attachment.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damages: list[Damage] = []
        self.complete = False
        self.empty = not any(isinstance(record, Message | Attachment) for record in self)
        self.damages.clear()
        self.complete = False

    def __iter__(self) -> Iterator[McapRecord]:
        """Yield what is whole, definitions first where the summary has them.

        Raises:
            OSError: the file cannot be read.
        """
        if not self.path.stat().st_size:
            return
        with self.path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            yield from _summary(data)
            yield from self._data(data)

    def _data(self, data: mmap.mmap) -> Iterator[McapRecord]:
        place = len(MAGIC) if data[: len(MAGIC)] == MAGIC else 0
        while place < len(data):
            opcode, end = _head(data, place)
            if opcode == Opcode.DATA_END and end - place == HEAD.size + 4:
                self.complete = True
                return
            records = self._records(opcode, data[place + HEAD.size : end]) if end <= len(data) else None
            if records is None:
                found = self._next(data, place + 1)
                self.damages.append(Damage(place, found - place))
                place = found
            else:
                yield from records
                place = end

    def _records(self, opcode: int, content: bytes) -> list[McapRecord] | None:
        """What a record holds, [] if that is of no use here, None if it is not whole."""
        if opcode == Opcode.MESSAGE and len(content) >= MESSAGE.size:
            return [_message(content)]
        try:
            record = _parsed(opcode, content)
            if isinstance(record, Chunk):
                return list(_within(record))
        except _ERRORS:
            return None
        if record is not None:
            return [record]
        return [] if opcode in _WITHOUT_USE else None

    def _next(self, data: mmap.mmap, start: int) -> int:
        """The place of the next whole record that can be told from chance, or the file's end."""
        for match in _BEGINNING.finditer(data, start):
            place = match.start()
            opcode, end = _head(data, place)
            if end <= len(data) and self._records(opcode, data[place + HEAD.size : end]) is not None:
                return place
        return len(data)


def is_recoverable(path: Path) -> bool:
    """Whether a bag, a directory or one file, holds anything that a recovery would save."""
    try:
        return any(not Salvage(file).empty for file in bag_files(path))
    except (BagError, OSError):
        return False


def _head(data: mmap.mmap, place: int) -> tuple[int, int]:
    """A record's opcode, and where it ends; beyond the file if its head is cut off."""
    if place + HEAD.size > len(data):
        return 0, len(data) + 1
    opcode, length = HEAD.unpack_from(data, place)
    return opcode, place + HEAD.size + length


def _message(content: bytes) -> Message:
    """A message, ten times faster than by a stream."""
    channel, sequence, log_ns, publish_ns = MESSAGE.unpack_from(content)
    return Message(channel, log_ns, content[MESSAGE.size :], publish_ns, sequence)


def _stream(content: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(content))


def _parsed(opcode: int, content: bytes) -> McapRecord | None:
    """The record, None if it is of no kind that is wanted.

    Raises:
        ValueError: its lengths or its checksum do not agree.
    """
    if opcode == Opcode.ATTACHMENT:
        return attachment(content)
    if opcode not in _READERS:
        return None
    stream = _stream(content)
    record = _READERS[opcode](stream)
    if stream.count != len(content):
        raise ValueError("the lengths within the record do not add up")
    return record


def _within(chunk: Chunk) -> Iterator[McapRecord]:
    """The records of a chunk.

    Raises:
        ValueError: it is damaged.
    """
    content = chunk_records(chunk)
    place = 0
    while place < len(content):
        opcode, length = HEAD.unpack_from(content, place)
        inner = content[place + HEAD.size : place + HEAD.size + length]
        place += HEAD.size + length
        if opcode == Opcode.MESSAGE:
            yield _message(inner)
        elif (record := _parsed(opcode, inner)) is not None:
            yield record


def _summary(data: mmap.mmap) -> Iterator[McapRecord]:
    """Schemas and channels as the end of the file repeats them, should their first place be damaged."""
    footer = len(data) - len(MAGIC) - HEAD.size - 20
    if footer < 0 or data[-len(MAGIC) :] != MAGIC or _head(data, footer)[0] != Opcode.FOOTER:
        return
    place = int.from_bytes(data[footer + HEAD.size : footer + HEAD.size + 8], "little")
    while 0 < place < footer:
        opcode, end = _head(data, place)
        if end > footer:
            return
        record: Any = None
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            try:
                record = _parsed(opcode, data[place + HEAD.size : end])
            except _ERRORS:
                return
        if record is not None:
            yield record
        place = end
