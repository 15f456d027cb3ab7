"""Bytes that are unpacked where the numbers stood say what the message says, whatever is in them."""

import math

import numpy as np
import pytest

pytest.importorskip("rclpy")

from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState, Joy
from std_msgs.msg import Float64MultiArray

from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.messages import (
    float_array,
    joint_state,
    ns_to_stamp,
    pose_stamped,
    sensor_array,
)
from forest_msgs_py.serialization.cdr import to_cdr
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader, read_joy_data, read_position

STAMP, NOW = 1_700_000_000_123_456_789, 5
NAN, INF = math.nan, math.inf
ENCODERS = pytest.mark.parametrize("encode", [to_cdr, serialize_message], ids=["ours", "of ROS"])


def arrays():
    numbers = np.random.default_rng(4)
    pressures = [numbers.normal(size=12).tolist() for _ in range(3)]
    yield from (float_array(topics.PRESSURES, STAMP + n, values) for n, values in enumerate(pressures))
    for bad in (NAN, INF, 1e308, -1e308):  # the sum of these may not be finite though they are
        yield float_array(topics.PRESSURES, STAMP, [bad] * 12)
        yield float_array(topics.PRESSURES, STAMP, [*pressures[0][:11], bad])
    yield sensor_array(topics.PRESSURES, STAMP, [*pressures[0][:11], NAN])
    yield float_array(topics.PRESSURES, STAMP, pressures[1], plain=True)
    yield Float64MultiArray(data=pressures[2])
    yield Float64MultiArray()
    wrong = float_array(topics.PRESSURES, STAMP, pressures[1])
    for stamp in ((0.5, 0.0), (NAN, 0.0), (1.0, 1e9), (1e300, 0.0)):
        wrong.data[0], wrong.data[1] = stamp
        yield wrong
    swapped = float_array(topics.PRESSURES, STAMP, pressures[2])
    swapped.layout.dim[0].label = ",".join(reversed(topics.PRESSURES.labels))
    yield swapped
    swapped.layout.dim[0].label = ",".join(["swing_1_valve"] * 12)
    yield swapped


@ENCODERS
@pytest.mark.parametrize(
    "labels", [None, ("supply",), ("boom_2_valve",), ("stick_1_actuator", "swing_1_valve", "boom_1_valve")]
)
def test_an_array_reads_as_its_message_after_any_other(encode, labels):
    reader = ArrayReader(topics.PRESSURES, labels)
    first = encode(float_array(topics.PRESSURES, STAMP, range(12)))
    for message in arrays():
        reader.read(first, NOW)
        expected = messages.read_float_array(topics.PRESSURES, message, NOW, labels)
        assert repr(reader.read(encode(message), NOW)) == repr(expected)
        assert repr(reader.read(encode(message), NOW)) == repr(expected)


def joints():
    numbers, names = np.random.default_rng(5), topics.JOINTS
    p, v, e = (numbers.normal(size=3).tolist() for _ in range(3))
    yield from (joint_state(names, STAMP + n, p, v, e) for n in range(2))
    yield joint_state(names, -STAMP, p, v, e)
    yield from (joint_state(names, STAMP, p, v), joint_state(names, STAMP, p, (), e))
    yield from (joint_state(names, STAMP, p), joint_state(names, STAMP, p, v[:2], e))
    for bad in (NAN, INF):
        yield joint_state(names, STAMP, [bad, 0.0, 0.0], v, e)
        yield joint_state(names, STAMP, p, [0.0, bad, 0.0], e)
        yield joint_state(names, STAMP, p, v, [0.0, 0.0, bad])
    yield joint_state(("stick", "boom", "swing"), STAMP, p, v, e)
    yield joint_state((*names, "grapple"), STAMP, [*p, 1.0], [*v, 2.0], [*e, 3.0])
    yield joint_state((*names, "grapple"), STAMP, [*p, NAN], [*v, NAN], [*e, NAN])
    yield from (joint_state(names[:2], STAMP, p[:2]), joint_state(names, STAMP, p[:2]), JointState())
    framed = joint_state(names, STAMP, p, v, e)
    framed.header.frame_id = "crane"
    yield framed


@ENCODERS
def test_joints_read_as_their_message_after_any_other(encode):
    reader = JointReader(topics.JOINTS)
    first = encode(joint_state(topics.JOINTS, STAMP, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (7.0, 8.0, 9.0)))
    for message in joints():
        reader.read(first)
        expected = messages.read_joint_state(topics.JOINTS, message)
        assert repr(reader.read(encode(message))) == repr(expected)
        assert repr(reader.read(encode(message))) == repr(expected)


@ENCODERS
@pytest.mark.parametrize(
    "axes", [(), (0.1,) * 4, (0.0, -1.0, 1.0, 0.25, 0.5, 0.0), (NAN,) * 4, (0.0, 0.0, 0.0, 1.5)]
)
@pytest.mark.parametrize("frame", ["", "heartbeat:17", "Ärm"])
def test_levers_read_as_their_message(encode, axes, frame):
    message = Joy(axes=axes, buttons=[0, 1, 0, -1][: len(axes)])
    message.header.stamp, message.header.frame_id = ns_to_stamp(STAMP), frame
    reading, told = read_joy_data(encode(message), 4, 1)
    assert repr(reading) == repr(messages.read_joy(message, 4, 1))
    assert told == frame


@ENCODERS
@pytest.mark.parametrize("frame", ["", "map", "base_link", "Ärm"])
def test_a_position_reads_as_its_message(encode, frame):
    data = encode(pose_stamped(STAMP, frame, (1.0, -2.5, 3.0, 0.0, 0.0, 0.6, 0.8)))
    assert read_position(data) == (1.0, -2.5, 3.0)
    assert read_position(data[:30]) is None
    assert read_position(b"") is None


def test_bytes_that_are_no_message_are_a_bad_reading():
    whole = to_cdr(float_array(topics.PRESSURES, STAMP, range(12)))
    state = to_cdr(joint_state(topics.JOINTS, STAMP, (1.0, 2.0, 3.0)))
    joy = to_cdr(Joy(axes=[0.0] * 4, buttons=[0]))
    array, joint = ArrayReader(topics.PRESSURES), JointReader(topics.JOINTS)
    assert not array.read(whole, NOW).problem
    assert not joint.read(state).problem
    for cut in (0, 3, 4, 9, 20):
        assert array.read(whole[:cut], NOW).problem
        assert joint.read(state[:cut]).problem
        assert read_joy_data(joy[:cut])[0].problem
    assert array.read(whole[:-8], NOW).problem
    assert joint.read(state[:-16]).problem


def test_a_message_of_the_other_byte_order_is_read_as_ros_reads_it():
    little = to_cdr(joint_state(topics.JOINTS, STAMP, (1.0, 2.0, 3.0)))
    reader = JointReader(topics.JOINTS)
    reader.read(little)
    big = b"\x00\x00" + little[2:]
    try:
        message = deserialize_message(big, JointState)
    except RuntimeError:
        assert reader.read(big).problem
    else:
        assert repr(reader.read(big)) == repr(messages.read_joint_state(topics.JOINTS, message))
