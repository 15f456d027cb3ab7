"""Which message counts in which step in lockstep, also where an answer comes a step, or forty, later."""

import math
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

import rclpy
from rclpy.serialization import deserialize_message

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


def test_the_newest_message_grows_older_by_each_step_without_one(box):
    polled = box(LATE)
    assert polled.age() == math.inf
    say(polled, 1, 3)
    polled.collect()
    ages = []
    for step in range(1 + LATE, 5 + LATE):
        polled.turn_to(step * PERIOD_NS)
        ages.append(polled.age() / 0.005)
    assert ages == pytest.approx([LATE, LATE + 1, LATE, LATE + 1])
    assert polled.count == 2


def test_of_a_recorders_answers_the_last_is_kept(box):
    polled = box(0)
    assert not polled.reached(PERIOD_NS)
    say(polled, 1, 2, 3)
    polled.collect()
    assert [polled.reached(step * PERIOD_NS) for step in (2, 3, 4)] == [True, True, False]
    assert list(polled._waiting) == [3 * PERIOD_NS]
    say(polled, 5)
    polled.collect()
    assert polled.reached(4 * PERIOD_NS)
    assert list(polled._waiting) == [5 * PERIOD_NS]


def test_steps_without_output_that_follow_each_other_are_told_as_one_span():
    told = []
    node = SimpleNamespace(create_publisher=lambda *_: SimpleNamespace(publish=told.append))
    report = step_topics.IdleReport(node)
    for step in (1, 2, 3, 4, 6):
        report.note(step, ["/a"] if step < 3 else ["/b", "/a"])
    report.tell(6)
    report.tell(7)
    (data,) = told
    header = deserialize_message(data, topics.message_class(topics.IDLE))
    assert header.frame_id == "/a@1-4 /b@3-4 /b@6-6 /a@6-6"
    assert header.stamp.nanosec == 6 * PERIOD_NS
