"""What goes into a message comes out of it; what is wrong with one is said, never raised."""

import math
from array import array

import pytest

pytest.importorskip("std_msgs.msg")

from sensor_msgs.msg import Joy
from std_msgs.msg import Float64MultiArray, MultiArrayDimension

from forest_msgs_py.interfaces import messages
from forest_msgs_py.interfaces.topics import JOINTS, PRESSURES, VALVE_COMMANDS

STAMP = 1_700_000_000_123_456_789
NOW = 42


@pytest.mark.parametrize("stamp_ns", [0, 1, STAMP, -1, -1_500_000_000])
def test_stamps_survive_the_round_trip_with_nanoseconds_in_range(stamp_ns):
    stamp = messages.ns_to_stamp(stamp_ns)
    assert 0 <= stamp.nanosec < 10**9
    assert messages.stamp_to_ns(stamp) == stamp_ns


def test_array_carries_stamp_and_labels():
    message = messages.float_array(VALVE_COMMANDS, STAMP, (1.0, -2.0, 3.5))
    assert list(message.data) == [1_700_000_000.0, 123_456_789.0, 1.0, -2.0, 3.5]
    assert message.layout.data_offset == 2
    (dimension,) = message.layout.dim
    assert (dimension.label, dimension.size, dimension.stride) == ("swing,boom,stick", 3, 3)
    reading = messages.read_float_array(VALVE_COMMANDS, message, NOW)
    assert reading == (STAMP, (1.0, -2.0, 3.5), "")


def test_plain_array_is_bare_values_as_of_now():
    message = messages.float_array(VALVE_COMMANDS, STAMP, (1.0, 2.0, 3.0), plain=True)
    assert list(message.data) == [1.0, 2.0, 3.0]
    assert messages.read_float_array(VALVE_COMMANDS, message, NOW) == (NOW, (1.0, 2.0, 3.0), "")


def test_array_typed_by_hand_is_read_by_position():
    message = Float64MultiArray(data=[4.0, 5.0, 6.0])
    assert messages.read_float_array(VALVE_COMMANDS, message, NOW) == (NOW, (4.0, 5.0, 6.0), "")


def test_values_are_matched_by_label():
    message = messages.float_array(VALVE_COMMANDS, STAMP, (1.0, 2.0, 3.0), labels=("stick", "swing", "boom"))
    assert messages.read_float_array(VALVE_COMMANDS, message, NOW).values == (2.0, 3.0, 1.0)


def test_a_machine_without_some_sensors_is_read_for_those_it_has():
    present = ("boom_1_actuator", "boom_2_actuator")
    message = messages.float_array(PRESSURES, STAMP, (1e6, 2e6), labels=present)
    assert messages.read_float_array(PRESSURES, message, NOW, labels=present).values == (1e6, 2e6)
    assert "no value of swing_1_valve" in messages.read_float_array(PRESSURES, message, NOW).problem


def test_wrong_number_of_values_is_refused_when_writing():
    with pytest.raises(ValueError, match="2 values; allowed: 3"):
        messages.float_array(VALVE_COMMANDS, STAMP, (1.0, 2.0))


def _array(data, offset=0, label=""):
    message = Float64MultiArray(data=array("d", data))
    message.layout.data_offset = offset
    message.layout.dim = [MultiArrayDimension(label=label)] if label else []
    return message


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (_array([1.0, 2.0]), "2 values; allowed: 3 (swing, boom, stick)"),
        (_array([]), "0 values"),
        (_array([1.0, math.nan, 2.0]), "boom is nan; allowed: finite"),
        (_array([1.0, 2.0, math.inf]), "stick is inf"),
        (_array([1.0, 2.0, 3.0], offset=7), "data_offset is 7; allowed: 0, or 2"),
        (_array([1.0], offset=2), "1 numbers"),
        (_array([math.nan, 0.0, 1.0, 2.0, 3.0], offset=2), "stamp is (nan, 0.0)"),
        (_array([1.0, 2e9, 1.0, 2.0, 3.0], offset=2), "stamp is"),
        (_array([1e300, 0.0, 1.0, 2.0, 3.0], offset=2), "stamp is"),
        (_array([1.5, 0.0, 1.0, 2.0, 3.0], offset=2), "stamp is"),
        (_array([1.0, 2.0, 3.0], label="swing,boom,arm"), "no value of stick; allowed: swing, boom, stick"),
        (_array([1.0, 2.0, 3.0, 4.0], label="swing,boom,stick,boom"), "labels repeat"),
    ],
)
def test_a_bad_array_gives_no_values_and_says_what_is_allowed(message, problem):
    reading = messages.read_float_array(VALVE_COMMANDS, message, NOW)
    assert reading.values == ()
    assert reading.problem.startswith("valve_commands: ")
    assert problem in reading.problem


def test_a_sensor_without_a_sample_has_no_label_and_its_topic_no_nan():
    message = messages.sensor_array(VALVE_COMMANDS, STAMP, (1.0, math.nan, 3.0))
    assert (message.layout.dim[0].label, message.layout.dim[0].size) == ("swing,stick", 2)
    assert list(message.data[2:]) == [1.0, 3.0]
    assert messages.read_float_array(VALVE_COMMANDS, message, NOW, labels=("stick",)).values == (3.0,)
    reading = messages.read_float_array(VALVE_COMMANDS, message, NOW)
    assert reading == (STAMP, (), "valve_commands: no value of boom; allowed: swing, boom, stick")
    assert messages.sensor_array(VALVE_COMMANDS, STAMP, (math.nan,) * 3) is None


def test_with_every_sample_there_sensors_say_what_an_array_says():
    values = (1.0, 2.0, 3.0)
    for plain in (False, True):
        told = messages.sensor_array(VALVE_COMMANDS, STAMP, values, plain)
        assert told == messages.float_array(VALVE_COMMANDS, STAMP, values, plain)
    told = messages.sensor_joint_state(JOINTS, STAMP, values, values, values)
    assert told == messages.joint_state(JOINTS, STAMP, values, values, values)


def test_a_plain_array_with_a_gap_still_says_whose_values_it_has():
    message = messages.sensor_array(VALVE_COMMANDS, STAMP, (1.0, math.nan, 3.0), plain=True)
    reading = messages.read_float_array(VALVE_COMMANDS, message, NOW, labels=("swing", "stick"))
    assert reading == (NOW, (1.0, 3.0), "")


def test_a_joint_without_a_sample_is_not_named_and_its_readers_are_told():
    told = messages.sensor_joint_state(
        JOINTS, STAMP, (1.0, math.nan, 3.0), (0.1, math.nan, 0.3), (7.0, 8.0, 9.0)
    )
    assert (told.name, list(told.position), list(told.velocity)) == (
        ["swing", "stick"],
        [1.0, 3.0],
        [0.1, 0.3],
    )
    assert list(told.effort) == [7.0, 9.0]
    assert "no position of boom" in messages.read_joint_state(JOINTS, told).problem
    assert messages.sensor_joint_state(JOINTS, STAMP, (math.nan,) * 3, (0.0,) * 3, (0.0,) * 3) is None


def test_where_one_effort_is_not_known_none_is_told():
    told = messages.sensor_joint_state(JOINTS, STAMP, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3), (7.0, math.nan, 9.0))
    assert (list(told.velocity), list(told.effort)) == ([0.1, 0.2, 0.3], [])
    assert messages.read_joint_state(JOINTS, told).problem == ""


def test_joints_are_read_by_name_among_others():
    names = ("stick", "bucket", "swing", "boom")
    message = messages.joint_state(names, STAMP, (3.0, 9.0, 1.0, 2.0), (0.3, 0.9, 0.1, 0.2))
    reading = messages.read_joint_state(JOINTS, message)
    assert reading == (STAMP, ((1.0, 2.0, 3.0), (0.1, 0.2, 0.3), ()), "")


def test_a_missing_joint_and_a_position_that_is_no_number_are_problems():
    without = messages.joint_state(("swing", "boom"), STAMP, (1.0, 2.0))
    assert "no position of stick" in messages.read_joint_state(JOINTS, without).problem
    short = messages.joint_state(JOINTS, STAMP, (1.0, 2.0))
    assert "no position of stick" in messages.read_joint_state(JOINTS, short).problem
    broken = messages.joint_state(JOINTS, STAMP, (1.0, math.nan, 2.0))
    reading = messages.read_joint_state(JOINTS, broken)
    assert "allowed: finite numbers" in reading.problem
    assert reading.values.position == ()


def test_a_joint_that_is_told_twice_is_a_problem_and_a_strange_one_is_not():
    twice = messages.joint_state((*JOINTS, "boom"), STAMP, (1.0, 2.0, 3.0, 2.1))
    assert "more than one boom; allowed: each joint once" in messages.read_joint_state(JOINTS, twice).problem
    strange = messages.joint_state((*JOINTS, "wheel", "wheel"), STAMP, (1.0, 2.0, 3.0, 4.0, 5.0))
    assert messages.read_joint_state(JOINTS, strange).problem == ""


def test_speed_and_effort_that_are_not_finite_count_as_absent():
    message = messages.joint_state(JOINTS, STAMP, (1.0, 2.0, 3.0), (0.0, math.nan, 0.0), (1.0, 2.0))
    assert messages.read_joint_state(JOINTS, message) == (STAMP, ((1.0, 2.0, 3.0), (), ()), "")


@pytest.mark.parametrize(
    ("axes", "buttons", "problem"),
    [
        ([0.0, 1.0, -1.0, 0.5], [1], ""),
        ([0.0, 1.0], [1], "2 axes and 1 buttons; allowed: at least 4 and 1"),
        ([0.0] * 4, [], "4 axes and 0 buttons"),
        ([0.0, 1.5, 0.0, 0.0], [0], "allowed: -1..1"),
        ([0.0, math.nan, 0.0, 0.0], [0], "allowed: -1..1"),
    ],
)
def test_joystick_is_checked_for_size_and_range(axes, buttons, problem):
    reading = messages.read_joy(Joy(axes=axes, buttons=buttons))
    assert problem in reading.problem
    assert (reading.problem == "") == (problem == "")
    assert reading.values.axes == (tuple(axes) if not problem else ())


def test_tip_messages_carry_stamp_frame_and_vector():
    twist = messages.twist_stamped(STAMP, "base_link", (0.1, -0.2, 0.3))
    pose = messages.pose_stamped(STAMP, "base_link", (5.0, 0.0, 1.0))
    for message in (twist, pose):
        assert messages.stamp_to_ns(message.header.stamp) == STAMP
        assert message.header.frame_id == "base_link"
    assert (twist.twist.linear.x, twist.twist.linear.y, twist.twist.linear.z) == (0.1, -0.2, 0.3)
    assert (pose.pose.position.x, pose.pose.position.z) == (5.0, 1.0)


def test_a_tip_whose_orientation_is_not_known_has_none_rather_than_the_identity():
    turned = (0.5, -0.5, 0.5, 0.5)
    for told, expected in ((turned, turned), ((), (0.0,) * 4), ((0.5, math.nan, 0.5, 0.5), (0.0,) * 4)):
        turn = messages.pose_stamped(STAMP, "base_link", (5.0, 0.0, 1.0, *told)).pose.orientation
        assert (turn.x, turn.y, turn.z, turn.w) == expected
