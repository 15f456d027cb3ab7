"""The frame of MCAP's records, which reader, writer and recovery share: magic, heads, messages, chunks.

A file is the magic bytes, records, a footer that says where its summary begins, and the magic bytes again. A
record is its opcode (1 byte), its length (8 bytes) and its content. Source: mcap.dev, format specification.
"""

import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import Any

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, McapRecord, Metadata, Schema, Statistics

from forest_bag.storage.decompression import LARGEST, unlz4, unzstd

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")  # opcode, length
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log and publish time [ns]; the data follow
FOOTER = struct.Struct("<QQI")  # start of the summary, of its offsets, checksum
# What these functions, mcap's and Python's own raise over bytes that make no sense.
BROKEN = (McapError, struct.error, ValueError, KeyError, EOFError, RuntimeError, MemoryError, OverflowError)
_READERS: dict[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.METADATA: Metadata.read,
    Opcode.STATISTICS: Statistics.read,
}


def records(data: Any, start: int = 0, stop: int | None = None) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start of the content and end of every record, up to the first that is not whole.

    Raises:
        ValueError: a message's record is too short for one.
    """
    stop = len(data) if stop is None else stop
    while start + HEAD.size <= stop:
        opcode, length = HEAD.unpack_from(data, start)
        begin = start + HEAD.size
        if begin + length > stop or opcode == 0:
            return
        if opcode == Opcode.MESSAGE and length < MESSAGE.size:
            raise ValueError(f"the message at byte {start} has a length of {length} bytes")
        start = begin + length
        yield opcode, begin, start


def whole_records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield what `records` does, of bytes that hold nothing else.

    Raises:
        ValueError: they do.
    """
    end = 0
    for opcode, begin, end in records(data):
        yield opcode, begin, end
    if end != len(data):
        raise ValueError(f"what begins at its byte {end} is no record")


def parsed(opcode: int, content: bytes, exact: bool = False) -> Any:
    """Return a record as mcap reads it; None if it is of no kind that a bag is read for.

    Args:
        opcode: of the record.
        content: its bytes behind the head.
        exact: nothing may follow the fields that are known.

    Raises:
        BROKEN: the bytes are no such record.
    """
    if opcode == Opcode.ATTACHMENT:
        return attachment(content)
    if opcode not in _READERS:
        return None
    stream = ReadDataStream(BytesIO(content))
    record = _READERS[opcode](stream)
    if exact and stream.count != len(content):
        raise ValueError("the lengths within the record do not add up")
    return record


def footer(data: Any) -> tuple[int, int, int]:
    """Return where a file's footer stands, where the summary begins (there if it is empty), its checksum.

    Raises:
        ValueError: the file has no footer.
    """
    place = len(data) - len(MAGIC) - HEAD.size - FOOTER.size
    if place < 0 or data[-len(MAGIC) :] != MAGIC or data[place] != Opcode.FOOTER:
        raise ValueError("no footer")
    start, _, checksum = FOOTER.unpack_from(data, place + HEAD.size)
    if start > place:
        raise ValueError("the footer points behind itself")
    return place, start or place, checksum


def chunk_records(chunk: Chunk) -> bytes:
    """Return the records inside a chunk, decompressed and tested against its length and checksum.

    Raises:
        ValueError: it is damaged, or compressed in a way that MCAP does not know.
    """
    if chunk.uncompressed_size > LARGEST:
        raise ValueError(f"the chunk says that it has {chunk.uncompressed_size} bytes; allowed: {LARGEST}")
    try:
        content = _decompressed(chunk)
    except ValueError as error:
        raise ValueError(f"the chunk cannot be decompressed ({error})") from error
    if len(content) != chunk.uncompressed_size:
        raise ValueError("the chunk's length is wrong")
    if chunk.uncompressed_crc and zlib.crc32(content) != chunk.uncompressed_crc:
        raise ValueError("the chunk's checksum is wrong")
    return content


def attachment(content: bytes) -> Attachment:
    """Return an attachment, tested against its checksum, which mcap's own reader skips.

    Raises:
        ValueError: it is damaged.
    """
    stream = ReadDataStream(BytesIO(content))
    record: Attachment = Attachment.read(stream)
    if stream.count != len(content):
        raise ValueError("the attachment's lengths do not add up")
    checksum = int.from_bytes(content[-4:], "little")
    if checksum not in (0, zlib.crc32(content[:-4])):
        raise ValueError("the attachment's checksum is wrong")
    return record


def _decompressed(chunk: Chunk) -> bytes:
    if chunk.compression == "zstd":
        return unzstd(chunk.data, chunk.uncompressed_size)
    if chunk.compression == "lz4":
        return unlz4(chunk.data, chunk.uncompressed_size)
    if chunk.compression:
        raise ValueError(f"compression {chunk.compression!r} is unknown")
    return bytes(chunk.data)
