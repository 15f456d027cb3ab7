"""From a damaged bag comes a whole one, with every message of every whole chunk, for readers of others."""

import contextlib
import random

import pytest
import yaml
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Message, Schema
from mcap.writer import CompressionType, Writer

from forest_bag.recovery import bag_recovery
from forest_bag.recovery.bag_recovery import recover
from forest_bag.storage.bag_files import BagError, bag_files
from forest_bag.storage.mcap_file import McapFile
from forest_bag.storage.mcap_records import HEAD, MAGIC, records
from forest_bag.write.bag_split import Attached, Layout
from forest_bag.write.bag_writer import BagWriter

FOREVER = {"sec": 9223372036, "nsec": 854775807}
QOS = {
    "history": "keep_last",
    "depth": 10,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": FOREVER,
    "lifespan": FOREVER,
    "liveliness": "automatic",
    "liveliness_lease_duration": FOREVER,
    "avoid_ros_namespace_conventions": False,
}
ONE = b"\x00\x01\x00\x00" + bytes(6) + b"\xf0\x3f"  # std_msgs/Float64 1.0 as little-endian CDR


@pytest.fixture(autouse=True)
def quick_disk(monkeypatch):
    """Nobody pulls the plug here."""
    for module in ("append_file", "metadata"):
        monkeypatch.setattr(f"forest_bag.storage.{module}.os.fsync", lambda _: None)


def recorded(directory, compression="zstd", close=True, count=400):
    bag = BagWriter(directory, Layout(compression))
    for name in ("/depth", "/height"):
        bag.add_topic(name, "std_msgs/msg/Float64", [QOS], "")
    bag.attach(Attached("machine.yaml", "application/yaml", b"name: c180", 5))
    for step in range(count):
        bag.write("/depth" if step % 3 else "/height", ONE, 10**9 + step, 10**9 + step, step + 1)
        if step % 25 == 24:
            bag.flush()
    file = directory / f"{directory.name}_0.mcap"
    as_killed = file.read_bytes()
    bag.close()
    if not close:
        file.write_bytes(as_killed)
        (directory / "metadata.yaml").unlink()
    return file


def chunks_of(file):
    """Where each chunk ends, and how many messages it has."""
    with file.open("rb") as stream:
        reader = make_reader(stream)
        indexes = reader.get_summary().chunk_indexes
        times = [m.log_time for _, _, m in reader.iter_messages()]
    return [
        (
            chunk.chunk_start_offset + chunk.chunk_length,
            sum(chunk.message_start_time <= t <= chunk.message_end_time for t in times),
        )
        for chunk in indexes
    ]


def sequences(file):
    with file.open("rb") as stream:
        return [m.sequence for _, _, m in make_reader(stream, validate_crcs=True).iter_messages()]


def count_by_rosbags(directory):
    highlevel = pytest.importorskip("rosbags.highlevel")
    with highlevel.AnyReader([directory]) as reader:
        values = [reader.deserialize(raw, c.msgtype).data for c, _, raw in reader.messages()]
        assert sum(c.msgcount for c in reader.connections) == len(values)
    return len(values)


def count_by_mcap_ros2_support(file):
    reader = pytest.importorskip("mcap_ros2.reader")
    return sum(1 for _ in reader.read_ros2_messages(str(file)))


@pytest.mark.parametrize("compression", ["none", "lz4", "zstd"])
def test_a_bag_cut_off_anywhere_keeps_every_whole_chunk(tmp_path, compression):
    whole = recorded(tmp_path / "bag", compression)
    data, chunks = whole.read_bytes(), chunks_of(whole)
    generator = random.Random(11)
    near = [end + d for end, _ in chunks[:3] for d in (-1, 0, 1)]
    attached = data.index(b"name: c180") + len(b"name: c180") + 4  # with its checksum
    for number, cut in enumerate(
        [8, 9, 40, attached - 1, attached, *near, *generator.sample(range(8, len(data)), 40)]
    ):
        file = tmp_path / f"cut_{number}.mcap"
        file.write_bytes(data[:cut])
        out = tmp_path / f"out_{number}"
        if cut < attached:
            with pytest.raises(BagError, match="holds neither a message nor an attachment"):
                recover([file], out)
            assert not out.exists()
            continue
        recovered = recover([file], out)
        expected = sum(count for end, count in chunks if end <= cut)
        assert recovered.messages == expected
        assert sequences(out / f"out_{number}_0.mcap") == list(range(1, expected + 1))
        if number % 10 == 0 and expected:
            assert count_by_rosbags(out) == expected
            assert count_by_mcap_ros2_support(out / f"out_{number}_0.mcap") == expected


def test_a_bag_that_was_never_closed_recovers_as_what_was_flushed(tmp_path):
    recorded(tmp_path / "bag", close=False, count=110)
    out = tmp_path / "out"
    assert recover(bag_files(tmp_path / "bag"), out).messages == 100
    assert count_by_rosbags(out) == count_by_mcap_ros2_support(out / "out_0.mcap") == 100
    about = yaml.safe_load((out / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    counts = {t["topic_metadata"]["name"]: t["message_count"] for t in about["topics_with_message_count"]}
    assert counts == {"/depth": 66, "/height": 34}
    assert about["topics_with_message_count"][0]["topic_metadata"]["offered_qos_profiles"] == [QOS]
    with (out / "out_0.mcap").open("rb") as stream:
        (attachment,) = make_reader(stream).iter_attachments()
    assert attachment.data == b"name: c180"


@pytest.mark.parametrize("compression", ["none", "zstd"])
def test_damage_in_the_middle_costs_the_chunks_that_it_hit_and_no_other(tmp_path, compression):
    whole = recorded(tmp_path / "bag", compression)
    chunks, generator = chunks_of(whole), random.Random(5)
    for number in range(30):
        data = bytearray(whole.read_bytes())
        start = generator.randrange(8, len(data) - 300)
        length = generator.choice([1, 3, 300])
        data[start : start + length] = bytes(length) if number % 2 else generator.randbytes(length)
        file = tmp_path / f"hit_{number}.mcap"
        file.write_bytes(data)
        begin, expected = 0, 0
        for end, count in chunks:
            expected += 0 if start < end and begin < start + length else count
            begin = end
        assert recover([file], tmp_path / f"out_{number}").messages >= expected


def test_no_bytes_make_it_crash(tmp_path):
    data, generator = recorded(tmp_path / "bag").read_bytes(), random.Random(9)
    for number in range(60):
        damaged = bytearray(data[: generator.randrange(1, len(data))])
        for _ in range(generator.randrange(20)):
            damaged[generator.randrange(len(damaged))] = generator.randrange(256)
        file = tmp_path / f"random_{number}.mcap"
        file.write_bytes(damaged)
        with contextlib.suppress(BagError):
            assert recover([file], tmp_path / f"out_{number}").messages <= 400


def test_a_zeroed_tail_as_a_power_cut_leaves_it_is_skipped(tmp_path):
    whole = recorded(tmp_path / "bag", close=False)
    whole.write_bytes(whole.read_bytes() + bytes(100_000))
    recovered = recover([whole], tmp_path / "out")
    assert recovered.messages == 400
    ((_, recovery),) = recovered.files
    assert [damage.length for damage in recovery.damages] == [100_000]


def heads(data, opcode):
    """Where records of a kind begin, those within chunks left out."""
    return [begin - HEAD.size for code, begin, _ in records(data, len(MAGIC)) if code == opcode]


@pytest.mark.parametrize("byte", range(1, 9))
def test_a_wrong_length_of_an_index_swallows_no_chunk(tmp_path, byte):
    whole = recorded(tmp_path / "bag", close=False)
    data = bytearray(whole.read_bytes())
    for place in heads(bytes(data), Opcode.MESSAGE_INDEX)[2:8:2]:
        data[place + byte] ^= 2
    whole.write_bytes(data)
    recovered = recover([whole], tmp_path / "out")
    assert recovered.messages == 400
    assert len(recovered.files[0][1].damages) == 3


def test_an_inserted_byte_before_an_index_swallows_no_chunk(tmp_path):
    whole = recorded(tmp_path / "bag", close=False)
    data = whole.read_bytes()
    place = heads(data, Opcode.MESSAGE_INDEX)[3]
    whole.write_bytes(
        data[:place] + data[place : place + 1] + data[place:]
    )  # its length is 256 times as large
    recovered = recover([whole], tmp_path / "out")
    assert recovered.messages == 400
    assert [damage.start for damage in recovered.files[0][1].damages] == [place]


def without_chunks(file):
    """A bag as rosbag2's preset `fastwrite` makes it: messages outside of chunks, without checksums."""
    with file.open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        channel = writer.register_channel("/depth", "cdr", schema, {})
        for step in range(100):
            writer.add_message(channel, step, ONE, step, step)
        writer.finish()
    return file.read_bytes()


@pytest.mark.parametrize("byte", range(9))
def test_a_damaged_head_of_a_message_outside_of_chunks_costs_it_and_its_neighbour_at_most(tmp_path, byte):
    data = bytearray(without_chunks(tmp_path / "a.mcap"))
    data[heads(bytes(data), Opcode.MESSAGE)[40] + byte] ^= 16
    (tmp_path / "a.mcap").write_bytes(data)
    recover([tmp_path / "a.mcap"], tmp_path / "out")
    assert {*range(39), *range(41, 100)} <= {*sequences(tmp_path / "out" / "out_0.mcap")} <= {*range(100)}


def test_messages_outside_of_chunks_are_kept_up_to_a_cut_or_a_zeroed_tail(tmp_path):
    data = without_chunks(tmp_path / "a.mcap")
    place = heads(data, Opcode.MESSAGE)[40]
    for name, tail in (("cut", data[place : place + 5]), ("zeroed", bytes(100_000)), ("end", b"")):
        (tmp_path / f"{name}.mcap").write_bytes(data[:place] + tail)
        assert recover([tmp_path / f"{name}.mcap"], tmp_path / name).messages == 40


def test_a_file_of_mcap_s_own_writer_recovers_too(tmp_path):
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer = Writer(stream, chunk_size=500, compression=CompressionType.LZ4)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        channel = writer.register_channel("/depth", "cdr", schema, {})
        for step in range(100):
            writer.add_message(channel, step, ONE, step, step)
        writer.finish()
    data = (tmp_path / "a.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(data[: len(data) // 2])
    assert recover([tmp_path / "a.mcap"], tmp_path / "out").messages == 100
    assert 0 < recover([tmp_path / "cut.mcap"], tmp_path / "less").messages < 100


def test_a_topic_that_was_offered_in_two_ways_recovers_for_rosbags_too(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    for publishers in ([QOS], [QOS, QOS], [QOS, QOS, QOS | {"reliability": "best_effort"}]):
        bag.add_topic("/depth", "std_msgs/msg/Float64", publishers, "")
        bag.write("/depth", ONE, 5, 5, 1)
    bag.close()
    assert count_by_rosbags(tmp_path / "bag") == 3
    assert recover(bag_files(tmp_path / "bag"), tmp_path / "out").messages == 3
    assert count_by_rosbags(tmp_path / "out") == 3


def test_gaps_in_the_publishers_count_are_told_as_losses_and_old_metadata_is_made_anew(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    for name, numbers in (("/a", (1, 2, 5, 6)), ("/b", (7, 8))):
        bag.add_topic(name, "std_msgs/msg/Float64", [QOS], "RIHS01_0")
        for number in numbers:
            bag.write(name, ONE, number, number, number)
    bag.note("versions", {"python": "3"})
    bag.attach(Attached("machine.yaml", "application/yaml", b"name: c180", 5))
    bag.close()
    recovered = recover(bag_files(tmp_path / "bag"), tmp_path / "no" / "such" / "out")
    assert (recovered.messages, recovered.nameless) == (6, 0)
    (tmp_path / "no" / "such" / "out").rename(tmp_path / "out")
    assert {name: gaps.lost for name, gaps in recovered.topics.items()} == {"/a": 2, "/b": 0}
    about = yaml.safe_load((tmp_path / "out" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert about["custom_data"] == {"lost_messages": "2", "lost_messages:/a": "2", "lost_messages:/b": "0"}
    assert [topic["message_count"] for topic in about["topics_with_message_count"]] == [4, 2]
    assert about["topics_with_message_count"][0]["topic_metadata"]["type_description_hash"] == "RIHS01_0"
    with pytest.raises(FileExistsError):
        recover(bag_files(tmp_path / "bag"), tmp_path / "out")
    with (tmp_path / "out" / "out_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().library == "forest_msgs_py recovery"
        notes = [(note.name, note.metadata) for note in reader.iter_metadata()]
        (attached,) = reader.iter_attachments()
    assert notes[0] == ("versions", {"python": "3"})
    assert [name for name, _ in notes] == ["versions", "rosbag2"]
    inner = yaml.safe_load(notes[1][1]["serialized_metadata"])
    assert [topic["message_count"] for topic in inner["topics_with_message_count"]] == [4, 2]
    assert (attached.name, attached.media_type, attached.log_time) == ("machine.yaml", "application/yaml", 5)


@pytest.mark.parametrize("text", ["[", "depth: 1", "- 5", "", "null"])
def test_profiles_that_make_no_sense_are_none(text):
    assert bag_recovery._profiles(text) == []
    assert bag_recovery._profiles("- depth: 1") == [{"depth": 1}]


def rosbag2_counts(file):
    """What a recovered file itself tells of its topics."""
    with file.open("rb") as stream:
        told = next(m.metadata for m in make_reader(stream).iter_metadata() if m.name == "rosbag2")
    about = yaml.safe_load(told["serialized_metadata"])
    return {t["topic_metadata"]["name"]: t["message_count"] for t in about["topics_with_message_count"]}


def test_each_file_tells_its_own_messages_of_every_topic_so_far(tmp_path):
    for name, count in (("a", 3), ("b", 2)):
        bag = BagWriter(tmp_path / name)
        bag.add_topic(f"/{name}", "std_msgs/msg/Float64", [QOS], "")
        for step in range(count):
            bag.write(f"/{name}", ONE, step, step, step + 1)
        bag.close()
    recover([tmp_path / name / f"{name}_0.mcap" for name in "ab"], tmp_path / "out")
    assert rosbag2_counts(tmp_path / "out" / "out_0.mcap") == {"/a": 3}
    assert rosbag2_counts(tmp_path / "out" / "out_1.mcap") == {"/a": 0, "/b": 2}


def test_messages_of_a_channel_that_nothing_tells_about_are_counted_and_left_out(tmp_path):
    out, recovered = McapFile(tmp_path / "out.mcap"), bag_recovery.Recovered()
    copy = bag_recovery._Copy(out, recovered)
    for record in (
        Schema(id=3, data=b"float64 data", encoding="ros2msg", name="std_msgs/msg/Float64"),
        Channel(id=5, topic="/a", message_encoding="cdr", metadata={}, schema_id=3),
        Channel(id=6, topic="/b", message_encoding="cdr", metadata={}, schema_id=4),  # of no schema
        *(Message(channel, 1, ONE, 2, 3) for channel in (5, 6, 7, 5)),
        Schema(id=3, data=b"another", encoding="ros2msg", name="pkg/msg/Another"),  # the first counts
        Channel(id=5, topic="/c", message_encoding="cdr", metadata={}, schema_id=3),
        Message(5, 4, ONE, 5, 6),
    ):
        copy.take(record)
    out.finish()
    assert (recovered.messages, recovered.nameless) == (3, 2)
    assert [(offer.name, offer.type, count) for offer, count in copy.counts.items()] == [
        ("/a", "std_msgs/msg/Float64", 3)
    ]
    with (tmp_path / "out.mcap").open("rb") as stream:
        found = [
            (c.topic, m.log_time, m.publish_time, m.sequence)
            for _, c, m in make_reader(stream).iter_messages()
        ]
    assert found == [("/a", 1, 2, 3), ("/a", 1, 2, 3), ("/a", 4, 5, 6)]


def test_chunks_of_a_recovered_file_are_of_a_mebibyte(tmp_path):
    bag = BagWriter(tmp_path / "bag", Layout("none"))
    bag.add_topic("/large", "nobodys_msgs/msg/Large", [QOS], "")
    for step in range(5):
        bag.write("/large", bytes(500_000), step, step, step + 1)
    bag.close()
    recover(bag_files(tmp_path / "bag"), tmp_path / "out")
    with (tmp_path / "out" / "out_0.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert [chunk.uncompressed_size > 1 << 20 for chunk in summary.chunk_indexes] == [True, False]
    assert summary.chunk_indexes[0].compression == "zstd"


def test_a_topic_without_a_schema_recovers_with_the_others(tmp_path):
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        typed = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        channels = [
            writer.register_channel("/plain", "json", 0, {}),
            writer.register_channel("/depth", "cdr", typed, {}),
        ]
        for step in range(10):
            writer.add_message(channels[step % 2], step, b"{}", step, step)
        writer.finish()
    recovered = recover([tmp_path / "a.mcap"], tmp_path / "out")
    assert (recovered.messages, recovered.nameless) == (10, 0)
    with (tmp_path / "out" / "out_0.mcap").open("rb") as stream:
        found = [(schema and schema.name, c.topic) for schema, c, _ in make_reader(stream).iter_messages()]
    assert found == [(None, "/plain"), ("std_msgs/msg/Float64", "/depth")] * 5


def test_of_several_files_the_empty_one_is_left_out(tmp_path):
    first, second = recorded(tmp_path / "a"), recorded(tmp_path / "b", close=False)
    (tmp_path / "nothing.mcap").touch()
    recovered = recover([first, second, tmp_path / "nothing.mcap"], tmp_path / "out")
    assert recovered.messages == 800
    assert [path and path.name for path, _ in recovered.files] == ["out_0.mcap", "out_1.mcap", None]
    assert [recovery.complete for _, recovery in recovered.files] == [True, False, False]
    assert count_by_rosbags(tmp_path / "out") == 800


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", r"a\.mcap is empty \(0 bytes\)"),
        (b"what is this?", r"a\.mcap: nothing in it can be read"),
        (MAGIC, r"a\.mcap holds neither a message nor an attachment"),
    ],
    ids=["empty", "text", "begun"],
)
def test_what_holds_nothing_is_refused_and_makes_no_directory(tmp_path, content, problem):
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(BagError, match=problem):
        recover([tmp_path / "a.mcap"], tmp_path / "out")
    assert not (tmp_path / "out").exists()
