"""An MCAP file is whole at every instant, to readers that nobody here wrote."""

import contextlib
import errno
import os
import random
import threading
import zlib

import pytest
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Chunk, ChunkIndex, MessageIndex
from mcap.stream_reader import StreamReader, breakup_chunk

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.mcap_chunk import COMPRESSIONS, OpenChunk
from forest_bag.storage.mcap_file import McapFile
from forest_bag.storage.mcap_records import footer
from forest_bag.storage.metadata import FileEntry
from forest_bag.storage.raw_messages import Damaged


def written(path, count=300, **options):
    file = McapFile(path, chunk_bytes=2000, **options)
    schema = file.add_schema("std_msgs/msg/String", "ros2msg", b"string data")
    channels = [file.add_channel(f"/text_{number}", schema, {"key": "värde"}) for number in range(3)]
    generator = random.Random(7)
    for step in range(count):
        data = generator.randbytes(generator.randrange(200))
        file.add_message(channels[step % 2], 1000 + step, data, 900 + step, step)
    return file


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_mcap_s_readers_find_every_message_by_the_index_and_in_the_stream(tmp_path, compression):
    file = written(tmp_path / "a.mcap", compression=compression, durable=True)
    file.attach("machine.yaml", "application/yaml", b"name: c180", 5)
    file.note("versions", {"python": "3"})
    file.finish()
    with (tmp_path / "a.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        statistics = reader.get_summary().statistics
        chosen = [m.sequence for _, _, m in reader.iter_messages(topics=["/text_1"])]
        (attachment,) = reader.iter_attachments()
        (note,) = reader.iter_metadata()
    assert chosen == list(range(1, 300, 2))
    assert (statistics.message_count, statistics.channel_count) == (300, 3)
    assert statistics.channel_message_counts == {1: 150, 2: 150, 3: 0}
    assert (statistics.message_start_time, statistics.message_end_time) == (1000, 1299)
    assert statistics.chunk_count > 5
    assert (attachment.data, note.metadata) == (b"name: c180", {"python": "3"})
    with (tmp_path / "a.mcap").open("rb") as stream:
        found = NonSeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False)
        assert [(m.log_time, m.publish_time) for _, _, m in found] == [
            (1000 + step, 900 + step) for step in range(300)
        ]


def test_summary_offsets_and_message_indexes_point_at_their_records(tmp_path):
    written(tmp_path / "a.mcap").finish()
    data = (tmp_path / "a.mcap").read_bytes()
    with (tmp_path / "a.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
        stream.seek(0)
        offsets = [r for r in StreamReader(stream).records if hasattr(r, "group_opcode")]
    for chunk in summary.chunk_indexes:
        assert data[chunk.chunk_start_offset] == 0x06
        after = chunk.chunk_start_offset + chunk.chunk_length
        assert min(chunk.message_index_offsets.values()) == after
        for channel, place in chunk.message_index_offsets.items():
            assert data[place] == 0x07
            assert int.from_bytes(data[place + 9 : place + 11], "little") == channel
    for offset in offsets:
        assert data[offset.group_start] == offset.group_opcode


def records_of(data):
    """Opcode, begin and end of each record, by the MCAP specification: opcode, length, content."""
    place = 8
    while place < len(data) - 8:
        end = place + 9 + int.from_bytes(data[place + 1 : place + 9], "little")
        yield data[place], place, end
        place = end


def number(data, place, size=4):
    return int.from_bytes(data[place : place + size], "little")


def test_the_checksums_of_summary_and_attachments_are_those_of_the_specification(tmp_path):
    """mcap's own reader tests the chunks' only, so these are computed from the bytes."""
    file = written(tmp_path / "a.mcap")
    for name, content in (
        ("machine.yaml", b"name: c180"),
        ("empty", b""),
        ("large", bytes(range(256)) * 100),
    ):
        file.attach(name, "application/yaml", content, 5)
    file.finish()
    data = (tmp_path / "a.mcap").read_bytes()
    records = list(records_of(data))
    opcode, footer, end = records[-1]
    assert (opcode, end) == (0x02, len(data) - 8)
    summary = number(data, footer + 9, 8)
    assert summary in [begin for _, begin, _ in records]
    assert number(data, end - 4) == zlib.crc32(data[summary : end - 4]) != 0
    attachments = [(begin + 9, end) for opcode, begin, end in records if opcode == 0x09]
    assert len(attachments) == 3
    for begin, end in attachments:
        assert number(data, end - 4) == zlib.crc32(data[begin : end - 4]) != 0


def read_records(path):
    with path.open("rb") as stream:
        return [*StreamReader(stream, emit_chunks=True).records]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_every_index_tells_where_its_messages_are_and_how_large_its_chunk_is(tmp_path, compression):
    file = McapFile(tmp_path / "a.mcap", compression)
    schema = file.add_schema("std_msgs/msg/String", "ros2msg", b"string data")
    channels = [file.add_channel(f"/{name}", schema, {}) for name in "ab"]
    times = [[30, 10, 20, 50], [5, 40], [70]]
    for chunk in times:
        for time in chunk:
            file.add_message(channels[time % 20 == 0], time, bytes(time), time + 1, 2**32 + time)
        file.flush()
    assert file.entry == FileEntry("a.mcap", 5, 70, 7)
    file.finish()
    data, records = (tmp_path / "a.mcap").read_bytes(), read_records(tmp_path / "a.mcap")
    chunks = [record for record in records if isinstance(record, Chunk)]
    entries = [record for record in records if isinstance(record, ChunkIndex)]
    for chunk, entry, expected in zip(chunks, entries, times, strict=True):
        assert (entry.message_start_time, entry.message_end_time) == (min(expected), max(expected))
        assert (entry.compression, entry.compressed_size, entry.uncompressed_size) == (
            "" if compression == "none" else compression,
            len(chunk.data),
            chunk.uncompressed_size,
        )
        begin = entry.chunk_start_offset
        assert entry.chunk_length == 9 + number(data, begin + 1, 8)
        assert (chunk.message_start_time, chunk.message_end_time) == (min(expected), max(expected))
        indexes = range(begin + entry.chunk_length, begin + entry.chunk_length + entry.message_index_length)
        assert next(iter(entry.message_index_offsets.values())) == indexes.start
        assert data[indexes.stop] != 0x07  # the next record is no index
        messages = breakup_chunk(chunk, validate_crc=True)
        assert [m.log_time for m in messages] == expected
        assert [(m.publish_time, m.sequence, len(m.data)) for m in messages] == [
            (t + 1, t, t) for t in expected
        ]
    found = {}
    for index in (record for record in records if isinstance(record, MessageIndex)):
        found.setdefault(index.channel_id, []).append(index.records)
    lengths = [[9 + 22 + time for time in chunk] for chunk in times]
    for channel in channels:
        told = [
            [(time, sum(sizes[:k])) for k, time in enumerate(chunk) if channels[time % 20 == 0] == channel]
            for chunk, sizes in zip(times, lengths, strict=True)
        ]
        assert found[channel] == [chunk for chunk in told if chunk]


def test_the_summary_tells_each_attachment_and_note_and_counts_all(tmp_path):
    file = McapFile(tmp_path / "a.mcap", library="of ours")
    schemas = [file.add_schema(f"pkg/msg/{name}", "ros2msg", b"") for name in "AB"]
    assert [file.add_channel("/a", schemas[1], {"key": "value"}), file.add_channel("/b", 2, {}, "json")] == [
        1,
        2,
    ]
    file.attach("machine.yaml", "application/yaml", b"name: c180", 5)
    file.note("versions", {"python": "3"})
    file.attach("empty", "", b"", 7)
    file.finish(lambda: {"version": 9})
    file.finish(pytest.fail)  # a second call does nothing
    data = (tmp_path / "a.mcap").read_bytes()
    with (tmp_path / "a.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        notes = [(note.name, note.metadata) for note in reader.iter_metadata()]
    assert (header.profile, header.library) == ("ros2", "of ours")
    assert notes == [("versions", {"python": "3"}), ("rosbag2", {"serialized_metadata": "version: 9\n"})]
    one, two = summary.attachment_indexes
    assert (one.name, one.media_type, one.data_size, one.log_time, one.create_time) == (
        *("machine.yaml", "application/yaml", 10, 5, 5),
    )
    assert (two.name, two.media_type, two.data_size, two.log_time) == ("empty", "", 0, 7)
    for opcode, index in ((0x09, one), (0x09, two), *((0x0C, note) for note in summary.metadata_indexes)):
        assert data[index.offset] == opcode
        assert index.length == 9 + number(data, index.offset + 1, 8)
    assert [index.name for index in summary.metadata_indexes] == ["versions", "rosbag2"]
    s = summary.statistics
    assert (s.attachment_count, s.metadata_count, s.channel_count, s.schema_count) == (2, 2, 2, 2)
    assert (s.chunk_count, s.message_count, s.message_start_time, s.message_end_time) == (0, 0, 0, 0)
    channels = summary.channels
    assert [(c.schema_id, c.message_encoding, c.metadata) for c in channels.values()] == [
        (2, "cdr", {"key": "value"}),
        (2, "json", {}),
    ]
    assert file.entry == FileEntry("a.mcap", 0, 0, 0)


def test_an_open_chunk_has_the_size_of_its_records_and_of_their_index():
    chunk = OpenChunk()
    for size in (0, 100):
        chunk.add(1, 5, bytes(size), 5, 1)
    assert chunk.size == 2 * (9 + 22 + 16) + 100
    file_size = 2 * (9 + 22) + 100
    sealed = chunk.sealed("none", lambda data: data, 0)
    assert (sealed.first_ns, sealed.last_ns, sealed.counts) == (5, 5, {1: 2})
    assert number(sealed.records, 9 + 16, 8) == file_size


def test_a_growing_file_counts_what_is_to_come_with_it(tmp_path):
    """The open chunk as it is, a kibibyte for the end, and definitions, which stand in the summary again."""
    file = McapFile(tmp_path / "a.mcap")
    begun = (tmp_path / "a.mcap").stat().st_size
    assert file.size == begun + 1024
    assert file._file._syncer is None  # nobody asked for a file that survives a power cut
    channel = file.add_channel("/a", file.add_schema("pkg/msg/A", "ros2msg", bytes(1000)), {})
    defined = (tmp_path / "a.mcap").stat().st_size - begun
    assert file.size == begun + 3 * defined + 1024
    file.add_message(channel, 5, bytes(100), 5, 1)
    assert file.size == begun + 3 * defined + 1024 + 9 + 22 + 16 + 100
    file.flush()
    assert file.size == (tmp_path / "a.mcap").stat().st_size + 2 * defined + 1024 + 87  # of the chunk's index
    file.finish()


def test_a_chunk_is_written_when_it_is_as_large_as_is_allowed(tmp_path):
    file = McapFile(tmp_path / "a.mcap", chunk_bytes=2 * (9 + 22 + 16))
    channel = file.add_channel("/a", file.add_schema("pkg/msg/A", "ros2msg", b""), {})
    for count in range(1, 6):
        file.add_message(channel, count, b"", 0, 0)
        assert (file.chunks, file.message_count) == (count // 2, count // 2 * 2)
    assert not file.finished
    file.finish()
    assert (file.finished, file.chunks, file.message_count) == (True, 3, 5)
    assert file.size == (tmp_path / "a.mcap").stat().st_size


def test_a_changed_byte_of_summary_or_attachment_is_noticed_by_our_reader(tmp_path):
    file = written(tmp_path / "a.mcap")
    file.attach("machine.yaml", "application/yaml", b"name: c180", 5)
    file.finish()
    whole = (tmp_path / "a.mcap").read_bytes()
    summary = number(whole, len(whole) - 8 - 20, 8)
    places = {
        "its index is damaged": whole.index(b"/text_1", summary) + 6,
        "the attachment's checksum is wrong": whole.index(b"name: c180") + 8,
    }
    for problem, place in places.items():
        changed = bytearray(whole)
        changed[place] ^= 1
        (tmp_path / "b.mcap").write_bytes(changed)
        with pytest.raises(Damaged, match=problem):
            BagReader(tmp_path / "b.mcap")
        with BagReader(tmp_path / "b.mcap", lenient=True) as bag:
            assert list(bag.channels) == ["/text_0", "/text_1", "/text_2"]
            assert sum(1 for _ in bag.messages()) == 300


class FullDisk:
    """Takes so many bytes, and of a write that does not fit the part that does, as a disk does."""

    def __init__(self, left):
        self.left, self.write = left, os.write

    def __call__(self, descriptor, data):
        if self.left <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        taken = self.write(descriptor, data[: self.left])
        self.left -= taken
        return taken


@pytest.mark.parametrize("left", [0, 1, 500, 3000, 20_000])
def test_on_a_full_disk_the_file_ends_after_its_last_whole_record(tmp_path, monkeypatch, left):
    file = written(tmp_path / "a.mcap", 50)
    file.flush()
    before = file.message_count
    monkeypatch.setattr("forest_bag.storage.append_file.os.write", FullDisk(left))

    def fill():
        for step in range(1000):
            file.add_message(1, 2000 + step, bytes(100) + random.Random(step).randbytes(99), 0, step)

    with pytest.raises(OSError, match="No space left") as raised:
        fill()
    assert raised.value.filename == str(tmp_path / "a.mcap")
    kept = file.message_count
    assert kept >= before == 50
    with contextlib.suppress(OSError):
        file.finish()
    with (tmp_path / "a.mcap").open("rb") as stream:
        reader = NonSeekingReader(stream).iter_messages(log_time_order=False)
        assert len([next(reader) for _ in range(kept)]) == kept


def test_the_space_held_for_the_summary_lets_a_file_on_a_full_disk_end_well(tmp_path, monkeypatch):
    """The disk is full for messages, but not once the reserve was given back."""
    file = written(tmp_path / "a.mcap", 50)
    file.flush()
    disk, reserve = FullDisk(0), file._file._reserve
    monkeypatch.setattr("forest_bag.storage.append_file.os.write", disk)
    release = reserve.close

    def give_back():
        disk.left += 0 if reserve.closed else 16 * 1024
        release()

    monkeypatch.setattr(file._file, "release", give_back)
    file.add_message(1, 2000, b"refused", 0, 0)
    with pytest.raises(OSError, match="No space left"):
        file.finish()
    with (tmp_path / "a.mcap").open("rb") as stream:
        assert make_reader(stream).get_summary().statistics.message_count == 50


def test_where_a_summary_does_not_fit_a_file_ends_well_without_one(tmp_path, monkeypatch):
    file = written(tmp_path / "a.mcap", 50)
    file.flush()
    append = file._file.append

    def nearly_full(piece):
        if len(piece) > 100:
            raise OSError(errno.ENOSPC, "No space left on device")
        append(piece)

    monkeypatch.setattr(file._file, "append", nearly_full)
    file.finish()
    data = (tmp_path / "a.mcap").read_bytes()
    end = len(data) - 8 - 29
    assert footer(data) == (end, end, 0)  # no summary, and no checksum of one
    assert data[end - 13] == 0x0F
    with (tmp_path / "a.mcap").open("rb") as stream:
        assert sum(1 for _ in NonSeekingReader(stream).iter_messages(log_time_order=False)) == 50
    with BagReader(tmp_path / "a.mcap") as bag:
        assert sum(1 for _ in bag.messages()) == 50


def test_the_space_held_grows_with_all_that_the_summary_repeats(tmp_path, monkeypatch):
    """A chunk's index entry is of 87 bytes: head 9, times and places 36, a channel 10, sizes 24, zstd 8."""
    file, held = McapFile(tmp_path / "a.mcap"), []
    monkeypatch.setattr(file._file, "keep_free", held.append)
    before = file._file.size
    channel = file.add_channel("/a", file.add_schema("pkg/msg/A", "ros2msg", bytes(1000)), {})
    defined = file._file.size - before
    for step in range(3):
        file.add_message(channel, step, b"", 0, 0)
        file.flush()
    assert held == [16 * 1024 + 2 * defined + chunks * 87 for chunks in (1, 2, 3)]
    file.finish()


def test_the_disk_s_refusal_to_sync_is_told_at_a_later_flush(tmp_path, monkeypatch, wait_until):
    def broken(_descriptor):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr("forest_bag.storage.append_file.os.fdatasync", broken)
    file = written(tmp_path / "a.mcap", 10, durable=True)
    file.flush()
    syncer = file._file._syncer
    wait_until(lambda: syncer._error)
    file.add_message(1, 2000, b"", 0, 0)
    with pytest.raises(OSError, match="Input/output error"):
        file.flush()
    file.finish()


def test_every_flush_that_has_something_new_is_forced_to_the_disk_by_another_thread(
    tmp_path, monkeypatch, wait_until
):
    synced = []
    monkeypatch.setattr(
        "forest_bag.storage.append_file.os.fdatasync",
        lambda descriptor: synced.append((os.fstat(descriptor).st_size, threading.current_thread().name)),
    )
    file = written(tmp_path / "a.mcap", 10, durable=True)
    for count in range(1, 4):
        file.flush()
        wait_until(lambda count=count: len(synced) == count)
        assert synced[-1] == ((tmp_path / "a.mcap").stat().st_size, "bag-sync")
        file.flush()  # nothing new
        file.add_message(1, 2000 + count, b"", 0, 0)
    file.finish()
    assert len(synced) == 3


def test_an_unknown_compression_is_refused_with_those_there_are(tmp_path):
    with pytest.raises(ValueError, match="'gzip'; allowed: none, lz4, zstd"):
        McapFile(tmp_path / "a.mcap", compression="gzip")
    assert not (tmp_path / "a.mcap").exists()
