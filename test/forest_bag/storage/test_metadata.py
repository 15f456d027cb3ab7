"""`metadata.yaml`, key by key, and on a disk that is full."""

import errno

import pytest
import yaml

from forest_bag.storage import metadata
from forest_bag.storage.metadata import FileEntry, OfferedTopic, dump, information, write_metadata

QOS = {"depth": 1, "durability": "volatile"}


def test_information_is_that_of_files_with_messages_topic_by_topic(monkeypatch):
    monkeypatch.setenv("ROS_DISTRO", "kilted")
    files = [
        FileEntry("b_0.mcap", 50, 90, 3),
        FileEntry("b_1.mcap", 0, 0, 0),
        FileEntry("b_2.mcap", 20, 60, 4),
    ]
    offer = OfferedTopic("/a", "pkg/msg/A", [QOS, QOS], "RIHS01_0", "json")
    about = information(files, {offer: 7}, {"/a": 2, "/b": 3}, "sqlite3")
    assert about == {
        "version": 9,
        "storage_identifier": "sqlite3",
        "duration": {"nanoseconds": 70},
        "starting_time": {"nanoseconds_since_epoch": 20},
        "message_count": 7,
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": "/a",
                    "type": "pkg/msg/A",
                    "serialization_format": "json",
                    "offered_qos_profiles": [QOS, QOS],
                    "type_description_hash": "RIHS01_0",
                },
                "message_count": 7,
            }
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": ["b_0.mcap", "b_1.mcap", "b_2.mcap"],
        "files": [
            {
                "path": path,
                "starting_time": {"nanoseconds_since_epoch": first},
                "duration": {"nanoseconds": duration},
                "message_count": count,
            }
            for path, first, duration, count in (
                ("b_0.mcap", 50, 40, 3),
                ("b_1.mcap", 0, 0, 0),
                ("b_2.mcap", 20, 40, 4),
            )
        ],
        "custom_data": {"lost_messages": "5", "lost_messages:/a": "2", "lost_messages:/b": "3"},
        "ros_distro": "kilted",
    }
    monkeypatch.delenv("ROS_DISTRO")
    assert information([], {}, {})["ros_distro"] == "jazzy"
    text = dump(about)
    assert list(yaml.safe_load(text)) == list(about)
    assert "&" not in text  # the same profile twice is written twice


def test_a_topic_covers_what_its_publishers_offer_of_the_same_type():
    one, other = {"depth": 1}, {"depth": 2}
    offer = OfferedTopic("/a", "pkg/msg/A", [one, other], "RIHS01_0")
    assert offer.covers(OfferedTopic("/a", "pkg/msg/A", [other], "RIHS01_0"))
    assert offer.covers(OfferedTopic("/a", "pkg/msg/A", [], "RIHS01_0"))
    assert not offer.covers(OfferedTopic("/a", "pkg/msg/A", [other, {"depth": 3}], "RIHS01_0"))
    assert not offer.covers(OfferedTopic("/a", "pkg/msg/A", [other], "RIHS01_1"))


def test_the_file_is_whole_or_as_it_was(tmp_path, monkeypatch):
    write_metadata(tmp_path, {"version": 9})
    was = (tmp_path / "metadata.yaml").read_text()
    assert was == "rosbag2_bagfile_information:\n  version: 9\n"
    synced, fsync = [], metadata.os.fsync
    monkeypatch.setattr(metadata.os, "fsync", lambda at: synced.append(at) or fsync(at))
    write_metadata(tmp_path, {"version": 9})
    assert len(synced) == 2  # the file, and its name

    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(metadata.os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_metadata(tmp_path, {"version": 10})
    assert [file.name for file in tmp_path.iterdir()] == ["metadata.yaml"]
    assert (tmp_path / "metadata.yaml").read_text() == was
