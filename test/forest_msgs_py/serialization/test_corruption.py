"""Claims about readers under random corruption: they never raise; finite numbers or a problem, never both."""

import math
from array import array

import numpy as np
import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import (
    float_array,
    joint_state,
    read_float_array,
    read_joint_state,
    read_joy,
)
from forest_msgs_py.interfaces.topics import message_class

WILD = (math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, 0.0, 7.0)
ROUNDS = 3000


def spoilt(rng, values):
    """Return a list of numbers with some of them wild, missing or too many."""
    values = list(values)
    for _ in range(rng.integers(0, 3)):
        kind = rng.integers(3)
        if kind == 0 and values:
            values[rng.integers(len(values))] = WILD[rng.integers(len(WILD))]
        elif kind == 1 and values:
            del values[rng.integers(len(values))]
        else:
            values.insert(rng.integers(len(values) + 1), WILD[rng.integers(len(WILD))])
    return values


def is_sound(reading, numbers):
    """Tell whether a reading gives finite numbers, or a problem and none."""
    if reading.problem:
        return not any(reading.values) and "; allowed: " in reading.problem
    return all(map(math.isfinite, numbers(reading.values)))


def test_arrays():
    rng, good = np.random.default_rng(1), 0
    for _ in range(ROUNDS):
        message = float_array(topics.VALVE_COMMANDS, 5, (1.0, 2.0, 3.0), plain=bool(rng.integers(2)))
        message.data = array("d", spoilt(rng, message.data))
        if rng.random() < 0.1:
            message.layout.data_offset = int(rng.integers(0, 5))
        if rng.random() < 0.1:
            message.layout.dim[0].label = ("", "swing,boom", "swing,swing,stick", "a,b,c")[rng.integers(4)]
        reading = read_float_array(topics.VALVE_COMMANDS, message, 0)
        assert is_sound(reading, lambda values: values)
        good += not reading.problem
    assert 0.2 * ROUNDS < good < 0.8 * ROUNDS


def test_joint_states():
    rng, good = np.random.default_rng(2), 0
    for _ in range(ROUNDS):
        message = joint_state(topics.JOINTS, 5, (0.1, 0.2, 0.3), (0.0, 0.1, 0.2), (1.0, 2.0, 3.0))
        message.position = array("d", spoilt(rng, message.position))
        message.velocity = array("d", spoilt(rng, message.velocity))
        if rng.random() < 0.2:
            message.name = [str(name) for name in rng.choice([*topics.JOINTS, "elbow"], rng.integers(0, 5))]
        reading = read_joint_state(topics.JOINTS, message)
        assert is_sound(reading, lambda values: (*values.position, *values.velocity, *values.effort))
        good += not reading.problem
    assert 0.2 * ROUNDS < good < 0.8 * ROUNDS


def test_joysticks():
    rng, good = np.random.default_rng(3), 0
    for _ in range(ROUNDS):
        axes = [min(3.0e38, max(-3.0e38, x)) for x in spoilt(rng, rng.uniform(-1.0, 1.0, 6).tolist())]
        buttons = [int(x) for x in rng.integers(-3, 4, rng.integers(0, 25))]
        message = message_class(topics.JOY)(axes=axes, buttons=buttons)
        reading = read_joy(message, 4, 10)
        assert is_sound(reading, lambda values: values.axes)
        if not reading.problem:
            assert max(map(abs, reading.values.axes)) <= 1.0
        good += not reading.problem
    assert 0.2 * ROUNDS < good < 0.8 * ROUNDS
