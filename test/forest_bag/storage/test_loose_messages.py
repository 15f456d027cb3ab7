"""Messages outside of chunks, as other writers leave them, are read in pieces of bounded size."""

import pytest
from mcap.writer import Writer

from forest_bag.storage import mcap_reader
from forest_bag.storage.mcap_reader import McapPieces

TIMES = [30, 10, 20, 60, 50, 40, 70]
MESSAGE = 9 + 22 + 100  # bytes of a record: head, fields, data


@pytest.fixture
def file(tmp_path):
    """A file of loose messages; the last two are behind a record of metadata, and it has no end."""
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start()
        channel = writer.register_channel("/a", "cdr", writer.register_schema("pkg/msg/A", "ros2msg", b""))
        for count, time in enumerate(TIMES):
            if count == 5:
                writer.add_metadata("note", {})
            writer.add_message(channel, time, bytes([count]) * 100, time, count)
    return tmp_path / "a.mcap"


@pytest.mark.parametrize(
    ("most", "sizes"), [(1 << 20, [5, 2]), (2 * MESSAGE, [3, 2, 2]), (2 * MESSAGE - 1, [2, 2, 1, 2])]
)
def test_loose_messages_are_read_in_pieces(file, monkeypatch, most, sizes):
    monkeypatch.setattr(mcap_reader, "LOOSE_BYTES", most)
    reader = McapPieces(file, file)
    ends, begin = [], 0
    for size in sizes:
        times = TIMES[begin : begin + size]
        ends.append((min(times), max(times), size * MESSAGE))
        begin += size
    assert [(piece.first_ns, piece.last_ns, piece.length) for piece in reader.pieces] == ends
    assert [m.log_ns for piece in reader.pieces for m in reader.read(piece)] == TIMES
    assert not reader.complete
    reader.close()
