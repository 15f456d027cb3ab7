"""What a node hears on a topic is told as it is: age, rate and count, and who is missed or not heard."""

import math
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from rclpy.qos import QoSProfile, ReliabilityPolicy

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.polled_subscription import polled_subscription
from forest_msgs_py.safety.input_status import InputStatus

LOSSY = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class Pace:
    """Time by hand."""

    lockstep, time = False, 100.0

    def now(self):
        return self.time


@pytest.fixture
def clock():
    return Pace()


def by_hand(clock, **options):
    """The status of an subscription whose count and age a test sets."""
    profile = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    subscription = SimpleNamespace(count=0, age=lambda: math.inf)
    subscription.subscription = SimpleNamespace(topic_name="/joy", qos_profile=profile)
    return subscription, InputStatus(None, clock, subscription, **options)


def test_nothing_heard_is_said_in_words_and_waited_for(clock):
    _, status = by_hand(clock, what="a joystick")
    assert status.waiting() == "waiting for a joystick on /joy"
    values = {"/joy age [s]": "never heard", "/joy rate [Hz]": "unknown", "/joy messages": 0}
    assert status.values() == values


def test_what_has_come_is_no_longer_waited_for_unless_the_node_misses_it(clock):
    subscription, status = by_hand(clock, what="a joystick")
    subscription.count = 1
    assert status.waiting() == ""
    subscription, status = by_hand(clock, what="a joystick", is_missed=lambda: subscription.count < 3)
    subscription.count = 2
    assert status.waiting() == "waiting for a joystick on /joy"


def test_of_what_need_not_come_nothing_is_waited_for(clock):
    _, status = by_hand(clock)
    assert status.waiting() == ""


def test_the_rate_is_that_since_it_was_asked_for_last_over_half_a_second_at_least(clock):
    subscription, status = by_hand(clock)
    clock.time, subscription.count, subscription.age = 102.0, 100, lambda: 0.25
    values = {"/joy age [s]": 0.25, "/joy rate [Hz]": 50.0, "/joy messages": 100}
    assert status.values() == values
    clock.time, subscription.count = 102.4, 200
    assert status.values()["/joy rate [Hz]"] == 50.0
    clock.time = 103.0
    assert status.values()["/joy rate [Hz]"] == 100.0
    clock.time, subscription.count = 103.6, 230
    assert status.values()["/joy rate [Hz]"] == pytest.approx(50.0)


def test_an_inbox_counts_what_was_taken_and_knows_how_old_the_newest_is(peer, clock):
    box = polled_subscription(peer.node, topics.VALVE_COMMANDS)
    status = InputStatus(peer.node, clock, box, "commands")
    talker = peer.speak(topics.VALVE_COMMANDS)
    for _ in range(3):
        talker.publish(message_class(topics.VALVE_COMMANDS)())
    peer.until(lambda: box.newest() or box.count == 3)
    assert status.waiting() == ""
    assert 0.0 <= status.values()["/valve_commands age [s]"] < 60.0


def test_a_publisher_that_offers_less_than_is_asked_for_is_named_as_long_as_it_is_there(
    peer, clock, make_node
):
    status = InputStatus(peer.node, clock, polled_subscription(peer.node, topics.VALVE_COMMANDS), "commands")
    assert status.unheard() == ""
    pad = make_node("pad", namespace="/cab")
    kind = message_class(topics.VALVE_COMMANDS)
    pad.create_publisher(kind, "/valve_commands", 1)  # reliable
    offered = pad.create_publisher(kind, "/valve_commands", LOSSY)
    peer.until(status.unheard)
    said = "/valve_commands of /cab/pad is not heard: best effort publisher and reliable subscription"
    assert status.unheard() == said
    pad.destroy_publisher(offered)
    peer.until(lambda: not status.unheard())


def test_a_best_effort_joystick_is_heard(peer):
    box = polled_subscription(peer.node, topics.JOY)
    joystick = peer.node.create_publisher(message_class(topics.JOY), "/joy", LOSSY)
    peer.until(lambda: joystick.publish(message_class(topics.JOY)()) or box.newest())


@pytest.mark.parametrize(
    ("way", "told"),
    [
        (-3.2, "/joy: the clock of /{who} is 3.2 s ahead of this host's"),
        (-0.06, "/joy: the clock of /{who} is 0.1 s ahead of this host's"),
        (-0.04, ""),
        (0.19, ""),
        (0.3, "/joy: the clock of /{who} is 0.3 s behind this host's, or the link is late"),
        (2.0, "/joy: the clock of /{who} is 2.0 s behind this host's, or the link is late"),
    ],
)
def test_whose_clock_is_another_is_named_until_its_messages_come_in_time(peer, clock, way, told):
    box = polled_subscription(peer.node, topics.JOY)
    status = InputStatus(peer.node, clock, box, "a joystick")
    note = box.note
    box.note = lambda info: note({**info, "received_timestamp": info["source_timestamp"] + round(way * 1e9)})
    peer.speak(topics.JOY).publish(message_class(topics.JOY)())
    peer.until(box.newest)
    assert status.unheard() == told.format(who=peer.node.get_name())
    assert status.unheard() == ""  # nothing has come since


def test_one_message_in_time_shows_that_only_others_were_late(peer, clock):
    box = polled_subscription(peer.node, topics.JOY)
    status = InputStatus(peer.node, clock, box, "a joystick")
    for way in (2.0, 0.01, 3.0):
        box.note({"source_timestamp": 10**18, "received_timestamp": 10**18 + round(way * 1e9)})
    assert status.unheard() == ""


def test_in_lockstep_neither_clocks_nor_offers_are_told(peer, clock, make_node):
    clock.lockstep = True
    box = polled_subscription(peer.node, topics.VALVE_COMMANDS)
    status = InputStatus(peer.node, clock, box, "commands")
    box.note({"source_timestamp": 10**18, "received_timestamp": 13 * 10**17})
    make_node("pad").create_publisher(message_class(topics.VALVE_COMMANDS), "/valve_commands", LOSSY)
    peer.until(lambda: peer.node.count_publishers("/valve_commands"))
    assert status.unheard() == ""
