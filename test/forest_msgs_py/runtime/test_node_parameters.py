"""A wrong parameter is refused in words that name it, its value and what is allowed."""

import re
from enum import IntEnum
from typing import Annotated, NamedTuple

import pytest

pytest.importorskip("rclpy")

from rclpy.parameter import Parameter as RosParameter

from forest_msgs_py.runtime.node_parameters import Tunables, declare, declare_one
from forest_msgs_py.runtime.parameter_table import Parameter, ParameterError, table_of, tunable


@pytest.fixture
def node_with(make_node):
    def make(**overrides):
        values = [RosParameter(name, value=value) for name, value in overrides.items()]
        return make_node("declarer", parameter_overrides=values)

    return make


def test_default_and_whole_numbers_come_back_as_floats(node_with):
    node = node_with(given=1)
    time = Parameter("a time", "s", 0.01, 10.0, default=0.5)
    assert declare_one(node, time._replace(name="default")) == 0.5
    value = declare_one(node, time._replace(name="given"))
    assert (value, type(value)) == (1.0, float)
    assert node.get_parameter("given").value == 1.0


def test_descriptor_tells_range_unit_and_that_it_is_read_only(node_with):
    node = node_with()
    declare_one(node, Parameter("how often", "Hz", 50.0, 500.0, name="rate", default=200.0))
    descriptor = node.describe_parameter("rate")
    (limits,) = descriptor.floating_point_range
    assert (limits.from_value, limits.to_value) == (50.0, 500.0)
    assert descriptor.read_only
    assert "[Hz]" in descriptor.description
    assert not node.set_parameters([RosParameter("rate", value=100.0)])[0].successful


def test_a_parameter_that_may_change_keeps_to_its_range(node_with):
    node = node_with()
    declare_one(node, tunable("a gain", "", 0.0, 2.0, name="gain", default=1.0))
    assert node.set_parameters([RosParameter("gain", value=1.5)])[0].successful
    assert not node.set_parameters([RosParameter("gain", value=3.0)])[0].successful
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
        ([1.0, 2.0], (0.0, 0.0, 0.0), {}, "'x' is [1.0, 2.0]; allowed: 3 numbers"),
    ],
)
def test_a_wrong_value_is_named_with_what_is_allowed(node_with, value, default, options, words):
    node = node_with(x=value)
    with pytest.raises(ParameterError, match=re.escape(words)):
        declare_one(node, Parameter("something", **options, name="x", default=default))


def test_a_list_of_whole_numbers_is_a_list_of_floats(node_with):
    row = Parameter("offsets", name="x", default=[0.0])
    assert declare_one(node_with(x=[1, 2]), row) == [1.0, 2.0]


class Mode(IntEnum):
    SLOW = 0
    FAST = 1


class Driving(NamedTuple):
    where: Annotated[tuple[float, float], Parameter("place", "m")]
    mode: Annotated[Mode, tunable("how")] = Mode.SLOW
    speeds: Annotated[tuple[float, ...], tunable("one after the other", "m/s", 0.0, 9.0)] = (0.0,)
    gains: Annotated[tuple[float, float], tunable("of both")] = (1.0, 2.0)


def test_a_table_comes_back_as_its_own_types(node_with):
    node = node_with(mode="fast", speeds=[1, 2, 3], gains=[3, 4])
    values = declare(node, Driving, where=(5.0, 6.0))
    assert values == Driving((5.0, 6.0), Mode.FAST, (1.0, 2.0, 3.0), (3.0, 4.0))
    assert isinstance(values.mode, Mode)
    assert node.get_parameter("mode").value == "fast"
    assert node.describe_parameter("where").read_only
    assert not node.describe_parameter("gains").read_only


def test_a_member_that_an_enumeration_lacks_is_refused(node_with):
    with pytest.raises(ParameterError, match="'mode' is 'fly'; allowed: one of slow, fast"):
        declare(node_with(mode="fly"), Driving, where=(0.0, 0.0))


@pytest.mark.parametrize("value", [None, 5, True, ["exact"], float("nan")])
def test_a_bundle_of_another_type_is_refused_and_not_opened(node_with, value):
    node, told = node_with(), []
    tunables = Tunables(node, {"mode": lambda name: {"gains": [float(len(name))] * 2}})
    tunables.declare(Driving, {"where": (0.0, 0.0)})
    tunables.watch(told.append)
    assert not node.set_parameters([RosParameter("mode", value=value)])[0].successful
    assert not told
    assert node.set_parameters([RosParameter("mode", value="fast")])[0].successful
    assert told[-1]["gains"] == (4.0, 4.0)


def test_tunables_follow_what_is_set_and_refuse_all_of_it_if_one_is_wrong(node_with):
    node, told = node_with(), []
    tunables = Tunables(node)
    assert tunables.declare(Driving, {"where": (0.0, 0.0)}).mode == Mode.SLOW
    tunables.watch(told.append)
    assert node.set_parameters([RosParameter("gains", value=[7.0, 8.0])])[0].successful
    assert table_of(Driving, told[-1]) == Driving((0.0, 0.0), gains=(7.0, 8.0))
    wrong = node.set_parameters([RosParameter("gains", value=[7.0])])[0]
    assert wrong.reason == "parameter 'gains' is [7.0]; allowed: 2 numbers"
    assert len(told) == 1
    assert tunables.values["gains"] == (7.0, 8.0)
