"""The frame of MCAP's records, which reader, writer and salvage share: magic, heads, messages, chunks."""

from __future__ import annotations

import struct
import zlib
from io import BytesIO

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.records import Attachment, Chunk

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")  # opcode, length
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log and publish time [ns]; the data follow
LARGEST_CHUNK = 1 << 32  # uncompressed bytes; more is a damaged number


def chunk_records(chunk: Chunk) -> bytes:
    """Return the records inside a chunk, decompressed and tested against its length and checksum.

    Raises:
        ValueError: it is damaged, or compressed in a way that MCAP does not know.
    """
    if chunk.uncompressed_size > LARGEST_CHUNK:
        raise ValueError("the chunk's length is impossible")
    try:
        content = _decompressed(chunk)
    except (zstandard.ZstdError, RuntimeError, MemoryError, EOFError) as error:
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
        whole = zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=chunk.uncompressed_size)
        return bytes(whole)
    if chunk.compression == "lz4":
        return bytes(lz4.frame.decompress(chunk.data))
    if chunk.compression:
        raise ValueError(f"compression {chunk.compression!r} is unknown")
    return bytes(chunk.data)
