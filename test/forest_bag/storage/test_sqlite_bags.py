"""Databases of rosbag2 are read wherever they lie and however they were left; nothing is left beside them."""

import shutil
import sqlite3

import pytest

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage import sqlite_reader
from forest_bag.storage.raw_messages import Damaged

TEXT = "std_msgs/msg/String"
TABLES = (
    "CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)",
    "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)",
    f"INSERT INTO topics VALUES (1, '/a', '{TEXT}', 'cdr')",
)
# Longer than its own companions' names may be: SQLite cannot make them, as on read-only media.
LONGEST = "b" * 250 + ".db3"


def opened(file, mode="DELETE"):
    """A database that is being recorded: three messages at 1, 2, 3 ns are committed."""
    database = sqlite3.connect(file)
    database.execute(f"PRAGMA journal_mode={mode}")
    database.execute("PRAGMA cache_size=5")  # pages: what is more is written before it is committed
    for statement in TABLES:
        database.execute(statement)
    add(database, [(number, 1, number, b"x") for number in (1, 2, 3)])
    database.commit()
    return database


def add(database, rows):
    database.executemany("INSERT INTO messages VALUES (?, ?, ?, ?)", rows)


def read(file, **options):
    """Log times, notes and problems."""
    with BagReader(file, **options) as bag:
        return [message.log_ns for message in bag.messages()], bag.notes, bag.problems


def names(directory):
    return sorted(file.name for file in directory.iterdir())


def test_messages_of_a_topic_that_is_not_there_are_told_and_cost_no_other(tmp_path):
    database = opened(tmp_path / "bag.db3")
    add(
        database,
        [(4, 3, 4, b"lost"), (5, 3, 5, b"lost"), (6, 1, 6, b"x"), (7, 1, "noon", b"x"), (8, 1, 8, None)],
    )
    database.commit()
    database.close()
    times, _, problems = read(tmp_path / "bag.db3", lenient=True)
    assert times == [1, 2, 3, 6]
    told = "\n".join(problems)
    assert "bag.db3 is damaged: 2 of its messages name topic_id 3, which is not in its table" in told
    assert "1 of its messages have a timestamp of kind text and data of kind blob" in told
    assert "1 of its messages have a timestamp of kind integer and data of kind null" in told
    with pytest.raises(Damaged, match=r"\d of its messages") as refused:
        BagReader(tmp_path / "bag.db3")
    assert "forest-bag recover" not in str(refused.value)  # it could do nothing


def test_a_message_that_would_take_the_memory_is_told_and_costs_no_other(tmp_path, monkeypatch):
    monkeypatch.setattr(sqlite_reader, "LARGEST", 100)
    database = opened(tmp_path / "bag.db3")
    add(database, [(4, 1, 4, bytes(100)), (5, 1, 5, bytes(101)), (6, 1, 6, b"x")])
    database.commit()
    database.close()
    times, _, problems = read(tmp_path / "bag.db3", lenient=True)
    assert times == [1, 2, 3, 4, 6]
    (told,) = problems
    assert "1 of its messages have more than the 100 bytes" in told


@pytest.mark.parametrize(("most", "lengths"), [(100, [5, 4, 1]), (60, [4, 1, 1, 3, 1])])
def test_large_messages_are_read_few_at_a_time(tmp_path, monkeypatch, most, lengths):
    monkeypatch.setattr(sqlite_reader, "BYTES", most)
    database = opened(tmp_path / "bag.db3")
    add(database, [(row, 1, time, bytes(60)) for row, time in enumerate([4, 5, 6, 7, 7, 7, 8], start=4)])
    database.commit()
    database.close()
    with BagReader(tmp_path / "bag.db3") as bag:
        assert [piece.length for piece in bag.files[0].pieces] == lengths
        assert [message.log_ns for message in bag.messages()] == [1, 2, 3, 4, 5, 6, 7, 7, 7, 8]


def test_messages_of_a_piece_come_in_the_order_of_their_times_however_they_were_written(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(sqlite_reader, "MESSAGES", 3)
    database = opened(tmp_path / "bag.db3")
    add(database, [(row, 1, time, b"x") for row, time in enumerate([9, 5, 7, 4, 8, 6], start=4)])
    database.commit()
    database.close()
    with BagReader(tmp_path / "bag.db3") as bag:
        file = bag.files[0]
        assert [(p.first_ns, p.last_ns, p.offset, p.length) for p in file.pieces] == [
            (1, 3, 0, 3),
            (4, 6, 3, 3),
            (7, 9, 6, 3),
        ]
        assert [[m.log_ns for m in file.read(piece)] for piece in file.pieces] == [
            [1, 2, 3],
            [4, 5, 6],
            [7, 8, 9],
        ]
        (one,) = {(m.publish_ns - m.log_ns, m.sequence) for m in file.read(file.pieces[0])}
        assert one == (0, 0)  # neither was ever kept


def test_a_topic_without_a_name_or_a_type_is_none(tmp_path):
    database = opened(tmp_path / "bag.db3")
    database.execute("INSERT INTO topics VALUES (2, NULL, 'std_msgs/msg/String', 'cdr')")
    database.commit()
    database.close()
    with BagReader(tmp_path / "bag.db3") as bag:
        assert list(bag.channels) == ["/a"]


def test_a_closed_database_in_wal_mode_is_read_where_nothing_can_be_written(tmp_path):
    opened(tmp_path / "wal.db3", "WAL").close()
    shutil.copy(tmp_path / "wal.db3", tmp_path / LONGEST)
    assert read(tmp_path / LONGEST) == ([1, 2, 3], [], [])


def test_nothing_is_left_beside_a_database_in_wal_mode(tmp_path):
    opened(tmp_path / "bag.db3", "WAL").close()
    assert names(tmp_path) == ["bag.db3"]
    with BagReader(tmp_path / "bag.db3") as bag:
        assert [message.log_ns for message in bag.messages()] == [1, 2, 3]
        assert names(tmp_path) == ["bag.db3"]
    assert names(tmp_path) == ["bag.db3"]


@pytest.mark.parametrize("index", [True, False], ids=["with its index", "without"])
def test_what_a_killed_recorder_had_in_its_log_is_read(tmp_path, index):
    killed = tmp_path / "killed"
    recorder = opened(tmp_path / "bag.db3", "WAL")
    killed.mkdir()
    for file in tmp_path.glob("bag.db3*"):
        shutil.copy(file, killed)
    recorder.close()
    if not index:
        (killed / "bag.db3-shm").unlink()
    before = names(killed)
    assert "bag.db3-wal" in before
    times, notes, problems = read(killed / "bag.db3")
    assert (times, problems) == ([1, 2, 3], [])
    assert notes == ["bag.db3 was not closed: it is read together with bag.db3-wal"]
    assert names(killed) == before


def test_a_recorder_at_work_in_wal_mode_is_not_disturbed(tmp_path):
    recorder = opened(tmp_path / "bag.db3", "WAL")
    with BagReader(tmp_path / "bag.db3") as bag:
        add(recorder, [(4, 1, 4, b"x")])
        recorder.commit()
        assert len(list(bag.messages())) == 3
    assert read(tmp_path / "bag.db3")[0] == [1, 2, 3, 4]
    recorder.close()


def test_a_change_that_was_half_written_when_the_recorder_was_killed_is_undone_in_a_copy(tmp_path):
    killed = tmp_path / "killed"
    recorder = opened(tmp_path / "bag.db3")
    add(recorder, [(number, 1, number, bytes(3000)) for number in range(4, 200)])
    recorder.execute("UPDATE messages SET timestamp = 7")
    killed.mkdir()
    for file in tmp_path.glob("bag.db3*"):
        shutil.copy(file, killed)
    recorder.close()
    before = {file.name: file.read_bytes() for file in killed.iterdir()}
    assert len(before) == 2
    times, notes, _ = read(killed / "bag.db3")
    assert times == [1, 2, 3]
    assert notes == ["bag.db3 was not closed: it is read together with bag.db3-journal"]
    assert {file.name: file.read_bytes() for file in killed.iterdir()} == before


def test_pages_that_do_not_fit_together_are_found_by_the_check(tmp_path):
    database = opened(tmp_path / "bag.db3")
    add(database, [(number, 1, number, bytes(3000)) for number in range(4, 40)])
    database.commit()
    database.close()
    with BagReader(tmp_path / "bag.db3") as bag:
        bag.check()
    whole = bytearray((tmp_path / "bag.db3").read_bytes())
    last = len(whole) - 4096
    whole[last : last + 100] = bytes(100)
    (tmp_path / "bag.db3").write_bytes(whole)
    with pytest.raises(Damaged, match=r"bag\.db3"), BagReader(tmp_path / "bag.db3") as bag:
        bag.check()


def test_a_name_that_is_no_text_is_damage_and_no_traceback(tmp_path):
    """SQLite's complaint quotes it; found by fuzzing."""
    opened(tmp_path / "bag.db3").close()
    whole = (tmp_path / "bag.db3").read_bytes()
    (tmp_path / "bag.db3").write_bytes(whole.replace(b"CREATE TABLE topics", b"CREATE \xbaABLE topics"))
    with pytest.raises(Damaged, match=r"bag\.db3 is not a readable database of rosbag2's: ."):
        BagReader(tmp_path / "bag.db3")
