"""A recorder in lockstep loses nothing without a word, and nothing at all by coming late."""

import pytest

pytest.importorskip("rclpy")

from rclpy.parameter import Parameter

from forest_msgs_py.clock.lockstep import AHEAD, END
from forest_msgs_py.clock.step_batch import StepBatch
from forest_msgs_py.clock.step_listener import StepListener, listener
from forest_msgs_py.clock.step_topics import DEPTH, lockstep_qos, no_output
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import stamp_to_ns
from forest_msgs_py.introspection.graph_listener import GraphListener
from forest_msgs_py.runtime.node import Finished, NodeFailure, publisher
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
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


def test_what_is_wanted_of_a_run_and_beside_it_is_heard_to_its_end_which_is_told_once(make_node, wait_until):
    recorder, settled, offered = make_node("recorder"), [False], {}
    heard = StepListener(
        recorder,
        lambda name, _: name in ("/joy", "/events", "/robot_description"),
        lambda topic: offered.setdefault(topic.name, topic),
        lambda *_: None,
        lambda nodes: nodes == ("one",) and settled[0],
        ("one",),
        60.0,
    )
    taken = PolledSubscription(
        make_node("machine"), topics.message_class(topics.RECORDED), topics.RECORDED.name, lockstep_qos()
    )
    node, other = make_node("one"), make_node("other")
    for topic in (topics.JOY, topics.JOINT_STATES):
        publisher(node, topic)
    latched, events = publisher(node, topics.ROBOT_DESCRIPTION), publisher(other, topics.EVENTS)
    lines = [f"/{t.name} {t.type}" for t in (topics.JOINT_STATES, topics.JOY, topics.ROBOT_DESCRIPTION)]
    publisher(node, topics.ANNOUNCEMENT).publish(
        topics.message_class(topics.ANNOUNCEMENT)(data="\n".join(["one", *lines]) + " latched")
    )
    ends = node.create_publisher(
        topics.message_class(topics.NO_OUTPUT), topics.NO_OUTPUT.name, lockstep_qos()
    )
    latched.publish(topics.message_class(topics.ROBOT_DESCRIPTION)(data="urdf"))
    batch, found = StepBatch(node, DEPTH), []
    for step in (1, 2):
        batch.note(0, step, b"joints")
        batch.note(1, step, b"joy")
        batch.tell(step)
    wait_until(lambda: found.extend(heard.take()) or len(found) == 3)
    assert [one._replace(data=b"") for one in found] == [
        (0, "/robot_description", b"", 0, 1, 0),
        (PERIOD_NS, "/joy", b"", PERIOD_NS, 1, 0),
        (2 * PERIOD_NS, "/joy", b"", 2 * PERIOD_NS, 2, 0),
    ]
    assert {name: topic.type for name, topic in offered.items()} == {
        "/joy": topics.JOY.type,
        "/robot_description": topics.ROBOT_DESCRIPTION.type,
    }
    assert heard.context_ns() == 0
    assert stamp_to_ns(next(taken.take())[0].clock) == 2 * PERIOD_NS
    wait_until(lambda: heard.look() or events.get_subscription_count() == 1)
    events.publish(topics.message_class(topics.EVENTS)(data="beside"))
    wait_until(lambda: found.extend(heard.take()) or len(found) == 4)
    assert (found[3].name, found[3].received_ns, found[3].sent_ns) == (
        "/events",
        2 * PERIOD_NS,
        2 * PERIOD_NS,
    )
    ends.publish(no_output(END, 2))
    wait_until(lambda: heard.take() or heard._end == 2)
    heard._guard = 0.0  # after the end nothing is waited for
    assert heard.take() == []
    settled[0] = True
    with pytest.raises(Finished):
        heard.take()
    assert heard.take() == []


def test_a_step_that_is_not_completed_is_waited_for_as_long_as_the_guard_says(make_node):
    heard = StepListener(
        make_node("recorder"), lambda *_: True, print, lambda *_: None, lambda _: True, ("one",), 0.0
    )
    with pytest.raises(NodeFailure, match="waited 0 s; step 0: no outputs told by one"):
        heard.take()


def test_a_recorder_speaks_ten_seconds_after_the_nodes_that_wait_for_one_another(make_node):
    told = {"lockstep_nodes": ["one", ""], "lockstep_guard": 3.0}
    names = [Parameter(name, value=value) for name, value in told.items()]
    rest = (lambda *_: True, print, print, lambda _: True)
    heard = listener(make_node("recorder", parameter_overrides=names), *rest)
    assert (heard._guard, heard._nodes) == (13.0, ["one"])
    assert isinstance(listener(make_node("live"), *rest), GraphListener)


def test_a_run_of_one_step_is_not_over_before_that_was_taken(make_node, wait_until):
    node, recorder = make_node("one"), make_node("recorder")
    heard = StepListener(recorder, lambda *_: True, print, print, lambda _: True, ("one",), 60.0)
    ends = node.create_publisher(
        topics.message_class(topics.NO_OUTPUT), topics.NO_OUTPUT.name, lockstep_qos()
    )
    ends.publish(no_output(END, 1))
    wait_until(lambda: heard.take() or heard._end == 1)
    assert heard.take() == []
