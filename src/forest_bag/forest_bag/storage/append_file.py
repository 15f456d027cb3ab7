"""A file to which pieces are appended whole or not at all, and which survives the loss of power and space."""

import errno
import os
import tempfile
import threading
from pathlib import Path
from typing import IO

CANNOT_RESERVE = (errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS)  # file systems that do not know how


class AppendFile:
    """A new file, appended to.

    Args:
        path: to be made.
        durable: force what was flushed to the disk itself, in a thread beside: power may fail.

    Raises:
        OSError: the file exists, or cannot be made.
    """

    def __init__(self, path: Path, durable: bool) -> None:
        self.size = 0
        self.closed = False
        self._dirty = False
        self._path = path
        self._reserve: IO[bytes] = tempfile.TemporaryFile(dir=path.parent)  # noqa: SIM115  closed by `release`
        try:
            self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        except OSError:
            self._reserve.close()
            raise
        self._reserved = 0
        self._syncer = _Syncer(self._descriptor) if durable else None

    def append(self, piece: bytes) -> None:
        """Append a piece, or nothing.

        Raises:
            OSError: the disk is full; the file ends where it ended before.
        """
        view = memoryview(piece)
        try:
            while view:
                view = view[os.write(self._descriptor, view) :]
        except OSError as error:
            os.ftruncate(self._descriptor, self.size)
            os.lseek(self._descriptor, self.size, os.SEEK_SET)
            error.filename = str(self._path)
            raise
        self.size += len(piece)
        self._dirty = True

    def sync_soon(self) -> None:
        """Have what is written by now forced to the disk, without waiting for it.

        Raises:
            OSError: that has failed the last time.
        """
        if self._syncer is not None and self._dirty:
            self._syncer.request()
            self._dirty = False

    def keep_free(self, size: int) -> None:
        """Hold space on the disk for later, by a file without a name.

        Raises:
            OSError: there is not that much.
        """
        if size > self._reserved:
            try:
                os.posix_fallocate(self._reserve.fileno(), 0, 2 * size)
            except OSError as error:
                if error.errno not in CANNOT_RESERVE:
                    raise
            self._reserved = 2 * size

    def release(self) -> None:
        """Give the held space back: now it is needed."""
        self._reserve.close()

    def close(self) -> None:
        """Force everything to the disk and close; a second call does nothing.

        Raises:
            OSError: the disk is broken; the file is closed all the same.
        """
        if self.closed:
            return
        self.closed = True
        self._reserve.close()
        try:
            os.fsync(self._descriptor)
        finally:
            if self._syncer is not None:
                self._syncer.end()
            os.close(self._descriptor)


class _Syncer(threading.Thread):
    """Forces a file to the disk beside the thread that writes it, which must not wait for that."""

    def __init__(self, descriptor: int) -> None:
        super().__init__(name="bag-sync", daemon=True)
        self._descriptor = os.dup(descriptor)
        self._due = threading.Event()
        self._ended = False
        self._error: OSError | None = None
        self.start()

    def request(self) -> None:
        if self._error is not None:
            raise self._error
        self._due.set()

    def run(self) -> None:
        while self._due.wait() and not self._ended:
            self._due.clear()
            try:
                os.fdatasync(self._descriptor)
            except OSError as error:
                self._error = error

    def end(self) -> None:
        """End the thread; what it was doing is finished first."""
        self._ended = True
        self._due.set()
        self.join()
        os.close(self._descriptor)
