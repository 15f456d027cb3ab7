"""However a run in lockstep ends, what its nodes said up to there is in their last batches."""

import threading

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.clock.lockstep import LockstepClock
from forest_msgs_py.clock.step_batch import read_batch
from forest_msgs_py.clock.step_order import StepOrder
from forest_msgs_py.clock.step_topics import lockstep_qos
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import JoyValues
from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import ANNOUNCEMENT, STEP_BATCH, message_class
from forest_msgs_py.runtime.node import NodeFailure
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_msgs_py.serialization.packing import pack_clock, pack_joy
from forest_msgs_py.types import PERIOD_NS

QUIET, LAST = 20, 33  # steps in a batch; the run's end, in the middle of one


class Broken(Exception):
    """What a node's callback raises."""


def joy(step):
    return pack_joy(step * PERIOD_NS, f"heartbeat:{step}", JoyValues((0.5, step / 100.0), (1,)))


@pytest.fixture
def run(make_node):
    """Have a machine and a joystick make steps until the joystick ends in some way; return what was told."""

    def made(end):
        recorder = make_node("recorder")
        batches = PolledSubscription(
            recorder, message_class(STEP_BATCH), STEP_BATCH.name, lockstep_qos(), raw=True
        )
        announcements = PolledSubscription(
            recorder, message_class(ANNOUNCEMENT), ANNOUNCEMENT.name, qos(ANNOUNCEMENT, reading=True)
        )
        machine = LockstepClock(make_node("machine"), 0.2, leads=True, quiet=QUIET)
        joystick = LockstepClock(make_node("joystick"), 0.2, quiet=QUIET)
        machine.polled_subscription(topics.JOY)
        speaker, stopping = joystick.publisher(topics.JOY), threading.Event()

        def say():
            step = joystick.stamp() // PERIOD_NS
            speaker.publish(joy(step))
            if step == LAST:
                end(stopping)

        joystick.every(0.0, say)
        endings = []
        threads = [
            threading.Thread(target=ended, args=(machine, threading.Event(), endings)),
            threading.Thread(target=ended, args=(joystick, stopping, endings)),
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60.0)
        order = StepOrder(("machine", "joystick"))
        for message, _ in announcements.take():
            order.add_announcement(message.data)
        for data, _ in batches.take():
            order.add_batch(*read_batch(data))
        return list(order.complete()), endings, order

    return made


def ended(pace, stopping, endings):
    try:
        pace.run(stopping)
    except (Broken, NodeFailure) as error:
        endings.append(error)


def breaks(_stopping):
    raise Broken


@pytest.mark.parametrize("end", [breaks, threading.Event.set], ids=["raises", "is told to stop"])
def test_the_last_account_of_a_run_that_ends_before_its_end_holds_all_that_was_said(run, end):
    told, endings, order = run(end)
    steps = range(1, LAST + 1)
    assert [data for name, _, data in told if name == "/joy"] == [joy(step) for step in steps]
    assert [data for name, _, data in told if name == "/clock"] == [pack_clock(k * PERIOD_NS) for k in steps]
    assert [step for name, step, _ in told if name == "/joy"] == list(steps)
    assert order.lost == ""
    assert order.missing() == f"step {LAST + 1}: no account of joystick"
    assert f"step {LAST + 1}: waited 0.2 s for /joy of joystick" in str(endings[-1])
