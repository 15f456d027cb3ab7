"""What is readable in an MCAP file that was cut off, or damaged in the middle: every whole record.

Kept beside mcap's own readers: they stop at the first record that they cannot parse, and give up everything
behind it. Here the search goes on for the next record that is whole: a chunk by its checksum, others by
lengths that agree. A message outside of chunks, an index and a stranger's own record have neither: they are
whole where another record, or a hole, begins behind them. Else one wrong length would swallow what follows.
"""

import mmap
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import Attachment, Chunk, McapRecord, Message

from forest_bag.storage.bag_files import BagError, bag_files
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

# How a record that is looked for begins: no length has more than five digits to the base 256.
_BEGINNING = re.compile(rb"[\x03\x04\x06\x09\x0c].{5}\x00{3}", re.DOTALL)
_WITH_MESSAGES = re.compile(rb"[\x03-\x06\x09\x0c].{5}\x00{3}", re.DOTALL)  # of files without chunks
_ANY_BEGINNING = re.compile(rb"[\x01-\x0f\x80-\xff](.{0,5}$|.{5}\x00{0,3}$|.{5}\x00{3})", re.DOTALL)
_HOLE = bytes(64)  # zeroes, as a power cut leaves them
_WITHOUT_USE = {Opcode.HEADER, Opcode.MESSAGE_INDEX, *range(0x80, 0x100)}  # of these: anybody's own records


class Damage(NamedTuple):
    """Bytes that are of no use."""

    start: int
    length: int


class RecordRecovery:
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
        self._beginning = _BEGINNING
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
            records = self._records(data, place)
            if records is None:
                found = self._next(data, place + 1)
                self.damages.append(Damage(place, found - place))
                place = found
            else:
                yield from records
                place = end

    def _records(self, data: mmap.mmap, place: int) -> list[McapRecord] | None:
        """What a record holds, [] if that is of no use here, None if it is not whole."""
        opcode, end = _head(data, place)
        if end > len(data):
            return None
        if opcode == Opcode.MESSAGE or opcode in _WITHOUT_USE:
            return self._unproven(opcode, data[place + HEAD.size : end]) if _is_beginning(data, end) else None
        try:
            record = parsed(opcode, data[place + HEAD.size : end], exact=True)
            if isinstance(record, Chunk):
                return list(_within(record))
        except BROKEN:
            return None
        return None if record is None else [record]

    def _unproven(self, opcode: int, content: bytes) -> list[McapRecord] | None:
        """What a record holds for which no checksum and no length within speaks, as `_records`."""
        if opcode != Opcode.MESSAGE:
            return []
        if len(content) < MESSAGE.size:
            return None
        self._beginning = _WITH_MESSAGES  # within chunks they are not looked for: a checksum speaks for all
        return [_message(content)]

    def _next(self, data: mmap.mmap, start: int) -> int:
        """The place of the next whole record that can be told from chance, or the file's end."""
        for match in self._beginning.finditer(data, start):
            if self._records(data, match.start()) is not None:
                return match.start()
        return len(data)


def is_recoverable(path: Path) -> bool:
    """Whether a bag, a directory or one file, holds anything that a recovery would save."""
    try:
        return any(not RecordRecovery(file).empty for file in bag_files(path))
    except (BagError, OSError):
        return False


def _head(data: mmap.mmap, place: int) -> tuple[int, int]:
    """A record's opcode, and where it ends; beyond the file if its head is cut off."""
    if place + HEAD.size > len(data):
        return 0, len(data) + 1
    opcode, length = HEAD.unpack_from(data, place)
    return opcode, place + HEAD.size + length


def _is_beginning(data: mmap.mmap, place: int) -> bool:
    """Whether the file ends there, or another record begins, be it cut off in its head, or a hole."""
    return _HOLE.startswith(data[place : place + len(_HOLE)]) or _ANY_BEGINNING.match(data, place) is not None


def _message(content: bytes) -> Message:
    """A message, ten times faster than by a stream."""
    channel, sequence, log_ns, publish_ns = MESSAGE.unpack_from(content)
    return Message(channel, log_ns, content[MESSAGE.size :], publish_ns, sequence)


def _within(chunk: Chunk) -> Iterator[McapRecord]:
    """The records of a chunk.

    Raises:
        BROKEN: it is damaged.
    """
    content = chunk_records(chunk)
    for opcode, begin, end in whole_records(content):
        inner = content[begin:end]
        if opcode == Opcode.MESSAGE:
            yield _message(inner)
        elif (record := parsed(opcode, inner, exact=True)) is not None:
            yield record


def _summary(data: mmap.mmap) -> Iterator[McapRecord]:
    """Schemas and channels as the end of the file repeats them, should their first place be damaged."""
    try:
        stop, start, _ = footer(data)
        for opcode, begin, end in records(data, start, stop):
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                yield parsed(opcode, data[begin:end], exact=True)
    except BROKEN:
        return
