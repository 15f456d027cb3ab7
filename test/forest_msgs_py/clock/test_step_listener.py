"""A recorder in lockstep loses nothing without a word, and nothing at all by coming late."""

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.clock.lockstep import AHEAD
from forest_msgs_py.clock.step_batch import Account
from forest_msgs_py.clock.step_listener import StepListener
from forest_msgs_py.clock.step_topics import DEPTH, STEP_NS
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import NodeFailure, publisher

TOPICS = {"one": topics.JOY, "two": topics.JOINT_STATES, "three": topics.VALVE_COMMANDS}


@pytest.fixture
def run(make_node, wait_until):
    """A listener, and the account of each of its run's nodes."""
    recorder = make_node("recorder")
    heard = StepListener(
        recorder, lambda *_: True, lambda _: None, lambda *_: None, lambda _: True, tuple(TOPICS), 60.0
    )
    accounts = []
    for name, topic in TOPICS.items():
        node = make_node(name)
        publisher(node, topic)
        publisher(node, topics.ROLL).publish(
            topics.message_class(topics.ROLL)(data=f"{name}\n/{topic.name} {topic.type}")
        )
        accounts.append(Account(node, DEPTH))
        wait_until(lambda: accounts[-1]._publisher.get_subscription_count() == 1)
    return heard, accounts


def tell(account, step):
    account.note(0, step, b"said")
    account.tell(step)


def test_accounts_of_every_step_wait_for_a_recorder_that_comes_late(run, wait_until):
    """The machine may be hundreds of steps ahead of it."""
    heard, accounts = run
    for step in range(1, AHEAD + 1):
        for account in accounts:
            tell(account, step)
    assert len(accounts) * AHEAD > DEPTH
    found = []
    wait_until(lambda: found.extend(heard.take()) or (found and found[-1].sent_ns == AHEAD * STEP_NS))
    assert len(found) == len(accounts) * AHEAD


def test_a_lost_account_ends_the_record_before_it(run, wait_until):
    heard, accounts = run
    for account in accounts:
        for step in (1, 2, 3):
            tell(account, step)
    accounts[1]._told = 4  # as if its account of step 4 had been told, and lost
    tell(accounts[1], 5)
    found = []
    with pytest.raises(NodeFailure, match="account of two of steps 4 to 4 was lost"):
        wait_until(lambda: found.extend(heard.take()))
    assert len(found) == 3 * len(accounts)
