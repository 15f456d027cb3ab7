"""A bag from disk as raw messages in the order of their log times, whoever wrote it.

A bag is a directory (rosbag2's: files with or without ``metadata.yaml``) or a single file; MCAP or SQLite;
chunks, messages or whole files compressed. Only what is due is in memory, so a bag may be of any length, and
reading may begin anywhere. No ROS in here.
"""

import contextlib
import re
import tempfile
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable, Iterator
from operator import itemgetter
from pathlib import Path
from types import TracebackType
from typing import Any

import yaml

from forest_bag.storage.bag_files import BagError
from forest_bag.storage.decompression import unzstd, unzstd_file
from forest_bag.storage.mcap_reader import McapPieces
from forest_bag.storage.mcap_recovery import is_recoverable
from forest_bag.storage.raw_messages import BagFile, Channel, Damaged, Piece, RawMessage
from forest_bag.storage.sqlite_reader import SqlitePieces
from forest_msgs_py.interfaces.yaml_text import parsed

READERS: dict[str, Callable[[Path, Path], BagFile]] = {".mcap": McapPieces, ".db3": SqlitePieces}
"""What reads a file, by its suffix; called with the file and its decompressed copy."""
SUFFIXES = (*READERS, *(f"{suffix}.zstd" for suffix in READERS))
FILE_KINDS = f"a directory of rosbag2's, {', '.join(READERS)}, or one of these with .zstd"
LARGEST_METADATA = 1 << 26  # [byte] of metadata.yaml: a thousand topics take one
_log_time = itemgetter(0)


class BagReader:
    """The files of a bag, open; a context manager."""

    def __init__(self, path: str | Path, lenient: bool = False, by_metadata: bool = True) -> None:
        """Open a bag.

        Args:
            path: directory or file.
            lenient: take of a damaged bag what is whole; ``problems`` then says what is not.
            by_metadata: believe metadata.yaml; False: only the files.

        Raises:
            BagError: this is no bag, or (not lenient) a damaged one.
            OSError: it cannot be read.
        """
        self.path = Path(path)
        self.lenient, self._by_metadata = lenient, by_metadata
        self.problems: list[str] = []
        self._unpacked: tempfile.TemporaryDirectory[str] | None = None
        self.information = self._information()
        compression = str(self.information.get("compression_mode") or "").lower()
        self._by_message = compression == "message"
        self.files: list[BagFile] = []
        paths = self._paths()
        self.size = sum(file.stat().st_size for file in paths)  # bytes
        try:
            for file in paths:
                self._open(file)
        except BaseException:
            self.close()
            raise
        self.complete = not self.problems

    def __enter__(self) -> "BagReader":
        """Open already."""
        return self

    def __exit__(
        self, _type: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def close(self) -> None:
        """Let go of the files."""
        for file in self.files:
            file.close()
        if self._unpacked is not None:
            self._unpacked.cleanup()

    @property
    def notes(self) -> list[str]:
        """What the user should know, although nothing is wrong."""
        return [note for file in self.files for note in file.notes]

    @property
    def channels(self) -> dict[str, list[Channel]]:
        """What the files say of each topic, by name; a topic of several files or types has several."""
        found: dict[str, list[Channel]] = {}
        for file in self.files:
            for channel in file.channels.values():
                known = found.setdefault(channel.topic, [])
                if channel not in known:
                    known.append(channel)
        return dict(sorted(found.items()))

    @property
    def span(self) -> tuple[int, int]:
        """First and last log time, ns; (0, 0) for a bag without messages."""
        pieces = [piece for file in self.files for piece in file.pieces]
        first = min((piece.first_ns for piece in pieces), default=0)
        return first, max((piece.last_ns for piece in pieces), default=0)

    def messages(self, topics: Collection[str] | None = None, start_ns: int = 0) -> Iterator[RawMessage]:
        """Yield messages in the order of their log times; equal ones in the files' order.

        Args:
            topics: only these; None: all.
            start_ns: only from this log time on.

        Raises:
            Damaged: bytes were changed (a lenient reader skips them and notes it).
        """
        places = [
            (piece, file)
            for file in self.files
            for piece in file.pieces
            if piece.last_ns >= start_ns and _concerns(piece, file, topics)
        ]
        places.sort(key=lambda place: place[0].first_ns)
        waiting: list[RawMessage] = []
        for piece, file in places:
            due = bisect_left(waiting, piece.first_ns, key=_log_time)
            yield from self._whole(waiting[:due])
            del waiting[:due]
            waiting += self._read(piece, file, topics, start_ns)
            waiting.sort(key=_log_time)
        yield from self._whole(waiting)

    def newest(self, topics: Collection[str], time_ns: int) -> dict[str, RawMessage]:
        """Return the last message of each topic up to a log time; a topic without one is left out.

        Read backwards, and no further than until all are found.

        Raises:
            Damaged: as `messages`.
        """
        found: dict[str, RawMessage] = {}
        places = [(piece, file) for file in self.files for piece in file.pieces if piece.first_ns <= time_ns]
        for piece, file in sorted(places, key=lambda place: place[0].last_ns, reverse=True):
            sought = {name for name in topics if name not in found or found[name].log_ns < piece.last_ns}
            if not sought:
                break
            read = self._read(piece, file, sought, 0) if _concerns(piece, file, sought) else []
            for message in self._whole(read):
                last = found.get(message.channel.topic)
                if message.log_ns <= time_ns and (last is None or message.log_ns >= last.log_ns):
                    found[message.channel.topic] = message
        return found

    def check(self) -> None:
        """Look at all of it: checksums where it has them, structure, compressed messages.

        Raises:
            Damaged: bytes were changed (a lenient reader notes it).
        """
        for file in self.files:
            with self._watched():
                file.check()
            for piece in file.pieces if self._by_message else ():
                for _ in self._whole(self._read(piece, file, None, 0)):
                    pass

    def _read(
        self, piece: Piece, file: BagFile, topics: Collection[str] | None, start_ns: int
    ) -> list[RawMessage]:
        with self._watched():
            return [
                message
                for message in file.read(piece)
                if message.log_ns >= start_ns and (topics is None or message.channel.topic in topics)
            ]
        return []

    def _whole(self, read: Iterable[RawMessage]) -> Iterator[RawMessage]:
        """Decompress messages as they are wanted: a piece may hold thousands of bombs."""
        for message in read:
            with self._watched():
                message = _decompressed(message) if self._by_message else message
                yield message

    @contextlib.contextmanager
    def _watched(self) -> Iterator[None]:
        """Say what helps with damage that is met, or, lenient, note it."""
        try:
            yield
        except Damaged as error:
            if str(error) not in self.problems:
                self._note(str(error))
            self.complete = False

    def _paths(self) -> list[Path]:
        """The bag's files: as metadata.yaml lists them, else all there are, counted as people count."""
        if not self.path.exists():
            raise BagError(f"{self.path} does not exist; allowed: {FILE_KINDS}")
        if not self.path.is_dir():
            if not (self.path.name.endswith(SUFFIXES) and self.path.is_file()):
                raise BagError(f"{self.path} is no bag; allowed: {FILE_KINDS}")
            return [self.path]
        listed = self.information.get("relative_file_paths") if self._by_metadata else None
        listed = listed if isinstance(listed, list) else []
        files = list(dict.fromkeys(self.path / Path(str(name)).name for name in listed))
        missing = [file.name for file in files if not file.is_file()]
        if missing and not self.lenient:
            names = ", ".join(missing)
            raise BagError(f"{self.path} lacks {names} of its metadata.yaml{_advice(self.path)}")
        self.problems += [f"{name} of metadata.yaml is not there" for name in missing]
        there = (file for file in self.path.iterdir() if file.name.endswith(SUFFIXES) and file.is_file())
        files = [file for file in files if file.is_file()] or sorted(there, key=_counted)
        if not files:
            raise BagError(f"no .mcap file in {self.path} and no .db3; allowed: {FILE_KINDS}")
        return files

    def _information(self) -> dict[str, Any]:
        """Read metadata.yaml; {} where there is none, or nothing in it."""
        file = self.path / "metadata.yaml"
        if not file.is_file():
            return {}
        if file.stat().st_size > LARGEST_METADATA:
            self._note(f"{file} has {file.stat().st_size} bytes; allowed: {LARGEST_METADATA}")
            return {}
        try:
            content = parsed(file.read_text(encoding="utf-8"), LARGEST_METADATA)
        except (yaml.YAMLError, UnicodeDecodeError) as error:
            if self._by_metadata:
                self._note(f"{file} is not YAML: {' '.join(str(error).split())}")
            return {}
        information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
        return information if isinstance(information, dict) else {}

    def _open(self, path: Path) -> None:
        plain = self._without_zstd(path)
        read = READERS.get(plain.suffix, SqlitePieces)  # metadata.yaml may name a file of any suffix
        try:
            file = read(path, plain)
        except Damaged as error:
            self._note(str(error))
            return
        self.files.append(file)
        for problem in file.problems:
            self._note(f"{path} is damaged: {problem}")

    def _note(self, problem: str) -> None:
        if not self.lenient:
            raise Damaged(f"{problem}{_advice(self.path)}")
        self.problems.append(problem)

    def _without_zstd(self, path: Path) -> Path:
        if path.suffix != ".zstd":
            return path
        if self._unpacked is None:
            self._unpacked = tempfile.TemporaryDirectory(prefix="forest-bag-")
        plain = Path(self._unpacked.name) / path.stem
        try:
            unzstd_file(path, plain)
        except ValueError as error:
            self._note(f"{path} is damaged: it cannot be decompressed ({error})")
        return plain


def _concerns(piece: Piece, file: BagFile, topics: Collection[str] | None) -> bool:
    if topics is None or piece.channels is None:
        return True
    return any(file.channels[number].topic in topics for number in piece.channels if number in file.channels)


def _decompressed(message: RawMessage) -> RawMessage:
    try:
        return message._replace(data=unzstd(message.data))
    except ValueError as error:
        raise Damaged(f"a message of {message.channel.topic} cannot be decompressed: {error}") from error


def _counted(path: Path) -> tuple[Any, ...]:
    """Sort ``bag_10`` behind ``bag_9``."""
    return tuple(int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", path.name))


def _advice(path: Path) -> str:
    """What follows a complaint: what helps, if anything does."""
    return f"; 'forest-bag recover {path}' saves what is whole" if is_recoverable(path) else ""
