"""Every split of a bag is whole by itself; together they are one bag to readers that nobody here wrote."""

import errno
import random

import pytest
import yaml
from mcap.reader import make_reader

from forest_bag.storage.bag_files import bag_files
from forest_bag.write.bag_split import Attached, Layout
from forest_bag.write.bag_writer import BagWriter
from forest_bag.write.transient_local import Sample, TransientLocal, is_transient_local

FOREVER = {"sec": 9223372036, "nsec": 854775807}
ONE = b"\x00\x01\x00\x00" + bytes(6) + b"\xf0\x3f"  # std_msgs/Float64 1.0 as little-endian CDR
URDF = b"\x00\x01\x00\x00\x09\x00\x00\x00<robot/>\x00"  # std_msgs/String


def offers(durability="volatile", depth=10, **others):
    never = {"deadline": FOREVER, "lifespan": FOREVER, "liveliness_lease_duration": FOREVER}
    words = {"history": "keep_last", "reliability": "reliable", "liveliness": "automatic"}
    plain = {"depth": depth, "durability": durability, "avoid_ros_namespace_conventions": False}
    return {**words, **never, **plain, **others}


def contents(file):
    with file.open("rb") as stream:
        return [(channel.topic, m) for _, channel, m in make_reader(stream).iter_messages()]


def crane(directory, layout, seconds=10, hz=100):
    """A robot description first, then depths that no compression makes smaller."""
    bag, generator = BagWriter(directory, layout), random.Random(3)
    bag.add_topic("/robot_description", "std_msgs/msg/String", [offers("transient_local", 1)], "")
    bag.add_topic("/depth", "std_msgs/msg/Float64", [offers()], "")
    bag.attach(Attached("machine.yaml", "application/yaml", b"name: c180", 5))
    bag.note("versions", {"python": "3"})
    bag.write("/robot_description", URDF, 10**9, 10**9, 1)
    for step in range(seconds * hz):
        time = 10**9 + step * 10**9 // hz
        bag.write("/depth", ONE[:4] + generator.randbytes(8), time, time, step + 1)
    return bag


def test_a_longest_duration_begins_the_next_file_with_everything_it_needs(tmp_path):
    crane(tmp_path / "bag", Layout(max_ns=3 * 10**9)).close()
    files = bag_files(tmp_path / "bag")
    assert [file.name for file in files] == [f"bag_{n}.mcap" for n in range(4)]
    for file in files:
        messages = contents(file)
        times = [m.log_time for _, m in messages]
        assert max(times) - min(times) < 3 * 10**9
        topic, first = messages[0]
        assert (topic, first.data, first.publish_time) == ("/robot_description", URDF, 10**9)
        with file.open("rb") as stream:
            reader = make_reader(stream)
            assert [a.data for a in reader.iter_attachments()] == [b"name: c180"]
            assert [m.name for m in reader.iter_metadata()] == ["versions", "rosbag2"]
    depths = [m.sequence for file in files for topic, m in contents(file) if topic == "/depth"]
    assert depths == list(range(1, 1001))


@pytest.mark.parametrize("compression", ["none", "zstd"])
def test_a_largest_size_is_kept_to(tmp_path, compression):
    limit = 20_000
    layout = Layout(compression, max_bytes=limit, chunk_bytes=1000)
    crane(tmp_path / "bag", layout).close()
    files = bag_files(tmp_path / "bag")
    assert len(files) > 2
    assert max(file.stat().st_size for file in files) <= limit
    assert min(file.stat().st_size for file in files[:-1]) > 0.7 * limit


def test_metadata_lists_all_splits_and_rosbags_reads_them_as_one(tmp_path):
    highlevel = pytest.importorskip("rosbags.highlevel")
    crane(tmp_path / "bag", Layout(max_ns=3 * 10**9)).close()
    about = yaml.safe_load((tmp_path / "bag/metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert about["relative_file_paths"] == [f"bag_{n}.mcap" for n in range(4)]
    assert [f["message_count"] for f in about["files"]] == [301, 301, 301, 101]
    assert about["message_count"] == 1004
    assert about["duration"]["nanoseconds"] == 9_990_000_000
    with highlevel.AnyReader([tmp_path / "bag"]) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        assert counts == {"/robot_description": 4, "/depth": 1000}
        assert sum(1 for _ in reader.messages()) == 1004


def test_a_split_before_anything_came_and_an_empty_last_file_leave_nothing_behind(tmp_path):
    bag = crane(tmp_path / "bag", Layout(), seconds=1)
    bag.split()
    bag.split()
    bag.close()
    assert [file.name for file in bag_files(tmp_path / "bag")] == ["bag_0.mcap"]


def test_a_late_publisher_that_offers_something_new_gets_a_channel_that_says_so(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    early, late = offers(), offers(reliability="best_effort")
    for number, publishers in enumerate(([early], [early, early], [early, early, late])):
        bag.add_topic("/depth", "std_msgs/msg/Float64", publishers, "")
        bag.write("/depth", ONE, number, number, 1)
    bag.close()
    with (tmp_path / "bag/bag_0.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    said = [yaml.safe_load(c.metadata["offered_qos_profiles"]) for c in summary.channels.values()]
    assert said == [[early], [early, early, late]]
    about = yaml.safe_load((tmp_path / "bag/metadata.yaml").read_text())["rosbag2_bagfile_information"]
    entries = about["topics_with_message_count"]
    assert [entry["topic_metadata"]["offered_qos_profiles"] for entry in entries] == said
    assert [entry["message_count"] for entry in entries] == [2, 1]
    highlevel = pytest.importorskip("rosbags.highlevel")
    with highlevel.AnyReader([tmp_path / "bag"]) as reader:  # matches channels and entries by QoS
        assert sum(1 for _ in reader.messages()) == 3


def test_what_expires_is_not_repeated_and_of_what_is_latched_the_last(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    expiring = offers("transient_local", 1000, lifespan={"sec": 10, "nsec": 0})
    bag.add_topic("/rosout", "std_msgs/msg/String", [expiring], "")
    bag.add_topic("/map", "std_msgs/msg/String", [offers("transient_local", 2)], "")
    for number in range(5):
        bag.write("/rosout", URDF, number, number, number + 1)
        for _ in range(2):
            bag.write("/map", URDF + bytes([number]), number, number, number + 1)
    bag.split()
    bag.write("/rosout", URDF, 9, 9, 6)
    bag.close()
    last = contents(bag_files(tmp_path / "bag")[-1])
    assert [(topic, m.sequence, m.log_time) for topic, m in last] == [
        ("/map", 4, 9),
        ("/map", 5, 9),
        ("/rosout", 6, 9),
    ]


def test_a_day_of_chunks_does_not_grow_the_memory(tmp_path, monkeypatch):
    """What a file keeps for its index is bounded, because its number of chunks is."""
    monkeypatch.setattr("forest_bag.write.bag_writer.CHUNKS_PER_FILE", 50)
    bag = BagWriter(tmp_path / "bag")
    bag.add_topic("/depth", "std_msgs/msg/Float64", [offers()], "")
    sizes = []
    for step in range(500):
        bag.write("/depth", ONE, step, step, step + 1)
        bag.flush()
        sizes.append(len(bag._split.file._chunk_index))
    bag.close()
    assert len(bag_files(tmp_path / "bag")) == 10
    assert max(sizes) == max(sizes[:60])


def test_a_next_file_that_cannot_be_made_leaves_a_closed_bag_of_those_before(tmp_path, monkeypatch):
    bag = crane(tmp_path / "bag", Layout(), seconds=1)

    def full(*_arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as disk:
        disk.setattr("forest_bag.storage.append_file.tempfile.TemporaryFile", lambda **_: full())
        with pytest.raises(OSError, match="No space left"):
            bag.split()
    bag.close()
    assert sorted(path.name for path in (tmp_path / "bag").iterdir()) == ["bag_0.mcap", "metadata.yaml"]
    about = yaml.safe_load((tmp_path / "bag/metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert about["relative_file_paths"] == ["bag_0.mcap"]
    assert about["message_count"] == 101


def test_a_bags_size_is_that_of_its_files(tmp_path):
    def on_disk():
        return [file.stat().st_size for file in bag_files(tmp_path / "bag")]

    bag = crane(tmp_path / "bag", Layout("none"), seconds=1)
    bag.flush()
    first = bag.size
    assert 0 < first - on_disk()[0] < 10_000  # its summary is to come
    bag.split()
    assert bag.size - on_disk()[0] == bag._split.file.size > on_disk()[1]
    bag.write("/depth", ONE, 10**10, 10**10, 1)
    bag.close()
    assert bag.size == sum(on_disk())


def test_what_a_file_begins_with_is_no_reason_for_the_next(tmp_path):
    bag = BagWriter(tmp_path / "bag", Layout("none", max_bytes=3000, chunk_bytes=1))
    bag.add_topic("/map", "nobodys_msgs/msg/Map", [offers("transient_local", 1)], "")
    bag.add_topic("/depth", "nobodys_msgs/msg/Depth", [offers()], "")
    bag.write("/map", bytes(20_000), 0, 0, 1)
    for step in range(30):
        bag.write("/depth", bytes(1000), step, step, step + 1)
    bag.close()
    sizes = [file.stat().st_size for file in bag_files(tmp_path / "bag")]
    assert len(sizes) == 3
    assert all(40_000 < size < 2 * (20_000 + 6000) for size in sizes[1:-1])


def test_a_message_without_a_number_has_none(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    bag.add_topic("/depth", "std_msgs/msg/Float64", [offers()], "")
    bag.write("/depth", ONE, 5, 5)
    bag.close()
    assert [m.sequence for _, m in contents(tmp_path / "bag" / "bag_0.mcap")] == [0]


def test_metadata_of_a_bag_without_messages_tells_no_time(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    bag.add_topic("/depth", "std_msgs/msg/Float64", [offers()], "")
    bag.close()
    about = yaml.safe_load((tmp_path / "bag/metadata.yaml").read_text())["rosbag2_bagfile_information"]
    for told in (about, *about["files"]):
        assert told["starting_time"] == {"nanoseconds_since_epoch": 0}
        assert told["duration"] == {"nanoseconds": 0}
        assert told["message_count"] == 0
    assert about["topics_with_message_count"][0]["message_count"] == 0


@pytest.mark.parametrize(
    ("seconds", "kept"),
    [(0, True), (9223372036, True), (2147483647, True), (999_999_999, False), (10, False)],
)
def test_latched_is_what_stays_for_good(seconds, kept):
    one = offers("transient_local", lifespan={"sec": seconds, "nsec": 0})
    assert is_transient_local([offers(), one]) == kept
    assert not is_transient_local([one | {"durability": "volatile"}])


def latched(qos, count=150):
    """What is kept of so many messages, by their numbers."""
    kept = TransientLocal()
    kept.watch("/map", qos)
    for number in range(count):
        kept.keep(Sample("/map", b"%d" % number, number, 0, number))
        kept.keep(Sample("/other", b"", number, 0, number))
    assert ("/map" in kept, "/other" in kept) == (bool(kept._kept), False)
    return [sample.sequence for sample in kept]


def test_of_a_latched_topic_as_many_are_kept_as_its_publisher_keeps_and_a_hundred_of_several():
    one = offers("transient_local", 3)
    assert latched([one]) == [147, 148, 149]
    assert latched([one | {"depth": 0}]) == [149]  # the middleware does not tell
    assert latched([one | {"depth": 1000}]) == [*range(50, 150)]
    assert latched([one, one]) == [*range(50, 150)]
    assert latched([offers()]) == []
    assert latched([one], 2) == [0, 1]


def test_of_a_limit_in_time_the_first_message_counts_and_at_the_limit_the_next_file_begins(tmp_path):
    bag = BagWriter(tmp_path / "bag", Layout(max_ns=10))
    bag.add_topic("/depth", "std_msgs/msg/Float64", [offers()], "")
    for time in (5, 14, 15, 24, 26):
        bag.write("/depth", ONE, time, time, time)
    bag.close()
    assert [[m.log_time for _, m in contents(file)] for file in bag_files(tmp_path / "bag")] == [
        [5, 14],
        [15, 24],
        [26],
    ]
