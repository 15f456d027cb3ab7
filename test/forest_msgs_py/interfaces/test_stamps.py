"""The stamp is found in a message's bytes, whatever stands around it."""

import pytest

pytest.importorskip("rclpy")

from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Joy
from std_msgs.msg import Float64MultiArray, MultiArrayDimension

from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.stamps import NO_STAMP, stamp_in
from forest_msgs_py.serialization.cdr import to_cdr

STAMP = 1_700_000_000_123_456_789
JOY = Joy(axes=[0.5], buttons=[1])
JOY.header.stamp = messages.ns_to_stamp(STAMP)


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        (topics.JOY, JOY),
        (topics.JOINT_STATES, messages.joint_state(topics.JOINTS, STAMP, (1.0, 2.0, 3.0))),
        (topics.TIP_POSE, messages.pose_stamped(STAMP, "base_link", (1.0, 2.0, 3.0))),
        (topics.CLOCK, Clock(clock=messages.ns_to_stamp(STAMP))),
        *(
            (t, messages.float_array(t, STAMP, [0.5] * len(t.labels)))
            for t in topics.TOPICS
            if t.type == topics.FLOAT_ARRAY
        ),
    ],
    ids=lambda given: getattr(given, "name", ""),
)
def test_the_stamp_is_found(topic, message):
    assert stamp_in(topic.type, to_cdr(message)) == STAMP


def test_an_array_without_labels_or_with_several_dimensions_is_read_too():
    array = Float64MultiArray(data=[1.0, 5.0, 7.0])
    array.layout.data_offset = 2
    assert stamp_in(topics.FLOAT_ARRAY, to_cdr(array)) == 1_000_000_005
    array.layout.dim = [MultiArrayDimension(label="a" * n) for n in range(5)]
    assert stamp_in(topics.FLOAT_ARRAY, to_cdr(array)) == 1_000_000_005


def test_an_array_without_stamp_has_none():
    plain = messages.float_array(topics.VALVE_COMMANDS, STAMP, (1.0, 2.0, 3.0), plain=True)
    assert stamp_in(topics.FLOAT_ARRAY, to_cdr(plain)) == NO_STAMP
    empty = Float64MultiArray()
    empty.layout.data_offset = 2
    assert stamp_in(topics.FLOAT_ARRAY, to_cdr(empty)) == NO_STAMP
