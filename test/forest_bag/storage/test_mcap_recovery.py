"""Where a recovery takes records for whole, and which bytes it calls damaged."""

import mmap
import struct

import pytest
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import Writer

from forest_bag.storage import mcap_recovery
from forest_bag.storage.mcap_records import records
from forest_bag.storage.mcap_recovery import Damage, RecordRecovery, is_recoverable


def written(path, chunks=True, messages=6):
    with path.open("wb") as stream:
        writer = Writer(stream, use_chunking=chunks)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        channel = writer.register_channel("/a", "cdr", schema, {})
        for step in range(messages):
            writer.add_message(channel, 10 + step, b"%d" % step, 20 + step, 30 + step)
        writer.add_metadata("versions", {"python": "3"})
        writer.finish()
    return path


def place_of(path, opcode):
    """Where the first record of a kind begins."""
    return next(begin - 9 for code, begin, _ in records(path.read_bytes(), 8) if code == opcode)


def read(path):
    recovery = RecordRecovery(path)
    assert (recovery.damages, recovery.complete) == ([], False)  # until it is read
    return recovery, list(recovery)


@pytest.mark.parametrize("chunks", [True, False])
def test_a_whole_file_gives_its_definitions_first_and_is_complete(tmp_path, chunks):
    recovery, found = read(written(tmp_path / "a.mcap", chunks))
    assert (recovery.damages, recovery.complete, recovery.empty) == ([], True, False)
    assert [type(record) for record in found[:2]] == [Schema, Channel]
    messages = [record for record in found if isinstance(record, Message)]
    assert [(m.channel_id, m.log_time, m.publish_time, m.sequence, m.data) for m in messages] == [
        (1, 10 + k, 20 + k, 30 + k, b"%d" % k) for k in range(6)
    ]
    assert [record.name for record in found if isinstance(record, Metadata)] == ["versions"]


@pytest.mark.parametrize("chunks", [True, False])
def test_a_file_without_its_end_is_not_complete_and_has_no_damage(tmp_path, chunks):
    path = written(tmp_path / "a.mcap", chunks)
    path.write_bytes(path.read_bytes()[: place_of(path, Opcode.DATA_END)])
    recovery, found = read(path)
    assert (recovery.damages, recovery.complete) == ([], False)
    assert sum(isinstance(record, Message) for record in found) == 6


def test_a_data_end_of_another_length_is_none_and_what_lies_before_the_next_record_is_damage(tmp_path):
    path = written(tmp_path / "a.mcap")
    data, end = path.read_bytes(), place_of(path, Opcode.DATA_END)
    for length in (3, 5):
        path.write_bytes(data[:end] + struct.pack("<BQ", Opcode.DATA_END, length) + bytes(length))
        recovery, _ = read(path)
        assert recovery.complete is False
    chunk = place_of(written(path), Opcode.CHUNK)  # behind metadata, whose lengths speak for them
    path.write_bytes(data[:chunk] + b"rubbish" + data[chunk:])
    recovery, found = read(path)
    assert (recovery.damages, recovery.complete) == ([Damage(chunk, 7)], True)
    assert sum(isinstance(record, Message) for record in found) == 6


def test_what_begins_without_magic_is_looked_through_all_the_same(tmp_path):
    path = written(tmp_path / "a.mcap")
    path.write_bytes(path.read_bytes()[8:])
    recovery, found = read(path)
    assert recovery.damages == []
    assert sum(isinstance(record, Message) for record in found) == 6


def test_empty_is_what_has_neither_message_nor_attachment(tmp_path):
    assert RecordRecovery(written(tmp_path / "none.mcap", messages=0)).empty
    assert not RecordRecovery(written(tmp_path / "one.mcap", messages=1)).empty
    (tmp_path / "nothing.mcap").touch()
    recovery, found = read(tmp_path / "nothing.mcap")
    assert (found, recovery.empty, recovery.damages) == ([], True, [])
    with (tmp_path / "attached.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.add_attachment(5, 6, "machine.yaml", "application/yaml", b"name: c180")
        writer.finish()
    recovery, found = read(tmp_path / "attached.mcap")
    assert not recovery.empty
    assert [record.data for record in found if isinstance(record, Attachment)] == [b"name: c180"]
    assert is_recoverable(tmp_path / "attached.mcap")
    assert is_recoverable(tmp_path)
    assert not is_recoverable(tmp_path / "none.mcap")
    assert not is_recoverable(tmp_path / "no such")


@pytest.mark.parametrize(
    ("rest", "begins"),
    [
        (b"", True),
        (b"\0", True),
        (bytes(64), True),
        (bytes(63) + b"\1", False),
        (b"\x05", True),  # cut off in its head
        (b"\x05" + b"\xff" * 5, True),
        (b"\x05" + b"\xff" * 5 + bytes(2), True),
        (b"\x05" + b"\xff" * 5 + bytes(3) + b"more", True),
        (b"\x05" + b"\xff" * 6 + bytes(2) + b"more", False),  # no record is so long
        (b"\x0f" + bytes(8), True),
        (b"\x10" + bytes(8), False),
        (b"\x7f" + bytes(8), False),
        (b"\x80" + bytes(8), True),  # anybody's own
        (b"\xff" + bytes(8), True),
    ],
)
def test_a_message_is_whole_where_a_record_or_a_hole_begins_behind_it(tmp_path, rest, begins):
    (tmp_path / "a").write_bytes(b"before" + rest)
    with (
        (tmp_path / "a").open("rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data,
    ):
        assert mcap_recovery._is_beginning(data, 6) == begins


def test_a_head_that_is_cut_off_ends_beyond_the_file(tmp_path):
    head = struct.pack("<BQ", 7, 4)
    (tmp_path / "a").write_bytes(b"before" + head)
    with (
        (tmp_path / "a").open("rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data,
    ):
        assert mcap_recovery._head(data, 6) == (7, 6 + 9 + 4)
        assert mcap_recovery._head(data, 7) == (0, 6 + 9 + 1)
