"""The bag is what rosbag2 of Jazzy writes, to readers that nobody here wrote, and survives a kill."""

import errno
import subprocess
import sys
import textwrap

import pytest
import yaml
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader

from forest_bag.write.bag_writer import BagWriter
from forest_msgs_py.interfaces.definitions import message_definition

START = 1_700_000_000_000_000_000
HASH = "RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a"
INFINITE = {"sec": 9223372036, "nsec": 854775807}
QOS = {
    "history": "unknown",
    "depth": 0,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": INFINITE,
    "lifespan": INFINITE,
    "liveliness": "automatic",
    "liveliness_lease_duration": INFINITE,
    "avoid_ros_namespace_conventions": False,
}
ONE = b"\x00\x01\x00\x00" + bytes(6) + b"\xf0\x3f"  # std_msgs/Float64 1.0 as little-endian CDR


def record(directory, count=100):
    recorder = BagWriter(directory)
    recorder.add_topic("/depth", "std_msgs/msg/Float64", [QOS], HASH)
    recorder.add_topic("/quiet", "std_msgs/msg/Float64", [QOS, QOS], HASH)
    for step in range(count):
        recorder.write("/depth", ONE, START + step * 5_000_000, START + step * 5_000_000 - 99, step + 1)
    return recorder


@pytest.fixture
def needs_message_files():
    try:
        message_definition("std_msgs/msg/Float64")
    except FileNotFoundError as error:
        pytest.skip(str(error))


def test_metadata_is_rosbag2_version_9(tmp_path):
    recorder = record(tmp_path / "bag")
    recorder.lost["/depth"] = 3
    recorder.close()
    data = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert list(data) == [
        *("version", "storage_identifier", "duration", "starting_time", "message_count"),
        *("topics_with_message_count", "compression_format", "compression_mode", "relative_file_paths"),
        *("files", "custom_data", "ros_distro"),
    ]
    assert (data["version"], data["storage_identifier"], data["message_count"]) == (9, "mcap", 100)
    assert data["duration"] == {"nanoseconds": 99 * 5_000_000}
    assert data["starting_time"] == {"nanoseconds_since_epoch": START}
    assert data["relative_file_paths"] == ["bag_0.mcap"]
    assert data["files"][0]["path"] == "bag_0.mcap"
    topic = data["topics_with_message_count"][0]
    assert topic["message_count"] == 100
    assert topic["topic_metadata"] == {
        "name": "/depth",
        "type": "std_msgs/msg/Float64",
        "serialization_format": "cdr",
        "offered_qos_profiles": [QOS],
        "type_description_hash": HASH,
    }
    assert data["custom_data"]["lost_messages"] == "3"
    assert data["custom_data"]["lost_messages:/depth"] == "3"


def test_rosbags_reads_the_directory(tmp_path, needs_message_files):
    highlevel = pytest.importorskip("rosbags.highlevel")
    record(tmp_path / "bag").close()
    with highlevel.AnyReader([tmp_path / "bag"]) as reader:
        assert {connection.topic: connection.msgcount for connection in reader.connections} == {
            "/depth": 100,
            "/quiet": 0,
        }
        read = [
            (stamp, reader.deserialize(data, connection.msgtype).data)
            for connection, stamp, data in reader.messages()
        ]
    assert read == [(START + step * 5_000_000, 1.0) for step in range(100)]


def test_mcap_ros2_support_reads_the_file_with_its_own_schemas(tmp_path, needs_message_files):
    reader = pytest.importorskip("mcap_ros2.reader")
    record(tmp_path / "bag").close()
    read = list(reader.read_ros2_messages(str(tmp_path / "bag" / "bag_0.mcap")))
    assert [message.ros_msg.data for message in read] == [1.0] * 100
    assert read[0].log_time_ns == START
    assert read[0].publish_time_ns == START - 99


def test_file_says_profile_qos_hash_and_sequence(tmp_path):
    record(tmp_path / "bag").close()
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        channels = {channel.topic: channel for channel in reader.get_summary().channels.values()}
        numbers = [message.sequence for _, _, message in reader.iter_messages()]
        (metadata,) = reader.iter_metadata()
    assert yaml.safe_load(channels["/quiet"].metadata["offered_qos_profiles"]) == [QOS, QOS]
    assert channels["/depth"].metadata["topic_type_hash"] == HASH
    assert channels["/depth"].message_encoding == "cdr"
    assert numbers == list(range(1, 101))
    assert metadata.name == "rosbag2"


def test_a_killed_recorder_leaves_what_was_flushed(tmp_path):
    code = f"""
        import os, sys
        sys.path[:0] = {sys.path!r}
        from forest_bag.write.bag_writer import BagWriter
        recorder = BagWriter({str(tmp_path / "bag")!r})
        recorder.add_topic("/depth", "std_msgs/msg/Float64", [], "")
        for step in range(100):
            recorder.write("/depth", {ONE!r}, step, step, step + 1)
            if step == 79:
                recorder.flush()
        os.kill(os.getpid(), 9)
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], check=False)
    assert done.returncode == -9
    assert not (tmp_path / "bag" / "metadata.yaml").exists()
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        messages = NonSeekingReader(stream).iter_messages(log_time_order=False)
        read = [next(messages)[2].log_time for _ in range(80)]
        with pytest.raises(EndOfFile):
            next(messages)
    assert read == list(range(80))


def test_an_existing_directory_is_refused_and_left_alone(tmp_path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(FileExistsError, match="bag exists; allowed: a directory to be made"):
        BagWriter(tmp_path / "bag")
    assert list((tmp_path / "bag").iterdir()) == []


def test_closing_twice_changes_nothing(tmp_path):
    recorder = record(tmp_path / "bag")
    recorder.close()
    size = (tmp_path / "bag" / "bag_0.mcap").stat().st_size
    recorder.close()
    assert (tmp_path / "bag" / "bag_0.mcap").stat().st_size == size


def test_a_full_disk_is_an_error_and_the_file_is_closed(tmp_path, monkeypatch):
    recorder = record(tmp_path / "bag")

    def full(_descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("forest_bag.storage.append_file.os.fsync", full)
    with pytest.raises(OSError, match="No space left"):
        recorder.close()
    recorder.close()  # closed: nothing more to fail
    assert not (tmp_path / "bag" / "metadata.yaml").exists()


def test_a_definition_brings_the_types_within_it_once(needs_message_files):
    text = message_definition("sensor_msgs/msg/JointState")
    parts = text.split("=" * 80 + "\n")
    assert [part.splitlines()[0] for part in parts[1:]] == [
        "MSG: std_msgs/Header",
        "MSG: builtin_interfaces/Time",
    ]
    assert "float64[] effort" in parts[0]


def test_a_type_without_files_is_recorded_all_the_same(tmp_path):
    recorder = BagWriter(tmp_path / "bag")
    assert not recorder.add_topic("/odd", "nobodys_msgs/msg/Odd", [], "")
    recorder.write("/odd", b"bytes", START, START)
    recorder.close()
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        ((schema, _, message),) = make_reader(stream).iter_messages()
    assert (schema.name, schema.encoding, message.data) == ("nobodys_msgs/msg/Odd", "", b"bytes")


def test_messages_are_counted_by_topic_as_they_are_taken_in_and_when_their_file_is_finished(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    bag.add_topic("/a", "std_msgs/msg/String", [], "")
    assert (bag.counts, bag.lost, bag.message_count, bag.written) == ({"/a": 0}, {"/a": 0}, 0, 0)
    for step in range(2):
        bag.write("/a", b"\x00\x01\x00\x00", step, step)
    assert (bag.counts, bag.message_count, bag.written) == ({"/a": 2}, 2, 0)
    assert bag.file_name == "bag_0.mcap"
    bag.close()
    assert (bag.message_count, bag.written, [file.messages for file in bag.files]) == (2, 2, [2])
