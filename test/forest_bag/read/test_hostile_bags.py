"""Bags that were made to take a reader's memory are refused in a sentence before they get it."""

import contextlib
import resource
import sqlite3
import struct
import subprocess
import sys
from itertools import pairwise

import lz4.frame
import pytest
import zstandard
from mcap.records import Chunk

from forest_bag.read import bag_reader
from forest_bag.read.bag_reader import BagReader
from forest_bag.storage import decompression
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.decompression import LARGEST, unlz4, unzstd, unzstd_file
from forest_bag.storage.mcap_records import chunk_records
from forest_bag.storage.raw_messages import Damaged

SMALL = 1 << 16  # [byte]
ZEROS = bytes(SMALL)
TOO_MUCH = "it would take more than"
PACKERS = {"zstd": zstandard.ZstdCompressor().compress, "lz4": lz4.frame.compress}
UNPACKERS = {"zstd": unzstd, "lz4": unlz4}


@pytest.mark.parametrize("kind", PACKERS)
def test_what_fits_is_decompressed_and_one_byte_more_is_refused(kind):
    packed = PACKERS[kind](ZEROS)
    assert UNPACKERS[kind](packed, SMALL) == ZEROS
    with pytest.raises(ValueError, match=TOO_MUCH):
        UNPACKERS[kind](packed, SMALL - 1)


@pytest.mark.parametrize("kind", PACKERS)
def test_what_is_cut_off_or_no_frame_is_refused(kind):
    packed = PACKERS[kind](bytes(range(256)) * 256)
    for broken in (packed[:-3], b"no frame at all", b""):
        with pytest.raises(ValueError, match=r"."):
            UNPACKERS[kind](broken, SMALL)


def test_a_zstd_frame_that_does_not_tell_its_size_takes_no_more_than_allowed():
    stream = zstandard.ZstdCompressor(write_content_size=False).compressobj()
    packed = stream.compress(ZEROS) + stream.flush()
    assert zstandard.frame_content_size(packed) == -1
    assert unzstd(packed, SMALL) == ZEROS
    with pytest.raises(ValueError, match=r"."):
        unzstd(packed, SMALL - 1)


@pytest.mark.parametrize("size", [LARGEST + 1, 10 << 30])
def test_a_chunk_that_says_it_is_huge_is_refused_unread(size):
    chunk = Chunk("zstd", PACKERS["zstd"](ZEROS), 0, 0, 0, size)
    with pytest.raises(ValueError, match=f"the chunk says that it has {size} bytes; allowed: {LARGEST}"):
        chunk_records(chunk)


@pytest.mark.parametrize("kind", PACKERS)
def test_a_chunk_that_holds_more_than_it_says_is_refused(kind):
    chunk = Chunk(kind, PACKERS[kind](ZEROS), 0, 0, 0, SMALL // 2)
    with pytest.raises(ValueError, match=f"the chunk cannot be decompressed .{TOO_MUCH}"):
        chunk_records(chunk)


def test_a_file_that_grows_beyond_all_measure_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(decompression, "LARGEST_FILE", SMALL)
    packed = tmp_path / "a.mcap.zstd"
    packed.write_bytes(PACKERS["zstd"](bytes(100 * SMALL)))
    with pytest.raises(ValueError, match=TOO_MUCH):
        unzstd_file(packed, tmp_path / "a.mcap")
    with pytest.raises(Damaged, match=f"it cannot be decompressed .{TOO_MUCH}"):
        BagReader(packed)
    packed.write_bytes(PACKERS["zstd"](ZEROS))
    unzstd_file(packed, tmp_path / "a.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == ZEROS


def test_metadata_that_is_too_large_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(bag_reader, "LARGEST_METADATA", 10)
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: {}")
    (tmp_path / "x_0.mcap").write_bytes(b"")
    with pytest.raises(Damaged, match=r"metadata\.yaml has 31 bytes; allowed: 10"):
        BagReader(tmp_path)


@pytest.mark.parametrize("name", ["../secret/x_0.mcap", "/etc/passwd", "sub/../../secret/x_0.mcap"])
def test_no_path_of_a_bag_leads_out_of_its_folder(tmp_path, name):
    (tmp_path / "secret").mkdir()
    (tmp_path / "secret" / "x_0.mcap").write_bytes(b"secret")
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "metadata.yaml").write_text(
        f"rosbag2_bagfile_information: {{relative_file_paths: [{name}]}}", encoding="utf-8"
    )
    with pytest.raises(BagError, match=f"{bag} lacks {name.rpartition('/')[2]} of its metadata.yaml"):
        BagReader(bag)


READ = """
import sys
from forest_bag.read.bag_reader import BagReader
try:
    with BagReader(sys.argv[1]) as bag:
        print(*(len(message.data) for message in bag.messages()))
except Exception as error:
    print(error)
"""
BY_MESSAGE = "rosbag2_bagfile_information: {compression_mode: MESSAGE, relative_file_paths: [x_0.db3]}"


def aliases(bag):
    names = "abcdefghij"
    rows = ["a: &a [x, x, x, x, x, x, x, x, x]"]
    rows += [f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]" for a, b in pairwise(names)]
    (bag / "x_0.mcap").write_bytes(b"")
    (bag / "metadata.yaml").write_text(
        "\n".join([*rows, "rosbag2_bagfile_information: {relative_file_paths: *j}"])
    )


def zeros(bag):
    (bag / "x_0.mcap").write_bytes(b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, 1 << 40) + bytes(100))


def database(bag, data):
    """Without an index, as rosbag2 has never written one."""
    with contextlib.closing(sqlite3.connect(bag / "x_0.db3")) as database, database:
        database.execute("CREATE TABLE topics (id INTEGER PRIMARY KEY, name, type, serialization_format)")
        database.execute("CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id, timestamp, data)")
        database.execute("INSERT INTO topics VALUES (1, '/a', 'std_msgs/msg/String', 'cdr')")
        rows = [(1, number, one) for number, one in enumerate(data)]
        database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", rows)


def large(bag):
    database(bag, [b"x", bytes(LARGE), b"x"])


def packed(bag):
    database(bag, [PACKERS["zstd"](bytes(LARGE))] * 8)
    (bag / "metadata.yaml").write_text(BY_MESSAGE)


LARGE = 150_000_000  # [byte]
HOSTILE = {
    aliases: "its aliases stand for more than 1000000 values",
    zeros: "damaged",
    large: f"1 {LARGE} 1",
    packed: " ".join([f"{LARGE}"] * 8),
}


@pytest.mark.parametrize("made", HOSTILE, ids=lambda made: made.__name__)
def test_whatever_a_bag_holds_a_gigabyte_is_enough_to_read_or_refuse_it(made, tmp_path):
    def poor():
        resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))

    made(tmp_path)
    told = subprocess.run(
        [sys.executable, "-c", READ, str(tmp_path)], capture_output=True, text=True, check=True,
        timeout=60, preexec_fn=poor,
    )  # fmt: skip
    assert HOSTILE[made] in told.stdout, told
