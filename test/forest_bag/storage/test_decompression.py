"""What others compressed is taken up to its bound, and not a byte beyond."""

import lz4.frame
import pytest
import zstandard

from forest_bag.storage import decompression, mcap_reader, sqlite_reader
from forest_bag.storage.decompression import unlz4, unzstd, unzstd_file
from forest_bag.write import bag_split, bag_writer

TEXT = bytes(range(250)) * 4
PACKED = {unzstd: zstandard.compress(TEXT), unlz4: lz4.frame.compress(TEXT)}


@pytest.mark.parametrize("unpack", PACKED)
def test_as_many_bytes_as_are_allowed_are_given_back_and_one_more_is_refused(unpack):
    assert unpack(PACKED[unpack], 1000) == TEXT
    assert unpack(PACKED[unpack]) == TEXT
    with pytest.raises(ValueError, match="more than 999 bytes"):
        unpack(PACKED[unpack], 999)
    for broken in (PACKED[unpack][:-9], b"nothing", b""):
        with pytest.raises(ValueError, match=r"."):
            unpack(broken, 1000)


def test_bounds_are_256_mib_1_gib_and_a_hundredfold():
    d = decompression
    assert (d.LARGEST, d.LARGEST_FILE, d.MOST) == (2**28, 2**30, 100)


def test_pieces_are_of_16_mib_or_2000_messages_of_a_database_and_of_a_mebibyte_of_loose_messages():
    assert (sqlite_reader.BYTES, sqlite_reader.MESSAGES, mcap_reader.LOOSE_BYTES) == (2**24, 2000, 2**20)


def test_a_recorder_flushes_ten_times_a_second_and_a_file_has_three_hours_of_that():
    assert (bag_writer.FLUSH_PERIOD_S, bag_writer.CHUNKS_PER_FILE) == (0.1, 100_000)
    assert bag_split.ONE_FILE == ("zstd", 0, 0, 65_536, False, "mcap", True)


@pytest.mark.parametrize(("largest", "times", "fits"), [(1000, 0, True), (999, 0, False), (0, 30, True)])
def test_a_file_may_hold_so_many_bytes_or_so_many_times_its_own(tmp_path, monkeypatch, largest, times, fits):
    monkeypatch.setattr(decompression, "LARGEST_FILE", largest)
    monkeypatch.setattr(decompression, "MOST", times)
    source, target = tmp_path / "a.zstd", tmp_path / "a"
    source.write_bytes(PACKED[unzstd])
    assert 30 * len(PACKED[unzstd]) >= 1000 > 1 * len(PACKED[unzstd])
    if fits:
        unzstd_file(source, target)
        assert target.read_bytes() == TEXT
        return
    with pytest.raises(ValueError, match=f"more than {largest} bytes"):
        unzstd_file(source, target)
