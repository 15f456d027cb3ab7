"""Our CDR is read back by ROS as the message it was, and is no longer than ROS' own."""

import math
import struct

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovariance
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool, String

from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.serialization.cdr import ENCAPSULATION, CdrError, CdrType, cdr_type, to_cdr

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
    with pytest.raises(ValueError, match=r"a/msg/B has a definition that cannot be used: .*wstring"):
        CdrType("a/msg/B", "wstring data\n")
    with pytest.raises(ValueError, match="a/msg/B is not installed here"):
        cdr_type("a/msg/B")


LINE = "=" * 80 + "\n"
MSG = f"a/Point[] points\nuint8 n\n{LINE}MSG: a/Point\nfloat32 x\nfloat32 y\n"
POINT = "module a { module msg { struct Point { float x; float y; }; }; };\n"
WHOLE = "module a { module msg { struct B { sequence<a::msg::Point> points; uint8 n; }; }; };\n"
IDL = f"{LINE}IDL: a/msg/Point\n{POINT}{LINE}IDL: a/msg/B\n{WHOLE}"


@pytest.mark.parametrize("definition", [MSG, IDL], ids=["ros2msg", "ros2idl"])
def test_a_type_that_is_not_installed_is_decoded_by_a_definition(definition):
    kind = cdr_type("a/msg/B", definition)
    data = ENCAPSULATION + struct.pack("<IffffB", 2, 1.5, 2.5, -3.5, 4.5, 7)
    message = kind.decode(data)
    assert [(point.x, point.y) for point in message.points] == [(1.5, 2.5), (-3.5, 4.5)]
    assert message.n == 7
    big = b"\x00\x00\x00\x00" + struct.pack(">IffffB", 2, 1.5, 2.5, -3.5, 4.5, 7)
    assert kind.decode(big) == message
    for end in range(len(data)):
        with pytest.raises(CdrError, match="bytes that are no a/msg/B"):
            kind.decode(data[:end])


def test_what_follows_a_message_is_no_part_of_it():
    message = MESSAGES[1]
    data = serialize_message(message)
    assert len(data) > len(to_cdr(message))  # ROS leaves some bytes unused
    assert cdr_type("sensor_msgs/msg/JointState").decode(data).name == ["a", "bcdefg"]
