"""Messages packed into a template's bytes are byte for byte those encoded field by field."""

import math

import numpy as np
import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.messages import JoyValues
from forest_msgs_py.interfaces.topics import columns
from forest_msgs_py.serialization.cdr import to_cdr
from forest_msgs_py.serialization.packing import Packer, pack_clock, pack_joy

STAMP = 1_700_000_000_123_456_789
NAN = math.nan


def built(topic, values, plain=False):
    if topic.type == topics.JOINT_STATE:
        n = len(topic.labels)
        return messages.sensor_joint_state(
            topic.labels, STAMP, values[:n], values[n : 2 * n], values[2 * n :]
        )
    if topic.type == topics.FLOAT_ARRAY:
        return messages.sensor_array(topic, STAMP, values, plain)
    make = {topics.POSE: messages.pose_stamped, topics.TWIST: messages.twist_stamped}[topic.type]
    return make(STAMP, "base_link", values)


@pytest.mark.parametrize(
    "topic",
    [
        t
        for t in topics.TOPICS
        if t.type in (topics.JOINT_STATE, topics.FLOAT_ARRAY, topics.POSE, topics.TWIST)
    ],
    ids=lambda topic: topic.name,
)
def test_bytes_are_those_of_the_message(topic):
    values = np.random.default_rng(2).normal(size=len(columns(topic))).tolist()
    assert Packer(topic, "base_link").pack(STAMP, values) == to_cdr(built(topic, values))


@pytest.mark.parametrize(
    "missing", [(1,), (0, 1, 2), (4,), (1, 4, 7), (8,), (2, 3)], ids=lambda places: f"without {places}"
)
def test_sensors_without_a_sample_are_left_out_and_numbers_stay_with_their_names(missing):
    for topic in (topics.JOINT_STATES, topics.PRESSURES):
        values = np.random.default_rng(3).normal(size=len(columns(topic))).tolist()
        for place in missing:
            values[place] = NAN
        message = built(topic, values)
        expected = None if message is None else to_cdr(message)
        assert Packer(topic).pack(STAMP, values) == expected
        assert Packer(topic).pack(STAMP, [NAN] * len(values)) is None


def test_plain_arrays_carry_no_stamp():
    values = [1.0, NAN, 3.0]
    expected = to_cdr(built(topics.VALVE_COMMANDS, values, plain=True))
    assert Packer(topics.VALVE_COMMANDS, plain=True).pack(STAMP, values) == expected


def test_a_wrong_number_of_values_is_refused():
    with pytest.raises(ValueError, match="valve_commands: 2 numbers; allowed: 3"):
        Packer(topics.VALVE_COMMANDS).pack(STAMP, [1.0, 2.0])


@pytest.mark.parametrize("frame", ["", "heartbeat:7", "heartbeat:1234", "Hebel links"])
@pytest.mark.parametrize("joy", [JoyValues((), ()), JoyValues((0.1, -1.0, NAN), (1, 0, 1, 7))])
def test_a_joysticks_bytes_are_those_of_the_message(frame, joy):
    message = topics.message_class(topics.JOY)(axes=joy.axes, buttons=joy.buttons)
    message.header.stamp, message.header.frame_id = messages.ns_to_stamp(STAMP), frame
    assert pack_joy(STAMP, frame, joy) == to_cdr(message)


def test_a_clocks_bytes_are_those_of_the_message():
    message = topics.message_class(topics.CLOCK)(clock=messages.ns_to_stamp(STAMP))
    assert pack_clock(STAMP) == to_cdr(message)
