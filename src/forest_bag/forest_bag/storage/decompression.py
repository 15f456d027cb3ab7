"""Decompressing what somebody else compressed, within bounds that are asked before memory is taken.

A hundred kilobytes of zstd may hold gigabytes of zeros.
"""

from pathlib import Path

import lz4.frame
import zstandard

LARGEST = 1 << 28  # [byte] of a chunk or message: writers' chunks have 1 MiB, a picture 0.1 GiB
LARGEST_FILE = 1 << 30  # [byte] of a file that is compressed as a whole,
MOST = 100  # [1] or so many times its size, if that is more: bags shrink to a fifth


def unzstd(data: bytes, most: int = LARGEST) -> bytes:
    """Return what a zstd frame holds, at most so many bytes.

    Raises:
        ValueError: it is damaged, or holds more.
    """
    try:
        if zstandard.frame_content_size(data) > most:
            raise ValueError(f"it would take more than {most} bytes")
        return bytes(zstandard.ZstdDecompressor().decompress(data, max_output_size=most))
    except (zstandard.ZstdError, MemoryError) as error:
        raise ValueError(str(error)) from error


def unlz4(data: bytes, most: int = LARGEST) -> bytes:
    """Return what an lz4 frame holds, at most so many bytes.

    Raises:
        ValueError: it is damaged, or holds more.
    """
    frame = lz4.frame.LZ4FrameDecompressor()
    try:
        content = bytes(frame.decompress(data, max_length=most + 1))
    except (RuntimeError, MemoryError, EOFError) as error:
        raise ValueError(str(error)) from error
    if len(content) > most:
        raise ValueError(f"it would take more than {most} bytes")
    if not frame.eof:
        raise ValueError("its end is missing")
    return content


def unzstd_file(source: Path, target: Path) -> None:
    """Decompress a file into another.

    Raises:
        ValueError: it is damaged, or holds more than such a file may.
    """
    most, written = max(LARGEST_FILE, MOST * source.stat().st_size), 0
    with source.open("rb") as packed, target.open("wb") as plain:
        try:
            for part in zstandard.ZstdDecompressor().read_to_iter(packed):
                written += len(part)
                if written > most:
                    raise ValueError(f"it would take more than {most} bytes")
                plain.write(part)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from error
