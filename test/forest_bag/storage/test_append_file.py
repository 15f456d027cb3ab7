"""A file that is appended to: whole pieces, space held for later, forced to the disk beside the writer."""

import errno
import os
import stat

import pytest

from forest_bag.storage import append_file
from forest_bag.storage.append_file import AppendFile

FULL = OSError(errno.ENOSPC, "No space left on device")


def broken(error):
    def call(*_):
        raise error

    return call


def test_pieces_that_the_system_takes_in_parts_stand_one_behind_the_other(tmp_path, monkeypatch):
    write = os.write
    monkeypatch.setattr(append_file.os, "write", lambda at, data: write(at, bytes(data[:3])))
    file = AppendFile(tmp_path / "a", durable=False)
    for piece in (b"seven b", b"", b"ytes"):
        file.append(piece)
    assert file.size == 11
    with monkeypatch.context() as disk:
        parts = iter((b"ha", b""))
        disk.setattr(append_file.os, "write", lambda at, _: write(at, next(parts)) or broken(FULL)())
        with pytest.raises(OSError, match="No space") as refused:
            file.append(b"half of it")
    assert refused.value.filename == str(tmp_path / "a")
    assert (tmp_path / "a").read_bytes() == b"seven bytes"
    file.append(b"!")
    assert not file.closed
    file.close()
    file.close()
    assert file.closed
    assert (tmp_path / "a").read_bytes() == b"seven bytes!"
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) & ~0o022 == 0o644 & ~0o022
    with pytest.raises(FileExistsError):
        AppendFile(tmp_path / "a", durable=False)


def test_twice_what_is_asked_for_is_held_and_held_once(tmp_path, monkeypatch):
    held = []
    monkeypatch.setattr(append_file.os, "posix_fallocate", lambda _, start, size: held.append((start, size)))
    file = AppendFile(tmp_path / "a", durable=False)
    for size in (100, 200, 201):
        file.keep_free(size)
    assert held == [(0, 200), (0, 402)]
    monkeypatch.setattr(append_file.os, "posix_fallocate", broken(FULL))
    with pytest.raises(OSError, match="No space"):
        file.keep_free(403)
    monkeypatch.setattr(append_file.os, "posix_fallocate", broken(OSError(errno.EOPNOTSUPP, "not here")))
    file.keep_free(403)  # a file system that does not know how
    file.release()
    assert file._reserve.closed
    file.close()


def test_what_was_written_is_forced_to_the_disk_once_and_a_broken_disk_is_told(
    tmp_path, monkeypatch, wait_until
):
    forced = []
    monkeypatch.setattr(append_file.os, "fdatasync", forced.append)
    file = AppendFile(tmp_path / "a", durable=True)
    with monkeypatch.context() as asked:
        asked.setattr(file._syncer, "request", lambda: pytest.fail("there is nothing to force"))
        file.sync_soon()
    file.append(b"x")
    file.sync_soon()
    wait_until(lambda: forced)
    file.sync_soon()
    monkeypatch.setattr(append_file.os, "fdatasync", broken(FULL))
    file.append(b"y")
    file.sync_soon()
    wait_until(lambda: file._syncer._error)
    assert len(forced) == 1
    file.append(b"z")
    with pytest.raises(OSError, match="No space"):
        file.sync_soon()
    thread, own = file._syncer, file._syncer._descriptor
    assert own != file._descriptor
    assert thread.daemon  # who ends without closing does not wait for it
    file.close()
    assert not thread.is_alive()
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(own)
    quick = AppendFile(tmp_path / "b", durable=False)
    quick.append(b"x")
    quick.sync_soon()
    assert quick._syncer is None
    quick.close()
