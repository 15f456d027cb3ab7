"""Our CDR is read back by ROS as the message it was, and is no longer than ROS' own."""

import math

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovariance
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool, String

from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.serialization.cdr import to_cdr

STAMP = 1_700_000_000_123_456_789
STATUS = DiagnosticStatus(level=b"\x01", name="pump", values=[KeyValue(key="a", value="bcd"), KeyValue()])
COVARIANCE = PoseWithCovariance()
COVARIANCE.covariance[7] = 0.25

MESSAGES = [
    messages.joint_state(topics.JOINTS, STAMP, (1.0, -2.0, math.pi), (0.1, 0.2, 0.3), (4.0, 5.0, 6.0)),
    messages.joint_state(("a", "bcdefg"), STAMP, (1.0, 2.0)),
    messages.float_array(topics.PRESSURES, STAMP, tuple(map(float, range(12)))),
    messages.pose_stamped(STAMP, "base_link", (1.0, 2.0, 3.0)),
    messages.twist_stamped(STAMP, "b", (1.0, 2.0, 3.0)),
    Joy(axes=[0.5, -0.25, 1.0], buttons=[1, 0, 1, 1]),
    String(data="<robot name='Gänseblümchen'/>"),
    Bool(data=True),
    COVARIANCE,
]


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_ros_reads_the_message_back(message):
    data = to_cdr(message)
    assert deserialize_message(data, type(message)) == message
    assert 0 <= len(serialize_message(message)) - len(data) <= 8  # of which ROS leaves some unused at the end
    assert data == to_cdr(deserialize_message(data, type(message)))


def test_gaps_between_fields_are_zero():
    data = to_cdr(messages.joint_state(("ab",), 0, (1.0,)))
    # stamp, frame "", pad, one name "ab", pad, one position, one double, then two empty sequences
    assert data[4:].hex(" ", 4) == (
        "00000000 00000000 01000000 00000000 01000000 03000000 61620000 01000000 "
        "00000000 0000f03f 00000000 00000000"
    )


def test_nested_messages_with_strings_are_read_back():
    message = DiagnosticArray(status=[DiagnosticStatus(name="x"), STATUS])
    message.status[0].level = b"\x02"
    assert deserialize_message(to_cdr(message), DiagnosticArray) == message


def test_a_kind_that_is_not_encoded_is_told():
    class Wide:
        data = "x"

        @staticmethod
        def get_fields_and_field_types():
            return {"data": "wstring"}

    with pytest.raises(ValueError, match="wstring cannot be encoded; allowed: boolean"):
        to_cdr(Wide())
