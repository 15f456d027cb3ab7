"""A bag's messages come in the order of their log times from any file, and a damaged one says so."""

import itertools
import sqlite3

import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.raw_messages import Damaged
from forest_msgs_py.interfaces.qos_profiles import offered

TEXT = "std_msgs/msg/String"


def write_mcap(path, times, topics=("/a", "/b"), body=bytes, **options):
    """A file as somebody else's writer makes it: each time a message, the topics by turns."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=200, **options)
        writer.start("ros2", "somebody else")
        schema = writer.register_schema(TEXT, "ros2msg", b"string data")
        metadata = {"offered_qos_profiles": "- depth: 3\n  durability: 1"}
        channels = [writer.register_channel(topic, "cdr", schema, metadata) for topic in topics]
        for number, time in enumerate(times):
            writer.add_message(channels[number % len(channels)], time, body([number % 256]), time + 1, number)
        writer.finish()
    return path


def logged(path, **options):
    with BagReader(path) as bag:
        return [message.log_ns for message in bag.messages(**options)]


SHUFFLED = [30, 10, 20, 60, 50, 40, 90, 70, 80, 5] * 3


@pytest.mark.parametrize(
    "options",
    [
        {"compression": CompressionType.ZSTD},
        {"compression": CompressionType.LZ4},
        {"compression": CompressionType.NONE},
        {"use_chunking": False},
        {"use_statistics": False, "use_summary_offsets": False},
        {"index_types": 0},
    ],
    ids=["zstd", "lz4", "plain", "loose", "no statistics", "no index"],
)
def test_messages_come_in_the_order_of_their_log_times(tmp_path, options):
    if "index_types" in options:
        from mcap.writer import IndexType

        options = {"index_types": IndexType.NONE}
    file = write_mcap(tmp_path / "a.mcap", SHUFFLED, **options)
    assert logged(file) == sorted(SHUFFLED)
    assert logged(file, start_ns=60) == [time for time in sorted(SHUFFLED) if time >= 60]
    assert logged(file, topics={"/a"}) == sorted(SHUFFLED[::2])
    with BagReader(file) as bag:
        assert bag.span == (5, 90)
        assert bag.complete
        assert [channel.type for channel in bag.channels["/b"]] == [TEXT]


def test_splits_overlap_and_are_counted_as_people_count(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    for number in range(12):
        write_mcap(bag / f"bag_{number}.mcap", [10 * number, 10 * number + 25])
    assert logged(bag) == sorted(itertools.chain(range(0, 120, 10), range(25, 145, 10)))
    with BagReader(bag) as reader:
        assert [file.path.name for file in reader.files] == [f"bag_{number}.mcap" for number in range(12)]


def test_whole_files_and_single_messages_may_be_compressed(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    plain = write_mcap(tmp_path / "plain.mcap", [1, 2, 3]).read_bytes()
    (bag / "bag_0.mcap.zstd").write_bytes(zstandard.compress(plain))
    assert logged(bag) == [1, 2, 3]
    by_message = tmp_path / "by_message"
    by_message.mkdir()
    write_mcap(by_message / "x_0.mcap", [1, 2], body=lambda data: zstandard.compress(bytes(data)))
    (by_message / "metadata.yaml").write_text(
        "rosbag2_bagfile_information: {compression_mode: MESSAGE, relative_file_paths: [x_0.mcap]}"
    )
    with BagReader(by_message) as reader:
        assert [message.data for message in reader.messages()] == [b"\x00", b"\x01"]


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
@pytest.mark.parametrize("mode", ["NONE", "MESSAGE", "FILE"])
@pytest.mark.parametrize("version", [8, 9])
def test_bags_of_the_rosbags_library_are_read(tmp_path, storage, mode, version):
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
    from rosbags.typesys import Stores, get_typestore

    never = QosTime(2147483647, 4294967295)
    qos = Qos(
        *(QosHistory.KEEP_LAST, 4, QosReliability.BEST_EFFORT, QosDurability.TRANSIENT_LOCAL),
        *(never, never, QosLiveliness.AUTOMATIC, never, False),
    )
    writer = rosbag2.Writer(
        tmp_path / "bag", version=version, storage_plugin=getattr(rosbag2.StoragePlugin, storage)
    )
    if mode != "NONE":
        compression = getattr(rosbag2.CompressionMode, mode)
        writer.set_compression(compression, rosbag2.CompressionFormat.ZSTD)
    with writer:
        store = get_typestore(Stores.ROS2_JAZZY)
        connection = writer.add_connection("/a", TEXT, typestore=store, offered_qos_profiles=[qos])
        for time in (3, 1, 2):
            writer.write(connection, time, f"message {time}".encode())
    with BagReader(tmp_path / "bag") as bag:
        assert [m.data for m in bag.messages()] == [b"message 1", b"message 2", b"message 3"]
        (channel,) = bag.channels["/a"]
        assert (channel.type, channel.encoding) == (TEXT, "cdr")
        assert [(p.depth, p.reliable, p.transient_local) for p in offered(channel.qos)] == [(4, False, True)]


@pytest.mark.parametrize("columns", ["", ", offered_qos_profiles TEXT, type_description_hash TEXT"])
def test_a_database_of_rosbag2_reads_as_a_file_does(tmp_path, columns):
    file = tmp_path / "bag_0.db3"
    with sqlite3.connect(file) as database:
        database.execute(f"CREATE TABLE topics (id, name, type, serialization_format{columns})")
        database.execute("CREATE TABLE messages (id, topic_id, timestamp, data)")
        values = [1, "/a", TEXT if columns else "std_msgs/String", "cdr", "- depth: 3", "RIHS01_0"][
            : 6 if columns else 4
        ]
        database.execute(f"INSERT INTO topics VALUES ({','.join('?' * len(values))})", values)
        rows = [(number, 1, time, b"x") for number, time in enumerate([7] * 2500 + [3, 9])]
        database.executemany("INSERT INTO messages VALUES (?,?,?,?)", rows)
    database.close()
    assert logged(file) == [3] + [7] * 2500 + [9]
    with BagReader(file) as bag:
        assert bag.channels["/a"][0].qos == ("- depth: 3" if columns else "")
        assert bag.channels["/a"][0].type == TEXT


def test_a_damaged_bag_is_refused_and_gives_what_is_whole_when_asked(tmp_path):
    whole = write_mcap(tmp_path / "whole.mcap", range(0, 1000, 10)).read_bytes()
    cut = tmp_path / "cut.mcap"
    counts = []
    for length in range(0, len(whole), 97):
        cut.write_bytes(whole[:length])
        with pytest.raises(Damaged) as refused:
            BagReader(cut)
        with BagReader(cut, lenient=True) as bag:
            times = [message.log_ns for message in bag.messages()]
            assert ("forest-bag recover" in str(refused.value)) == bool(times)
            assert times == list(range(0, 10 * len(times), 10))
            assert not bag.complete
            counts.append(len(times))
    assert counts == sorted(counts)
    assert counts[-1] == 100


def test_a_changed_byte_in_a_chunk_is_noticed(tmp_path):
    file = write_mcap(tmp_path / "a.mcap", range(100), compression=CompressionType.NONE)
    with BagReader(file) as bag:
        piece = bag.files[0].pieces[2]
    data = bytearray(file.read_bytes())
    data[piece.offset + piece.length - 1] ^= 1
    file.write_bytes(data)
    with pytest.raises(Damaged, match="recover"):
        logged(file)
    with BagReader(file, lenient=True) as bag:
        times = [message.log_ns for message in bag.messages()]
        assert 90 < len(times) < 100
        assert not bag.complete


@pytest.mark.parametrize(
    "options",
    [{}, {"use_chunking": False, "enable_data_crcs": True}, {"enable_crcs": False, "enable_data_crcs": True}],
    ids=["chunks", "loose, one checksum for all", "chunks without checksums, one for all"],
)
def test_a_check_reads_everything_and_finds_one_changed_byte(tmp_path, options):
    file = write_mcap(tmp_path / "a.mcap", range(300), compression=CompressionType.NONE, **options)
    with BagReader(file) as bag:
        bag.check()
        piece = bag.files[0].pieces[-1]
    data = bytearray(file.read_bytes())
    data[piece.offset + piece.length - 1] ^= 1  # the last message's text
    file.write_bytes(data)
    with BagReader(file) as bag, pytest.raises(Damaged, match=r"a\.mcap is damaged"):
        bag.check()
    with BagReader(file, lenient=True) as bag:
        bag.check()
        assert not bag.complete
        assert len(bag.problems) == 1


def test_a_check_decompresses_messages_that_were_compressed_one_by_one(tmp_path):
    write_mcap(tmp_path / "x_0.mcap", [1, 2])
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: {compression_mode: MESSAGE}")
    with BagReader(tmp_path) as bag, pytest.raises(Damaged, match="/a cannot be decompressed"):
        bag.check()


def test_a_message_of_a_channel_that_nothing_declares_is_told(tmp_path):
    file = write_mcap(tmp_path / "a.mcap", range(4), use_chunking=False)
    data = file.read_bytes()
    head = b"\x05" + (22 + 1).to_bytes(8, "little")
    place = data.rindex(head)
    file.write_bytes(data[: place + 9] + b"\x63" + data[place + 10 :])
    for use in (BagReader.check, lambda bag: list(bag.messages())):
        with (
            BagReader(file) as bag,
            pytest.raises(Damaged, match="a message names channel 99, which nothing"),
        ):
            use(bag)


def test_a_message_too_short_to_be_one_ends_what_is_whole(tmp_path):
    file = write_mcap(tmp_path / "a.mcap", range(4), use_chunking=False)
    data = file.read_bytes()
    place = data.rindex(b"\x05" + (22 + 1).to_bytes(8, "little"))
    file.write_bytes(data[:place] + b"\x05" + (3).to_bytes(8, "little") + b"abc")
    with BagReader(file, lenient=True) as bag:
        assert [message.log_ns for message in bag.messages()] == [0, 1, 2]
        assert f"the message at byte {place} has a length of 3 bytes" in bag.problems[0]


def test_a_file_that_metadata_lists_twice_is_read_once(tmp_path):
    write_mcap(tmp_path / "x_0.mcap", [1, 2])
    (tmp_path / "metadata.yaml").write_text(
        "rosbag2_bagfile_information: {relative_file_paths: [x_0.mcap, x_0.mcap]}"
    )
    assert logged(tmp_path) == [1, 2]


def test_what_is_no_bag_is_named(tmp_path):
    (tmp_path / "a.txt").write_text("hello")
    (tmp_path / "b.mcap").write_text("hello, this is text")
    (tmp_path / "c.db3").write_text("hello, this is text")
    (tmp_path / "empty").mkdir()
    for name, problem in [
        ("nowhere", "does not exist"),
        ("a.txt", "is no bag; allowed"),
        ("b.mcap", "is not an MCAP file"),
        ("c.db3", "is not an SQLite"),
        ("empty", "no .mcap file in"),
    ]:
        with pytest.raises(BagError, match=problem):
            BagReader(tmp_path / name)


def test_a_damaged_database_is_refused_with_advice(tmp_path):
    file = tmp_path / "bag_0.db3"
    with sqlite3.connect(file) as database:
        database.execute("CREATE TABLE something (id)")
    database.close()
    with pytest.raises(Damaged, match="is not a readable database of rosbag2's: no such"):
        BagReader(file)


@pytest.mark.parametrize("text", ["a: 2001-99-99", "a: [", "\0"])
def test_metadata_that_is_no_yaml_is_named_with_advice(tmp_path, text):
    write_mcap(tmp_path / "bag_0.mcap", SHUFFLED)
    (tmp_path / "metadata.yaml").write_text(text)
    with pytest.raises(BagError, match=r"metadata.yaml is not YAML: .*; 'forest-bag recover"):
        BagReader(tmp_path)


def test_a_lenient_reader_does_without_metadata_that_is_no_yaml(tmp_path):
    write_mcap(tmp_path / "bag_0.mcap", SHUFFLED)
    (tmp_path / "metadata.yaml").write_text("a: [")
    with BagReader(tmp_path, lenient=True) as bag:
        assert len(list(bag.messages())) == len(SHUFFLED)
        assert not bag.complete
