"""What a node's emergency stop decides, message by message: time by hand, no waiting for messages."""

import pytest

pytest.importorskip("rclpy")

from std_srvs.srv import Trigger

from forest_msgs_py.interfaces.topics import EMERGENCY_STOP, message_class
from forest_msgs_py.safety.emergency_stop import EmergencyStop

EPOCH = 1_800_000_000_000_000_000  # [ns] by the senders' clock, when the monotonic one says 1000 s
COMMAND = message_class(EMERGENCY_STOP)


class Waiting:
    """What waits in a subscription's queue, by hand."""

    def __init__(self, *messages):
        self.handle, self.messages, self.held = self, [*messages], False

    def __enter__(self):
        self.held = True

    def __exit__(self, *_):
        self.held = False

    def take_message(self, kind, raw):
        assert self.held
        assert (kind, raw) == (COMMAND, False)
        return self.messages.pop(0) if self.messages else None


class Stop:
    """An emergency stop whose messages come from a test, in time by hand."""

    def __init__(self, make_node, monkeypatch):
        self.now, self.objection, self.asked, self.acted = 0.0, "", 0, []
        monkeypatch.setattr("time.monotonic", lambda: 1000.0 + self.now)
        monkeypatch.setattr("time.time_ns", lambda: EPOCH + round(self.now * 1e9))
        self.stop = EmergencyStop(make_node("node"), "~/", self._object, self._act)

    def _object(self):
        self.asked += 1
        return self.objection

    def _act(self):
        self.acted.append(self.stop.pressed)

    @property
    def pressed(self):
        return self.stop.pressed

    def at(self, now):
        self.now = now
        return self

    def info(self, sent):
        stamp = EPOCH + round((self.now if sent is None else sent) * 1e9)
        return {"source_timestamp": stamp, "publication_sequence_number": 2}

    def command(self, data, sent=None):
        self.stop._on_command(COMMAND(data=data), self.info(sent))
        return self.pressed

    def state(self, *words):
        """Words of /emergency_stopped that came at once: (data, sent[, number])."""
        said = []
        for data, sent, *number in words:
            told = self.info(sent) | {"publication_sequence_number": number[0] if number else 2}
            said.append((COMMAND(data=data), told))
        self.stop._states = Waiting(*said[1:])
        self.stop._on_state(*said[0])
        assert not self.stop._states.messages
        return self.pressed

    def latched(self, data, sent=None):
        self.stop._on_latched(COMMAND(data=data), self.info(sent))
        return self.pressed


@pytest.fixture
def stop(make_node, monkeypatch):
    return Stop(make_node, monkeypatch)


def test_a_node_starts_unstopped_and_acts_at_once_when_it_is_stopped_and_once(stop):
    assert not stop.pressed
    assert stop.at(1.0).command(True)
    assert stop.at(2.0).command(True)
    assert stop.acted == [True]


def test_a_false_said_after_the_stop_resets_it_and_a_stop_after_that_acts_again(stop):
    stop.at(1.0).command(True)
    assert not stop.at(1.5).command(False)
    assert stop.at(2.0).command(True)
    assert len(stop.acted) == 2


@pytest.mark.parametrize(("sent", "stopped"), [(0.9, True), (1.0, True), (1.000_001, False)])
def test_a_false_said_before_the_last_stop_resets_nothing_however_late_it_comes(stop, sent, stopped):
    stop.at(1.0).stop.press()
    assert stop.at(3.0).command(False, sent) == stopped


def test_the_last_press_counts_not_the_first(stop):
    stop.at(1.0).stop.press()
    stop.at(2.0).stop.press()
    assert stop.at(3.0).command(False, 1.5)
    assert not stop.at(4.5).command(False, 2.5)


def test_of_falses_within_a_second_of_each_other_none_resets_not_even_the_third(stop):
    stop.at(1.0).command(False)
    stop.at(1.5).stop.press()
    assert [stop.at(now).command(False) for now in (1.9, 2.8, 3.7)] == [True] * 3
    assert not stop.at(4.7).command(False)


def test_a_false_a_second_after_another_resets(stop):
    stop.at(1.0).command(False)
    stop.at(1.5).stop.press()
    assert stop.at(1.75).command(False)
    assert stop.at(2.625).command(False)
    assert not stop.at(3.625).command(False)


def test_a_true_between_makes_the_next_false_one_on_purpose(stop):
    stop.at(1.0).command(False)
    stop.at(1.1).command(True)
    assert not stop.at(1.2).command(False)


def test_the_first_false_of_all_resets_even_right_after_the_machine_was_started(stop):
    stop.at(-1000.0).stop.press()  # the monotonic clock says 0
    assert not stop.at(-999.9).command(False)
    assert stop.at(-999.8).command(True)
    assert not stop.at(-999.7).command(False)


def test_of_the_past_only_a_stop_counts_and_only_if_it_was_not_heard_live(stop):
    assert stop.at(1.0).command(True)
    assert not stop.at(2.0).command(False)
    assert not stop.at(2.1).latched(True, 1.0)
    assert not stop.latched(False, 0.5)
    assert stop.latched(True, 0.5)
    assert stop.at(9.0).latched(False)


def test_what_was_heard_live_is_remembered_for_thirty_two_commands(stop):
    stop.at(1.0).command(True)
    for number in range(31):
        stop.at(2.0 + number).command(False)
    assert not stop.pressed
    assert not stop.latched(True, 1.0)


def test_a_reset_asks_what_stands_against_it_and_only_of_a_stopped_node(stop):
    assert stop.stop.reset() == ""
    assert stop.asked == 0
    stop.objection = "the deadman is held"
    stop.at(1.0).command(True)
    assert stop.stop.reset() == "the deadman is held"
    assert stop.pressed
    stop.objection = ""
    assert stop.stop.reset() == ""
    assert not stop.pressed
    assert stop.asked == 2


def test_who_objects_later_is_asked_first(stop):
    stop.objection, objections = "the deadman is held", ["two talk", ""]
    stop.stop.refuse_while(lambda: objections.pop(0))
    stop.command(True)
    assert stop.stop.reset() == "two talk"
    assert stop.asked == 0
    assert stop.stop.reset() == "the deadman is held"


def test_the_services_answer_with_what_they_did(stop):
    def ask(what):
        answer = what(Trigger.Request(), Trigger.Response())
        return answer.success, answer.message

    assert ask(stop.at(1.0).stop._on_press) == (True, "stopped")
    assert stop.pressed
    stop.objection = "the deadman is held"
    assert ask(stop.at(2.0).stop._on_reset) == (False, "refused: the deadman is held")
    assert stop.pressed
    stop.objection = ""
    assert ask(stop.stop._on_reset) == (True, "reset")
    assert not stop.pressed


def test_a_stop_by_service_is_as_new_as_one_by_topic(stop):
    stop.at(5.0).stop._on_press(Trigger.Request(), Trigger.Response())
    assert stop.at(6.0).command(False, 4.9)
    assert not stop.at(7.5).command(False)


def test_a_state_said_at_the_very_time_of_the_stop_resets_nothing(stop):
    stop.at(1.0).stop.press()
    stop.stop._on_state(COMMAND(data=False), stop.info(1.0))
    assert stop.pressed


def test_the_log_tells_of_the_stop_of_what_stands_against_a_reset_and_of_the_reset(stop, capfd):
    stop.objection = "the deadman is held"
    stop.at(1.0).stop.press()
    stop.stop.reset()
    stop.objection = ""
    stop.stop.reset()
    told = [line.rpartition("]: ")[2] for line in "".join(capfd.readouterr()).splitlines()]
    assert told == ["emergency stop", "emergency stop stays: the deadman is held", "emergency stop reset"]


def test_of_the_states_that_wait_the_newest_decides(stop):
    stop.at(1.0).stop.press()
    assert not stop.at(3.0).state((True, 1.5), (True, 1.8), (False, 2.0))
    assert stop.at(4.0).state((False, 3.5), (True, 3.8))
    assert len(stop.acted) == 2


@pytest.mark.parametrize("number", [1, 0, None])
def test_the_first_false_of_a_node_says_nothing_and_what_was_said_before_it_counts(stop, number):
    stop.at(1.0).stop.press()
    assert stop.at(3.0).state((False, 2.0, number))
    assert not stop.at(4.0).state((False, 3.5, 2), (False, 3.6, number))
    assert stop.at(5.0).state((True, 4.0, 1), (False, 4.5, number))


def test_a_false_state_from_before_the_stop_resets_nothing(stop):
    stop.at(2.0).stop.press()
    assert stop.at(3.0).state((False, 1.999))
    assert stop.at(3.0).state((False, 2.0))
    assert not stop.at(3.0).state((False, 2.001))


@pytest.mark.parametrize(("said", "since"), [(2.0, 2.0), (0.5, 1.0), (9.0, 3.0)])
def test_a_stopped_node_that_hears_of_a_stop_is_stopped_since_that_was_said(stop, said, since):
    """Not since before its own stop, and not since a time that has not come."""
    stop.at(1.0).stop.press()
    assert stop.at(3.0).state((True, said))
    assert stop.at(5.0).command(False, since)
    assert not stop.at(6.5).command(False, since + 0.001)


def test_a_node_that_hears_of_an_older_stop_is_stopped_since_it_heard(stop):
    assert stop.at(3.0).state((True, 1.0))
    assert stop.at(5.0).command(False, 2.9)
    assert not stop.at(6.5).command(False, 3.001)


def test_diagnostics_tell_whether_it_is_pressed_and_how_often_it_was(stop):
    def told(*expected):
        return stop.stop.values() == dict(zip(("pressed", "presses since start"), expected, strict=True))

    assert told(False, 0)
    stop.at(1.0).stop.press()
    stop.at(2.0).stop.press()
    assert told(True, 1)
    stop.stop.reset()
    assert told(False, 1)
    stop.at(3.0).stop.press()
    assert told(True, 2)
    assert stop.stop.waiting() == ""


def test_every_change_and_every_refusal_is_said_on_the_nodes_own_publisher(make_node):
    said, objection = [], [""]

    class Publisher:
        def publish(self, message):
            said.append(message.data)

    stop = EmergencyStop(make_node("node"), "", lambda: objection[0], lambda: None, Publisher())
    assert said == [False]
    stop.press()
    stop.press()
    assert said == [False, True]
    objection[0] = "the deadman is held"
    stop.reset()
    assert said == [False, True, True]
    objection[0] = ""
    stop.reset()
    stop.reset()
    assert said == [False, True, True, False]


def test_a_node_listens_for_reliable_latched_and_best_effort_words_and_keeps_ten_of_each(make_node):
    node = make_node("node")
    EmergencyStop(node, "", str, lambda: None)
    heard = [s for s in node.subscriptions if s.topic_name == "/emergency_stop"]
    profiles = [s.qos_profile for s in heard]
    assert sorted((p.reliability.name, p.durability.name, p.depth) for p in profiles) == [
        ("BEST_EFFORT", "VOLATILE", 10),
        ("RELIABLE", "TRANSIENT_LOCAL", 10),
        ("RELIABLE", "VOLATILE", 10),
    ]
