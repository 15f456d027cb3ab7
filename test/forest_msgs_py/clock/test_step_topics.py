"""Which message counts in which step in lockstep, also where an answer comes a step, or forty, later."""

import pytest

pytest.importorskip("rclpy")

import rclpy

from forest_msgs_py.clock import step_topics
from forest_msgs_py.clock.lockstep import LockstepClock
from forest_msgs_py.clock.step_topics import LATE, StepSubscription, steps_without_output
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array
from forest_msgs_py.serialization.cdr import to_cdr
from forest_msgs_py.serialization.unpacking import ArrayReader
from forest_msgs_py.types import PERIOD_NS


class Queue:
    """The middleware's queue, filled by hand."""

    def __init__(self, *_args, **_options):
        self.waiting = []
        self.subscription = self
        self.topic_name = "/valve_driver/status"

    def take(self):
        while self.waiting:
            yield self.waiting.pop(0), {}


@pytest.fixture
def box(monkeypatch):
    monkeypatch.setattr(step_topics, "PolledSubscription", Queue)
    return lambda lag: StepSubscription(None, topics.VALVE_VOLTAGES, lag)


def say(polled, *steps):
    for step in steps:
        message = float_array(topics.VALVE_VOLTAGES, step * PERIOD_NS, (float(step), 0.0, 0.0))
        polled._polled.waiting.append(to_cdr(message))


def heard(polled, step):
    """The step in which what counts in this one was said; None if nothing was said."""
    polled.turn_to(step * PERIOD_NS)
    arrival = polled.newest()
    return None if arrival is None else ArrayReader(topics.VALVE_VOLTAGES).read(arrival.message, 0).values[0]


@pytest.mark.parametrize("lag", [0, 1, LATE])
def test_a_message_counts_so_many_steps_after_it_was_said_and_once(box, lag):
    polled = box(lag)
    say(polled, 1, 2, 3)
    polled.collect()
    for step in (1, 2, 3):
        assert polled.has((step + lag) * PERIOD_NS)
        assert heard(polled, step + lag) == step
        assert polled.newest() is None
    assert not polled.has((4 + lag) * PERIOD_NS)


def test_nobody_waits_for_an_answer_from_before_the_first_step(box):
    late = box(LATE)
    assert all(late.has(step * PERIOD_NS) for step in range(1, LATE + 1))
    assert not late.has((LATE + 1) * PERIOD_NS)
    assert not box(0).has(PERIOD_NS)


def test_its_time_is_that_of_the_step_in_which_it_was_said(box):
    polled = box(LATE)
    say(polled, 1)
    polled.collect()
    polled.turn_to((1 + LATE) * PERIOD_NS)
    assert polled.newest().time == pytest.approx(0.005)


def test_what_was_not_said_is_known_too_and_what_came_early_waits_for_its_step(box):
    polled = box(1)
    polled.without_output(1 * PERIOD_NS)
    say(polled, 3, 2)  # in no order
    polled.collect()
    assert polled.has(2 * PERIOD_NS)
    assert [heard(polled, step) for step in (2, 3, 4)] == [None, 2.0, 3.0]


def test_a_late_inbox_takes_no_more_than_it_needs_for_its_step(box):
    polled = box(LATE)
    say(polled, 1, 2, 3)
    polled.collect((1 + LATE) * PERIOD_NS)
    assert len(polled._polled.waiting) == 2
    assert heard(polled, 1 + LATE) == 1.0


def test_silence_is_told_of_single_steps_and_of_spans():
    kind = topics.message_class(topics.NO_OUTPUT)
    header = kind(frame_id="/joy /valve_driver/status@3-5")
    header.stamp.nanosec = 2 * PERIOD_NS
    told = list(steps_without_output(header))
    assert told == [
        ("/joy", 2 * PERIOD_NS),
        *(("/valve_driver/status", step * PERIOD_NS) for step in (3, 4, 5)),
    ]


def test_a_node_waits_a_step_for_an_answer_and_longer_for_what_is_told_slowly(ros_context):
    node = rclpy.create_node("reader", context=ros_context)
    lockstep = LockstepClock(node, 1.0)
    waits = {
        topics.JOY: lockstep.polled_subscription(topics.JOY),
        topics.VALVE_VOLTAGES: lockstep.polled_subscription(topics.VALVE_VOLTAGES, answered=True),
        topics.VALVE_DRIVER_STATUS: lockstep.polled_subscription(topics.VALVE_DRIVER_STATUS, answered=True),
    }
    first = [next(step for step in range(1, 100) if not box.has(step * PERIOD_NS)) for box in waits.values()]
    assert first == [1, 2, LATE + 1]
    node.destroy_node()
