"""Which files a bag consists of, in the order in which they were written."""

from __future__ import annotations

import re
from pathlib import Path


class BagError(Exception):
    """A bag cannot be used as asked; the text is one sentence for the user."""


def bag_files(path: str | Path) -> list[Path]:
    """Return the .mcap files of a bag directory, or the one file that is named.

    Sorted by the number at the end of the name: split 10 comes after split 9.

    Raises:
        BagError: there is no such file or directory, or no .mcap file in it.
    """
    path = Path(path)
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise BagError(f"{path} does not exist; allowed: a bag's directory or an .mcap file")
    files = sorted(path.glob("*.mcap"), key=_order)
    if not files:
        raise BagError(f"{path} holds no .mcap file; allowed: a bag's directory or an .mcap file")
    return files


def _order(file: Path) -> tuple[str, int]:
    stem, number = re.fullmatch(r"(.*?)(\d*)", file.stem, re.DOTALL).groups()  # type: ignore[union-attr]
    return stem, int(number or 0)
