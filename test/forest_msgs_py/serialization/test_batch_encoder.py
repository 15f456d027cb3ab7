"""Messages encoded by the thousand are byte for byte those encoded one by one."""

import numpy as np
import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.topics import columns
from forest_msgs_py.serialization.batch_encoder import Encoder
from forest_msgs_py.serialization.cdr import to_cdr

STAMPS = np.array([0, 5_000_000, 1_700_000_000_123_456_789])


def one(topic, stamp, values):
    if topic.type == topics.JOINT_STATE:
        n = len(topic.labels)
        return messages.joint_state(topic.labels, stamp, values[:n], values[n : 2 * n], values[2 * n :])
    make = {topics.POSE: messages.pose_stamped, topics.TWIST: messages.twist_stamped}.get(topic.type)
    return messages.float_array(topic, stamp, values) if make is None else make(stamp, "base_link", values)


@pytest.mark.parametrize(
    "topic",
    [
        topics.JOINT_STATES,
        topics.ACTUATOR_STATES,
        topics.PRESSURES,
        topics.AUXILIARY,
        topics.GROUND_TRUTH_TIP_POSE,
        topics.GROUND_TRUTH_TIP_TWIST,
    ],
    ids=lambda topic: topic.name,
)
def test_bytes_are_those_of_single_messages(topic):
    values = np.random.default_rng(1).normal(size=(len(STAMPS), len(columns(topic))))
    encoded = Encoder(topic, "base_link").encode(STAMPS, values)
    expected = [
        to_cdr(one(topic, stamp, row)) for stamp, row in zip(STAMPS.tolist(), values.tolist(), strict=True)
    ]
    assert encoded == expected


def test_a_reading_that_is_missing_has_no_label_and_an_empty_message_is_none():
    values = np.zeros((3, 12))
    values[1, 4:], values[2, :] = np.nan, np.nan
    whole, part, nothing = Encoder(topics.PRESSURES).encode(STAMPS, values)
    assert nothing is None
    assert whole == to_cdr(one(topics.PRESSURES, 0, [0.0] * 12))
    labels = topics.PRESSURES.labels[:4]
    assert part == to_cdr(messages.float_array(topics.PRESSURES, 5_000_000, [0.0] * 4, labels=labels))


def test_a_tip_without_a_place_is_left_out_and_one_without_an_orientation_is_not():
    values = np.ones((3, 7))
    values[1, 3:], values[2, 1] = np.nan, np.nan
    whole, placed, nothing = Encoder(topics.TIP_POSE, "base_link").encode(STAMPS, values)
    assert whole == to_cdr(messages.pose_stamped(0, "base_link", (1.0,) * 7))
    assert placed == to_cdr(messages.pose_stamped(5_000_000, "base_link", (1.0,) * 3))
    assert nothing is None


def test_a_joint_that_is_missing_is_left_out():
    values = np.zeros((3, 9))
    values[:, [1, 4, 7]] = np.nan
    encoded = Encoder(topics.JOINT_STATES).encode(STAMPS, values)
    expected = messages.joint_state(("swing", "stick"), 0, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    assert encoded[0] == to_cdr(expected)


def test_a_message_that_is_not_numbers_is_refused():
    with pytest.raises(ValueError, match="robot_description: std_msgs/msg/String is not a stamp and numbers"):
        columns(topics.ROBOT_DESCRIPTION)
