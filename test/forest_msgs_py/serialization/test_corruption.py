"""Claims about readers under corruption: they never raise; finite numbers or a problem, never both."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from properties import ANY, near, spoilt

pytest.importorskip("rclpy")

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import (
    JoyValues,
    float_array,
    joint_state,
    read_float_array,
    read_joint_state,
    read_joy,
)
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.serialization.batch_encoder import Encoder
from forest_msgs_py.serialization.cdr import cdr_type, to_cdr
from forest_msgs_py.serialization.packing import pack_joy
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader, read_joy_data

NAMES = st.lists(st.sampled_from([*topics.JOINTS, "elbow"]), max_size=5)
NUMBERS = st.lists(ANY | st.floats(-1.0, 1.0), min_size=3, max_size=3) | st.lists(ANY, max_size=5)
STAMPED = st.lists(st.floats(0.0, 9.0), min_size=5, max_size=5) | st.lists(ANY, max_size=7)
THREE = near(-1.0, 1.0)
ARRAY = to_cdr(float_array(topics.VALVE_COMMANDS, 5, (1.0, 2.0, 3.0)))
JOINTS = to_cdr(joint_state(topics.JOINTS, 5, (0.1, 0.2, 0.3), (0.0, 0.1, 0.2), (1.0, 2.0, 3.0)))
JOY = pack_joy(5, "heartbeat:1", JoyValues((0.5,) * 6, (0,) * 21))


def is_sound(reading, numbers):
    """Tell whether a reading gives finite numbers, or a problem and none."""
    if reading.problem:
        return not any(reading.values) and "; allowed: " in reading.problem
    return all(map(math.isfinite, numbers(reading.values)))


def joint_numbers(values):
    return (*values.position, *values.velocity, *values.effort)


@given(STAMPED, st.integers(0, 5), st.sampled_from((None, "", "swing,boom", "swing,swing,stick", "a,b,c")))
def test_arrays(data, offset, label):
    message = float_array(topics.VALVE_COMMANDS, 5, (1.0, 2.0, 3.0))
    message.data, message.layout.data_offset = data, offset
    message.layout.dim[0].label = message.layout.dim[0].label if label is None else label
    assert is_sound(read_float_array(topics.VALVE_COMMANDS, message, 0), lambda values: values)


@given(st.just(list(topics.JOINTS)) | NAMES, NUMBERS, NUMBERS, NUMBERS)
def test_joint_states(names, position, velocity, effort):
    message = message_class(topics.JOINT_STATES)(
        name=names, position=position, velocity=velocity, effort=effort
    )
    assert is_sound(read_joint_state(topics.JOINTS, message), joint_numbers)


@given(st.lists(st.floats(width=32), max_size=7), st.lists(st.integers(-(2**31), 2**31 - 1), max_size=12))
def test_joysticks(axes, buttons):
    reading = read_joy(message_class(topics.JOY)(axes=axes, buttons=buttons), 4, 10)
    assert is_sound(reading, lambda values: values.axes)
    assert reading.problem or max(map(abs, reading.values.axes)) <= 1.0


@given(
    spoilt(ARRAY) | THREE.map(lambda values: to_cdr(float_array(topics.VALVE_COMMANDS, 5, values))),
    spoilt(JOINTS) | THREE.map(lambda values: to_cdr(joint_state(topics.JOINTS, 5, values, values, values))),
    spoilt(JOY),
)
def test_bytes_read_after_a_good_message_as_they_read_alone(array, joints, joy):
    """A reader that knows where the numbers stood must not find any where there are none."""
    arrays, alone = (ArrayReader(topics.VALVE_COMMANDS) for _ in range(2))
    assert not arrays.read(ARRAY, 0).problem
    reading = arrays.read(array, 0)
    assert repr(reading) == repr(alone.read(array, 0))
    assert is_sound(reading, lambda values: values)
    known, unknown = (JointReader(topics.JOINTS) for _ in range(2))
    assert not known.read(JOINTS).problem
    reading = known.read(joints)
    assert repr(reading) == repr(unknown.read(joints))
    assert is_sound(reading, joint_numbers)
    assert is_sound(read_joy_data(joy)[0], lambda values: values.axes)


@given(st.lists(spoilt(ARRAY, most=2), min_size=1, max_size=4))
def test_messages_decoded_together_are_what_they_are_one_by_one_or_none(messages):
    together = Encoder(topics.VALVE_COMMANDS).decode(messages)
    if together is None:
        assert any(message != ARRAY for message in messages)
        return
    for message, stamp, row in zip(messages, *together, strict=True):
        sec, nanosec, *values = cdr_type(topics.FLOAT_ARRAY).decode(message).data.tolist()
        assert stamp == int(sec) * 10**9 + int(nanosec)
        assert repr(row.tolist()) == repr(values)
