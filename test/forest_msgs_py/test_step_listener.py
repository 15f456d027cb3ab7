"""A recorder in lockstep that comes late loses nothing: the machine may be hundreds of steps ahead of it."""

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py import topics
from forest_msgs_py.lockstep import AHEAD
from forest_msgs_py.node import publisher
from forest_msgs_py.step_account import Account
from forest_msgs_py.step_listener import StepListener
from forest_msgs_py.step_topics import DEPTH, STEP_NS

TOPICS = {"one": topics.JOY, "two": topics.JOINT_STATES, "three": topics.VALVE_COMMANDS}


def test_accounts_of_every_step_wait_for_a_recorder_that_comes_late(make_node, wait_until):
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
    for step in range(1, AHEAD + 1):
        for account in accounts:
            account.note(0, step, b"said")
            account.tell(step)
    assert len(accounts) * AHEAD > DEPTH
    found = []
    wait_until(lambda: found.extend(heard.take()) or (found and found[-1].sent_ns == AHEAD * STEP_NS))
    assert len(found) == len(accounts) * AHEAD
