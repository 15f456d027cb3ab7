"""What an SQLite file of ours holds, by SQLite itself."""

import contextlib
import os
import sqlite3

import pytest

from forest_bag.storage.metadata import FileEntry
from forest_bag.storage.raw_messages import Channel
from forest_bag.storage.sqlite_file import SqliteFile
from forest_bag.storage.sqlite_reader import SqlitePieces

QOS, TEXT = "- depth: 1", "float64 x"


def test_a_file_holds_topics_definitions_messages_and_their_size(tmp_path):
    file = SqliteFile(tmp_path / "a.db3")
    begun = file.size
    channels = []
    for topic in ("/a", "/b"):
        schema = file.add_schema(f"pkg/msg{topic.upper()}", "ros2msg", TEXT.encode())
        told = {"topic_type_hash": "RIHS01_0", "offered_qos_profiles": QOS}
        channels.append(file.add_channel(topic, schema, told))
    assert file.size - begun == 2 * (9 + 10)
    for channel, log_ns, data in ((channels[1], 30, b"abc"), (channels[0], 10, b""), (channels[1], 20, b"z")):
        file.add_message(channel, log_ns, data, 0, 0)
    assert file.size - begun == 2 * (9 + 10) + 3 * 40 + 4
    assert (file.first_ns, file.last_ns, file.counts) == (10, 30, {1: 1, 2: 2})
    file.flush()
    assert not file.finished
    file.finish(lambda: {"version": 9})
    file.finish()
    assert file.finished
    assert file.entry == FileEntry("a.db3", 10, 30, 3)
    with contextlib.closing(sqlite3.connect(tmp_path / "a.db3")) as database:

        def rows(table):
            return database.execute(f"SELECT * FROM {table}").fetchall()

        assert rows("topics") == [
            (1, "/a", "pkg/msg/A", "cdr", QOS, "RIHS01_0"),
            (2, "/b", "pkg/msg/B", "cdr", QOS, "RIHS01_0"),
        ]
        assert rows("message_definitions") == [
            (1, "pkg/msg/A", "ros2msg", TEXT, "RIHS01_0"),
            (2, "pkg/msg/B", "ros2msg", TEXT, "RIHS01_0"),
        ]
        assert rows("messages") == [(1, 2, 30, b"abc"), (2, 1, 10, b""), (3, 2, 20, b"z")]
        assert rows("metadata") == [(1, 9, "version: 9\n")]
        assert SqlitePieces(tmp_path / "a.db3", tmp_path / "a.db3").channels == {
            number: Channel(f"/{name}", f"pkg/msg/{name.upper()}", "cdr", QOS, "RIHS01_0", TEXT, "ros2msg")
            for number, name in ((1, "a"), (2, "b"))
        }
        assert rows("schema") == [(4, os.environ.get("ROS_DISTRO", "jazzy"))]


def test_a_file_that_exists_is_left_alone_and_a_full_disk_closes_one(tmp_path, monkeypatch):
    (tmp_path / "a.db3").write_bytes(b"mine")
    with pytest.raises(FileExistsError):
        SqliteFile(tmp_path / "a.db3")
    assert (tmp_path / "a.db3").read_bytes() == b"mine"
    file = SqliteFile(tmp_path / "b.db3")
    assert (file.size, file.chunks, file.finished) == (0, 0, False)
    assert file.entry == FileEntry("b.db3", 0, 0, 0)
    file._database.execute("ROLLBACK")  # as after an error of the disk: nothing is left to commit
    with pytest.raises(OSError, match=r"b\.db3: cannot commit"):
        file.finish()
    assert file.finished
    with pytest.raises(sqlite3.ProgrammingError, match="closed"):
        file._database.execute("SELECT 1")
