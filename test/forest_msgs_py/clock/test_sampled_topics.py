import math

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.clock.sampled_topics import SampledTopics, Wanted
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, joint_state
from forest_msgs_py.serialization.cdr import to_cdr

PERIOD_NS = 5_000_000
ANGLES = 0.1, 0.4, -1.4
ZERO = 0.0, 0.0, 0.0


class Clock:
    """Time and arrivals by hand."""

    def __init__(self):
        self.time, self.callbacks, self.order = 0.0, {}, []

    def now(self):
        return self.time

    def on(self, topic, callback):
        self.callbacks[topic] = callback

    def say(self, topic, message):
        self.callbacks[topic](to_cdr(message), self.time)


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def sampled(clock):
    wanted = {
        topics.SUPPLY: Wanted(("pressure", "flow"), 0.1),
        topics.VALVE_VOLTAGES: Wanted(topics.VALVE_VOLTAGES.labels, 0.5),
    }
    return SampledTopics(
        clock,
        wanted,
        step=lambda joints, dt: clock.order.append((joints.position, round(dt, 6))),
        period=0.005,
        report=lambda stamp: clock.order.append(stamp),
        report_period=0.01,
    )


def joints(stamp_ns, angles=ANGLES):
    return joint_state(topics.JOINTS, stamp_ns, angles, ZERO, ZERO)


def test_each_joint_state_is_a_step_of_its_stamps_time_and_some_are_reported_behind_it(clock, sampled):
    for k in (200, 201, 203, 204, 205):
        clock.say(topics.JOINT_STATES, joints(k * PERIOD_NS))
    assert [dt for _, dt in filter(lambda one: isinstance(one, tuple), clock.order)] == [
        *(0.005, 0.005, 0.01, 0.005, 0.005)
    ]
    assert {one[0] for one in clock.order if isinstance(one, tuple)} == {ANGLES}
    reports = [k for k, one in enumerate(clock.order) if isinstance(one, int)]
    assert [clock.order[k] for k in reports] == [k * PERIOD_NS for k in (201, 203, 205)]
    assert reports == [2, 4, 7]


def test_a_state_that_is_none_is_no_step(clock, sampled):
    clock.say(topics.JOINT_STATES, joints(PERIOD_NS, (math.nan, 0.0, 0.0)))
    clock.callbacks[topics.JOINT_STATES](b"\x00\x01", 0.0)
    assert clock.order == []


def test_a_topic_is_known_from_its_first_message_until_it_is_too_old(clock, sampled):
    nothing = [math.nan] * 2
    assert [*sampled.newest(topics.SUPPLY)] == pytest.approx(nothing, nan_ok=True)
    clock.time = 7.0
    for pressure in (1e7, 2e7):
        clock.say(topics.SUPPLY, float_array(topics.SUPPLY, 10**9, (pressure, 1e-3, 0.1)))
    clock.say(topics.VALVE_VOLTAGES, float_array(topics.VALVE_VOLTAGES, 10**9, (1.0, 2.0, 3.0)))
    clock.time = 7.09
    assert sampled.newest(topics.SUPPLY) == (2e7, 1e-3)
    clock.time = 7.11
    assert [*sampled.newest(topics.SUPPLY)] == pytest.approx(nothing, nan_ok=True)
    assert sampled.newest(topics.VALVE_VOLTAGES) == (1.0, 2.0, 3.0)  # each by its own timeout
