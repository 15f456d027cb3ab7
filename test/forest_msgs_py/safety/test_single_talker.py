"""Two who talk on a topic stop who hears them, by name, until a reset: time and messages by hand."""

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import VALVE_COMMANDS, message_class
from forest_msgs_py.runtime.publishers import UNKNOWN
from forest_msgs_py.safety import single_talker
from forest_msgs_py.safety.emergency_stop import EmergencyStop
from forest_msgs_py.safety.single_talker import SingleTalker

SAID = f"more than one node publishes {VALVE_COMMANDS.name}: "
PRESSED = "emergency stop pressed"


class Listener:
    """A node whose messages come from a test, by a clock that begins with it."""

    heard = None  # set by the rule, as it does with what counts a subscription's messages

    def __init__(self, make_node, monkeypatch):
        self.now, self._make = 0.0, make_node
        monkeypatch.setattr("time.monotonic", lambda: self.now)
        node = make_node("listener")
        self.stop = EmergencyStop(node, "~/", lambda: "", lambda: None)
        self.rule = SingleTalker(node, VALVE_COMMANDS, self, self.stop)

    def join(self, *names):
        """Nodes that publish; they are there at once, since they are of one process."""
        for name in names:
            self._make(name).create_publisher(
                message_class(VALVE_COMMANDS), VALVE_COMMANDS.name, qos(VALVE_COMMANDS)
            )
        return self

    def after(self, seconds):
        self.now += seconds
        return self

    def hear(self, *numbers):
        for number in numbers:
            self.now += 0.005
            self.heard({"publication_sequence_number": number})
        return self


@pytest.fixture
def listener(make_node, monkeypatch):
    return Listener(make_node, monkeypatch)


def test_one_who_talks_alone_stops_nobody_nor_does_a_middleware_that_does_not_count(listener):
    listener.hear(7, 8, 9).heard({})
    assert not listener.stop.pressed
    assert listener.rule.trouble() == ""


def test_a_stop_for_another_reason_names_nobody(listener):
    listener.join("one").hear(7, 8).stop.press()
    assert listener.rule.trouble() == PRESSED


def test_two_stop_who_hears_them_and_are_named_until_the_reset_which_is_refused_while_they_talk(listener):
    listener.join("two", "one").hear(7, 1)
    assert not listener.stop.pressed
    listener.hear(8)
    assert listener.stop.pressed
    assert listener.rule.trouble() == f"{PRESSED}; {SAID}one, two"
    assert listener.after(0.4).stop.reset() == f"{SAID}one, two"
    assert listener.after(0.2).rule.trouble() == f"{PRESSED}; {SAID}one, two"
    assert listener.stop.reset() == ""
    assert not listener.stop.pressed
    assert listener.rule.trouble() == ""


def test_a_reset_alone_finds_the_names_too(listener):
    assert listener.join("one", "two").hear(7, 1, 8).stop.reset() == f"{SAID}one, two"


def test_names_are_asked_for_five_times_a_second_and_kept_until_the_reset(listener, monkeypatch):
    there = ["one", UNKNOWN]
    monkeypatch.setattr(single_talker, "publishers_of", lambda node, topic: there)
    listener.hear(7, 1, 8)
    found = f"{PRESSED}; {SAID}one, a node that was just found"
    assert listener.rule.trouble() == found
    there[:] = ["three", "two"]
    assert listener.after(0.19).rule.trouble() == found
    assert listener.after(0.02).rule.trouble() == f"{PRESSED}; {SAID}one, three, two"
    listener.after(1.0).stop.reset()
    assert listener.rule.trouble() == ""
    listener.hear(7, 1, 8)
    assert listener.rule.trouble() == f"{PRESSED}; {SAID}three, two"
