"""A bag's joystick keeps its times, from the beginning of the recorded run."""

import pytest

pytest.importorskip("rclpy")

from forest_bag.write.bag_writer import BagWriter
from forest_control.operator.joystick_bag import is_bag, read_joy_record
from forest_control.operator.joystick_sources import LeverError
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import ns_to_stamp
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.serialization.cdr import to_cdr

BEGUN = 1_700_000_000_000_000_000


def joy(stamp):
    message = message_class(topics.JOY)(axes=[0.5] * 4)
    message.header.stamp = ns_to_stamp(stamp)
    return to_cdr(message)


def clock(stamp):
    return to_cdr(message_class(topics.CLOCK)(clock=ns_to_stamp(stamp)))


def bag(path, *said):
    writer = BagWriter(path)
    for topic, name in ((topics.JOY, "/crane1/joy"), (topics.CLOCK, "/clock")):
        writer.add_topic(name, topic.type, [offered_qos(topic)], "")
    for name, data, stamp in said:
        writer.write(name, data, stamp, stamp)
    writer.close()
    return path


def test_without_a_clock_time_begins_with_the_first_message(tmp_path):
    stamps = [BEGUN, BEGUN + 10, BEGUN + 25]
    record = read_joy_record(bag(tmp_path / "a", *(("/crane1/joy", joy(s), s) for s in stamps)))
    assert record.times_ns == (0, 10, 25)
    assert record.messages == tuple(map(joy, stamps))
    assert [record.newest(t) for t in (-1, 0, 9, 10, 24, 25, 99)] == [-1, 0, 0, 1, 1, 2, 2]


def test_with_a_clock_time_begins_with_the_run_and_lasts_as_long(tmp_path):
    said = [("/clock", clock(s), s) for s in (5, 10, 15, 20)]
    record = read_joy_record(bag(tmp_path / "a", *said[:2], ("/crane1/joy", joy(10), 10), *said[2:]))
    assert record.times_ns == (5,)
    assert record.length == pytest.approx(15e-9)


def test_a_bag_without_joystick_and_what_is_no_bag_are_refused(tmp_path):
    with pytest.raises(LeverError, match="no message of a joystick on /joy"):
        read_joy_record(bag(tmp_path / "a", ("/clock", clock(5), 5)))
    (tmp_path / "b").mkdir()
    with pytest.raises(LeverError, match=r"no \.mcap file"):
        read_joy_record(tmp_path / "b")
    assert is_bag(tmp_path / "b")
    assert is_bag(tmp_path / "c.mcap")
    assert not is_bag(tmp_path / "c.csv")
