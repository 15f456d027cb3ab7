import math

import pytest

pytest.importorskip("rclpy")

from rclpy.serialization import serialize_message

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, joint_state
from forest_msgs_py.serialization.part_reader import PartReader

WANTED = "pressure", "flow"
NAN = pytest.approx(math.nan, nan_ok=True)


def supply(values, labels=topics.SUPPLY.labels):
    return serialize_message(float_array(topics.SUPPLY, 10**9, values, labels=labels))


def test_what_is_there_is_read_and_the_rest_is_nan():
    reader = PartReader(topics.SUPPLY, WANTED)
    assert reader.read(supply((2e7, 1e-3, 0.1))) == (2e7, 1e-3)
    assert reader.read(supply((1e7,), ("pressure",))) == (1e7, NAN)
    assert reader.read(supply((3e7, 2e-3, 0.2))) == (3e7, 2e-3)  # the sensor is there again
    assert reader.read(supply((0.5,), ("saturation",))) == (NAN, NAN)


def test_bytes_that_are_no_message_are_nan():
    reader = PartReader(topics.SUPPLY, WANTED)
    assert reader.read(b"") == (NAN, NAN)
    assert reader.read(supply((math.inf, 1e-3, 0.1))) == (NAN, 1e-3)


def test_a_joint_state_without_a_cylinder_has_the_other():
    reader = PartReader(topics.ACTUATOR_STATES, ("boom_cylinder.position", "stick_cylinder.position"))
    whole = joint_state(topics.ACTUATORS, 10**9, (0.1, 1.5, 2.0), (0.0,) * 3, (0.0,) * 3)
    part = joint_state(("stick_cylinder",), 10**9, (2.5,), (0.0,), (0.0,))
    assert reader.read(serialize_message(whole)) == (1.5, 2.0)
    assert reader.read(serialize_message(part)) == (NAN, 2.5)
