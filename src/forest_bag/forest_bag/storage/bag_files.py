"""Which files a bag consists of, in the order in which they were written."""

import re
from pathlib import Path


class BagError(Exception):
    """A bag cannot be used as asked; the text is one sentence for the user."""


ALLOWED = "a bag's directory or an .mcap file"
FOREIGN = {
    b"SQLite format 3\0": "is an SQLite database, of which only info, the tables and plot take what is whole",
    b"\x28\xb5\x2f\xfd": "is compressed as a whole, decompress it first (zstd -dc FILE.zstd > FILE)",
}


def bag_files(path: str | Path) -> list[Path]:
    """Return the .mcap files of a bag directory, or the one file that is named.

    Sorted by the number at the end of the name: split 10 comes after split 9.

    Raises:
        BagError: there is no such file or directory, or no .mcap file in it; or it is of another kind.
        OSError: it cannot be read.
    """
    path = Path(path)
    if path.is_file():
        _refuse_foreign(path)
        return [path]
    if not path.exists():
        raise BagError(f"{path} does not exist; allowed: {ALLOWED}")
    if not path.is_dir():
        raise BagError(f"{path} is neither file nor directory; allowed: {ALLOWED}")
    files = sorted((file for file in path.glob("*.mcap") if file.is_file()), key=_order)
    if not files:
        raise BagError(f"{path} holds no .mcap file; allowed: {ALLOWED}")
    return files


def _refuse_foreign(path: Path) -> None:
    with path.open("rb") as stream:
        start = stream.read(max(map(len, FOREIGN)))
    for magic, problem in FOREIGN.items():
        if start.startswith(magic):
            raise BagError(f"{path} {problem}; allowed: {ALLOWED}")


def _order(file: Path) -> tuple[str, int]:
    stem, number = re.fullmatch(r"(.*?)(\d*)", file.stem, re.DOTALL).groups()  # type: ignore[union-attr]
    return stem, int(number or 0)
