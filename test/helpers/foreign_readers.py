"""Bags as libraries read them that nobody here wrote: rosbags and mcap."""

from mcap.reader import make_reader
from rosbags.rosbag2 import Reader


def by_rosbags(directory):
    """Return (topic, log time, bytes) of every message of a bag, MCAP or SQLite, by rosbags."""
    with Reader(directory) as reader:
        found = [(connection.topic, time, bytes(data)) for connection, time, data in reader.messages()]
        assert reader.message_count == len(found)
    return found


def by_mcap(file):
    """Return (topic, log time, bytes, publish time, sequence) of every message of a file, by mcap."""
    with file.open("rb") as stream:
        return [
            (channel.topic, m.log_time, m.data, m.publish_time, m.sequence)
            for _, channel, m in make_reader(stream).iter_messages()
        ]
