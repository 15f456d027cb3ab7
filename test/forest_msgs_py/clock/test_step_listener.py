"""A recorder in lockstep loses nothing without a word, and nothing at all by coming late."""

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.clock.lockstep import AHEAD
from forest_msgs_py.clock.step_batch import StepBatch
from forest_msgs_py.clock.step_listener import StepListener
from forest_msgs_py.clock.step_topics import DEPTH
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import NodeFailure, publisher
from forest_msgs_py.types import PERIOD_NS

TOPICS = {"one": topics.JOY, "two": topics.JOINT_STATES, "three": topics.VALVE_COMMANDS}


@pytest.fixture
def run(make_node, wait_until):
    """A listener, and the account of each of its run's nodes."""
    recorder = make_node("recorder")
    heard = StepListener(
        recorder, lambda *_: True, lambda _: None, lambda *_: None, lambda _: True, tuple(TOPICS), 60.0
    )
    batches = []
    for name, topic in TOPICS.items():
        node = make_node(name)
        publisher(node, topic)
        publisher(node, topics.ANNOUNCEMENT).publish(
            topics.message_class(topics.ANNOUNCEMENT)(data=f"{name}\n/{topic.name} {topic.type}")
        )
        batches.append(StepBatch(node, DEPTH))
        wait_until(lambda: batches[-1]._publisher.get_subscription_count() == 1)
    return heard, batches


def tell(batch, step):
    batch.note(0, step, b"said")
    batch.tell(step)


def test_accounts_of_every_step_wait_for_a_recorder_that_comes_late(run, wait_until):
    """The machine may be hundreds of steps ahead of it."""
    heard, batches = run
    for step in range(1, AHEAD + 1):
        for batch in batches:
            tell(batch, step)
    assert len(batches) * AHEAD > DEPTH
    found = []
    wait_until(lambda: found.extend(heard.take()) or (found and found[-1].sent_ns == AHEAD * PERIOD_NS))
    assert len(found) == len(batches) * AHEAD


def test_a_lost_account_ends_the_record_before_it(run, wait_until):
    heard, batches = run
    for batch in batches:
        for step in (1, 2, 3):
            tell(batch, step)
    batches[1]._told = 4  # as if its batch of step 4 had been told, and lost
    tell(batches[1], 5)
    found = []
    with pytest.raises(NodeFailure, match="account of two of steps 4 to 4 was lost"):
        wait_until(lambda: found.extend(heard.take()))
    assert len(found) == 3 * len(batches)
