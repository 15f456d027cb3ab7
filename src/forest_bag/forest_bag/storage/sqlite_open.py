"""Opens somebody's SQLite database for reading: nothing is left beside it, nothing in its log is overlooked.

===============  ===========================================================================================
file             what stands beside a database that was not closed well
===============  ===========================================================================================
``NAME-wal``     write-ahead log: what was committed, but is not in the database yet
``NAME-shm``     index of the log, as long as somebody has the database open, or after a crash
``NAME-journal`` what a half-finished change has overwritten
===============  ===========================================================================================

SQLite needs to write for reading: it makes ``-shm`` for a database in WAL mode, and undoes half-finished
changes. On read-only media it fails ("unable to open database file"), elsewhere it leaves files behind.
Source: sqlite.org, "Write-Ahead Logging" (Read-Only Databases) and "File Locking" (Hot Journals).
"""

import contextlib
import os
import shutil
import sqlite3
import tempfile
from pathlib import Path
from urllib.parse import quote

MODES = slice(18, 20)  # bytes of the header that name the versions for writing and reading
WAL = b"\x02\x02"
# What SQLite raises over a damaged file; Python decodes its complaint, which may quote bytes of the file.
BROKEN = (sqlite3.Error, UnicodeDecodeError)


class Database:
    """A database to be read.

    Attributes:
        note: what of its neighbourhood the user should know; "" if nothing.

    Raises:
        BROKEN: SQLite cannot open it.
        OSError: it cannot be read, or there is no room for a temporary copy.
    """

    def __init__(self, path: Path) -> None:
        self.note = ""
        self._closing = contextlib.ExitStack()
        with path.open("rb") as stream:
            in_wal_mode = stream.read(MODES.stop)[MODES] == WAL
        log, index, journal = (path.with_name(path.name + end) for end in ("-wal", "-shm", "-journal"))
        unfinished = log if in_wal_mode else journal
        if _holds_something(unfinished):
            self.note = f"{path.name} was not closed: it is read together with {unfinished.name}"
            if in_wal_mode and index.is_file():  # who made it may still be writing: SQLite keeps them apart
                how = "mode=ro"
            else:
                path, how = self._copied(path, unfinished), "mode=rw"
        else:
            how = "immutable=1" if in_wal_mode else "mode=ro"
        address = f"file:{quote(os.fsencode(path.resolve()))}?{how}"
        connection = sqlite3.connect(address, uri=True, check_same_thread=False)
        self._connection = self._closing.enter_context(contextlib.closing(connection))

    def execute(self, query: str, values: tuple[int, ...] = ()) -> sqlite3.Cursor:
        """Run a query."""
        return self._connection.execute(query, values)

    def close(self) -> None:
        """Let go of the file; a second call does nothing."""
        self._closing.close()

    def _copied(self, path: Path, unfinished: Path) -> Path:
        """Copy a database and what belongs to it to where SQLite may write."""
        folder = Path(self._closing.enter_context(tempfile.TemporaryDirectory(prefix="forest-bag-")))
        for file in (path, unfinished):
            shutil.copyfile(file, folder / file.name)
        return folder / path.name


def _holds_something(path: Path) -> bool:
    try:
        return path.is_file() and path.stat().st_size > 0
    except OSError:  # its name would be too long
        return False
