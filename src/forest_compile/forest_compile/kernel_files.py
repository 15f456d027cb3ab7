"""Files of machine code that nobody else can have put there, whole or not at all.

Whoever loads a file of machine code executes it. So the directory and the file must be the user's own, no
links, and writable to nobody else. A digest at a file's end covers its content and its name.
"""

import contextlib
import fcntl
import hashlib
import os
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

_DIGEST = hashlib.sha256().digest_size
_OTHERS = stat.S_IWGRP | stat.S_IWOTH


class UntrustedError(OSError):
    """A file or directory is not to be trusted: the message says which, and why."""


def directory() -> Path:
    """Return the directory of the kernel cache."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "forest_sim"


def read(path: Path) -> bytes | None:
    """Return the code in a file; None if there is no such file.

    Raises:
        UntrustedError: the file or its directory is somebody else's, or the file is not as it was written.
        OSError: it cannot be read.
    """
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        return None
    except OSError as error:
        if path.is_symlink():
            raise UntrustedError(f"{path} is a link") from error
        raise
    try:
        _check(path.parent, path.parent.lstat(), stat.S_IFDIR)
        _check(path, os.fstat(handle), stat.S_IFREG)
    except OSError:
        os.close(handle)
        raise
    with os.fdopen(handle, "rb") as file:
        content = file.read()
    code = content[:-_DIGEST]
    if content[-_DIGEST:] != _digest(path, code):
        raise UntrustedError(f"{path} is damaged")
    return code


def write(path: Path, code: bytes) -> None:
    """Write a file that others see whole or not at all; its directory is made if need be.

    Raises:
        UntrustedError: the directory is somebody else's.
        OSError: it cannot be written.
    """
    _make_directory(path.parent)
    if path.parent.stat().st_uid == os.geteuid() and not path.parent.is_symlink():
        path.parent.chmod(0o700)  # what others left there, `read` refuses by its owner
    _check(path.parent, path.parent.lstat(), stat.S_IFDIR)
    handle, name = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(code + _digest(path, code))
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise


@contextlib.contextmanager
def claimed() -> Iterator[bool]:
    """Keep others from making code meanwhile; give whether somebody made some before.

    It takes a core for seconds, and who waited finds it made. Where nothing can be locked, nobody waits.
    """
    with contextlib.ExitStack() as held:
        waited = False
        with contextlib.suppress(OSError):
            _make_directory(directory())
            handle = os.open(directory(), os.O_RDONLY | os.O_CLOEXEC)
            held.callback(os.close, handle)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                fcntl.flock(handle, fcntl.LOCK_EX)
                waited = True
        yield waited


def _make_directory(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.mkdir(mode=0o700, exist_ok=True)


def _check(path: Path, facts: os.stat_result, kind: int) -> None:
    """Raise UntrustedError unless a file is of a kind, the user's, and writable to no other."""
    if stat.S_ISLNK(facts.st_mode):
        raise UntrustedError(f"{path} is a link")
    if stat.S_IFMT(facts.st_mode) != kind:
        raise UntrustedError(f"{path} is no {'directory' if kind == stat.S_IFDIR else 'file'}")
    if facts.st_uid != os.geteuid():
        raise UntrustedError(f"{path} belongs to user {facts.st_uid}, not to {os.geteuid()}")
    if facts.st_mode & _OTHERS:
        raise UntrustedError(f"{path} can be written by others (mode {stat.S_IMODE(facts.st_mode):o})")


def _digest(path: Path, code: bytes) -> bytes:
    return hashlib.sha256(path.name.encode() + code).digest()
