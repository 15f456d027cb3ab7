"""What an SQLite file of ours holds, by SQLite itself."""

import contextlib
import sqlite3

from forest_bag.storage.metadata import FileEntry
from forest_bag.storage.sqlite_file import SqliteFile

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
