"""The directory of bags: which there are, and which names a person in a browser may give.

A name is the path below the directory, of three parts at most: ``monday``, ``demo/bag``, ``shift.mcap``.
Nothing outside of the directory is opened, by whatever name or link. Nothing in it is overwritten.
"""

import contextlib
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from forest_bag.read.bag_reader import SUFFIXES
from forest_bag.storage.bag_files import BagError

DEEPEST = 3  # parts of a name: a demo's bag is demo/bag
LONGEST_NAME = 64
METADATA = "metadata.yaml"
METADATA_BYTES = 1 << 20  # more is not looked at for the list
_NEW = re.compile(rf"[A-Za-z0-9][A-Za-z0-9_.-]{{0,{LONGEST_NAME - 1}}}")
_DURATION = re.compile(r"\bduration:\s*nanoseconds:\s*(\d{1,19})\b")


class BagEntry(NamedTuple):
    """A bag in the list; ``seconds`` is None where only reading it would tell."""

    name: str
    bytes: int
    modified: float  # s since 1970
    seconds: float | None


class BagDirectory:
    """Bags below one directory.

    Args:
        path: the directory; it need not exist yet.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path).absolute()

    def entries(self) -> list[BagEntry]:
        """Return the bags, newest first."""
        found = [self._entry(path) for path in self._bags(self.path, 1)]
        return sorted(found, key=lambda entry: entry.modified, reverse=True)

    def existing(self, name: str) -> Path:
        """Return the path of a bag.

        Raises:
            BagError: there is no bag of this name here.
        """
        parts = name.split("/")
        usual = len(parts) <= DEEPEST and all(part and not part.startswith(".") for part in parts)
        with contextlib.suppress(OSError, ValueError):  # no file can have such a name
            path = self.path.joinpath(*parts)
            if usual and _is_bag(path) and self._holds(path):
                return path
        raise BagError(f"there is no bag {name[:LONGEST_NAME]!r}; allowed: a name of the list of bags")

    def new(self, name: str | None) -> Path:
        """Return the path of a bag to be made.

        Args:
            name: as a person gave it; None: date and time.

        Raises:
            BagError: the name is not allowed, or taken.
        """
        if not name:
            return self._unused(time.strftime("%Y-%m-%d_%H-%M-%S"))
        if not _NEW.fullmatch(name):
            allowed = f"1 to {LONGEST_NAME} letters, digits, '_', '-' and '.', a letter or digit first"
            raise BagError(f"a bag cannot be named {name[:LONGEST_NAME]!r}; allowed: {allowed}")
        path = self.path / name
        if path.exists() or path.is_symlink():
            raise BagError(f"a bag {name!r} exists, and no bag is overwritten; allowed: another name")
        return path

    def _unused(self, name: str) -> Path:
        path, number = self.path / name, 1
        while path.exists():
            number += 1
            path = self.path / f"{name}_{number}"
        return path

    def _holds(self, path: Path) -> bool:
        return path.resolve().is_relative_to(self.path.resolve())

    def _bags(self, directory: Path, depth: int) -> Iterator[Path]:
        if not directory.is_dir():
            return
        for path in directory.iterdir():
            if path.name.startswith(".") or not self._holds(path):
                continue
            if _is_bag(path):
                yield path
            elif path.is_dir() and depth < DEEPEST:
                yield from self._bags(path, depth + 1)

    def _entry(self, path: Path) -> BagEntry:
        files = [file.stat() for file in path.iterdir() if file.is_file()] if path.is_dir() else [path.stat()]
        return BagEntry(
            name=path.relative_to(self.path).as_posix(),
            bytes=sum(file.st_size for file in files),
            modified=max((file.st_mtime for file in files), default=path.stat().st_mtime),
            seconds=_seconds(path / METADATA),
        )


def _is_bag(path: Path) -> bool:
    if path.is_dir():
        return any(_is_file_of_a_bag(file) for file in path.iterdir())
    return _is_file_of_a_bag(path)


def _is_file_of_a_bag(path: Path) -> bool:
    return path.name.endswith(SUFFIXES) and path.is_file()


def _seconds(metadata: Path) -> float | None:
    """Return a finished bag's duration [s]; searched for, since to parse hundreds of files takes seconds."""
    if not metadata.is_file() or metadata.stat().st_size > METADATA_BYTES:
        return None
    found = _DURATION.search(metadata.read_text(encoding="utf-8", errors="replace"))
    return int(found[1]) * 1e-9 if found else None
