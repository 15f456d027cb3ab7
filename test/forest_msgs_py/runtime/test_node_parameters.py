"""A wrong parameter is refused in words that name it, its value and what is allowed."""

import re

import pytest

pytest.importorskip("rclpy")

from rclpy.parameter import Parameter

from forest_msgs_py.runtime.node_parameters import ParameterError, declare


@pytest.fixture
def node_with(make_node):
    def make(**overrides):
        values = [Parameter(name, value=value) for name, value in overrides.items()]
        return make_node("declarer", parameter_overrides=values)

    return make


def test_default_and_whole_numbers_come_back_as_floats(node_with):
    node = node_with(given=1)
    assert declare(node, "default", 0.5, "a time", "s", 0.01, 10.0) == 0.5
    value = declare(node, "given", 0.5, "a time", "s", 0.01, 10.0)
    assert (value, type(value)) == (1.0, float)
    assert node.get_parameter("given").value == 1.0


def test_descriptor_tells_range_unit_and_that_it_is_read_only(node_with):
    node = node_with()
    declare(node, "rate", 200.0, "how often", "Hz", 50.0, 500.0)
    descriptor = node.describe_parameter("rate")
    (limits,) = descriptor.floating_point_range
    assert (limits.from_value, limits.to_value) == (50.0, 500.0)
    assert descriptor.read_only
    assert "[Hz]" in descriptor.description
    assert not node.set_parameters([Parameter("rate", value=100.0)])[0].successful


def test_a_parameter_that_may_change_keeps_to_its_range(node_with):
    node = node_with()
    declare(node, "gain", 1.0, "a gain", "", 0.0, 2.0, read_only=False)
    assert node.set_parameters([Parameter("gain", value=1.5)])[0].successful
    assert not node.set_parameters([Parameter("gain", value=3.0)])[0].successful
    assert node.get_parameter("gain").value == 1.5


@pytest.mark.parametrize(
    ("value", "default", "options", "words"),
    [
        (-3, 1.0, {"unit": "s", "low": 0.01, "high": 10}, "parameter 'x' is -3; allowed: 0.01 .. 10 s"),
        (float("nan"), 1.0, {}, "'x' is nan; allowed: a finite number"),
        ("fast", 1.0, {}, "'x' is 'fast'; allowed: a finite number"),
        (True, 1.0, {}, "'x' is True; allowed: a finite number"),
        (2.5, 3, {"low": 0}, "'x' is 2.5; allowed: 0 .. inf"),
        (1, False, {}, "'x' is 1; allowed: true or false"),
        (7, "a", {}, "'x' is 7; allowed: a text"),
        ("c", "a", {"choices": ("a", "b")}, "'x' is 'c'; allowed: one of a, b"),
        ([1.0, -1.0], [0.0], {"low": 0.0}, "allowed: 0 .. inf"),
        (["a"], [0.0], {}, "allowed: a list"),
    ],
)
def test_a_wrong_value_is_named_with_what_is_allowed(node_with, value, default, options, words):
    node = node_with(x=value)
    with pytest.raises(ParameterError, match=re.escape(words)):
        declare(node, "x", default, "something", **options)


def test_a_list_of_whole_numbers_is_a_list_of_floats(node_with):
    assert declare(node_with(x=[1, 2]), "x", [0.0], "offsets") == [1.0, 2.0]
