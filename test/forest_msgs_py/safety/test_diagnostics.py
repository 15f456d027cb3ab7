"""Claims about a node's health: a trouble is told at once and every second, and its changes are logged."""

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from forest_msgs_py.interfaces import topics
from forest_msgs_py.safety.clipping import Clipping
from forest_msgs_py.safety.diagnostics import Diagnostics

S = 1_000_000_000


@pytest.fixture
def health(peer, monkeypatch):
    node = Node("machine", context=peer.node.context, enable_rosout=False, start_parameter_services=False)
    made = Diagnostics(node, ("joystick", "pump"), "standing still")
    made.lines = []
    monkeypatch.setattr(node, "get_logger", lambda: Lines(made.lines))
    made.heard = peer.hear(topics.DIAGNOSTICS)
    peer.until(made._publisher.get_subscription_count)
    yield made
    node.destroy_node()


class Lines:
    def __init__(self, lines):
        self.warning = self.info = lines.append


class Input:
    """A source that a test lets miss somebody, or not hear somebody."""

    def __init__(self):
        self.who, self.whom, self.asked = "", "", 0

    def waiting(self):
        return self.who

    def unheard(self):
        return self.whom

    def values(self):
        self.asked += 1
        return {"/joy age [s]": 0.0123456, "alive": True, "speeds [m/s]": (1.0, 0.5), "messages": 3}


def told(message):
    return [(status.name, status.level, status.message) for status in message.status]


def test_a_lesser_trouble_names_its_own_consequence(peer, monkeypatch):
    lines, node = [], Node("driver", context=peer.node.context, enable_rosout=False)
    monkeypatch.setattr(node, "get_logger", lambda: Lines(lines))
    made = Diagnostics(node, ("commands", "pressures"), "valves centred", None, "pressures")
    made.note_all({"commands": "no command", "pressures": "one is nan; the nominal load is taken"})
    assert lines == ["valves centred: no command", "one is nan; the nominal load is taken"]
    node.destroy_node()


def test_a_trouble_is_told_at_once_and_again_every_second(peer, health):
    for step in range(600):  # three seconds of a loop of 200 Hz
        health.note("joystick", f"axes are {step}; allowed: -1..1" if 100 <= step < 400 else "")
        health.publish(step * S // 200)
    peer.until(lambda: len(health.heard) == 4)  # at 0, ill at 0.5 and 1.5, well at 2
    levels = [told(message)[0][1] for message in health.heard]
    assert levels == [DiagnosticStatus.OK, *[DiagnosticStatus.ERROR] * 2, DiagnosticStatus.OK]
    name, _, said = told(health.heard[1])[0]
    assert name == "machine: joystick"
    assert said == "axes are 100; allowed: -1..1"
    assert told(health.heard[1])[1] == ("machine: pump", DiagnosticStatus.OK, "well")
    assert health.heard[1].header.stamp.nanosec == S // 2


def test_a_trouble_that_stands_is_logged_once_and_one_that_comes_and_goes_now_and_then(health, monkeypatch):
    now = [1000.0]
    monkeypatch.setattr("forest_msgs_py.safety.diagnostics.time.monotonic", lambda: now[0])
    for step in range(200):
        now[0] += 0.1
        health.note("joystick", f"trouble {step}")
        health.note("pump", "no pressure")
    assert health.lines == ["standing still: trouble 0", "standing still: no pressure"]
    for _ in range(12):
        health.note("pump", "")
        now[0] += 1.0
        health.note("pump", "no pressure")
    assert health.lines[2:] == ["standing still: no pressure"] * 3  # at 1, 6 and 11 s


def test_what_is_told_of_a_message_without_end_has_one(peer, health):
    health.note("joystick", "axes are " + "0.0, " * 1_000_000)
    health.publish(S)
    assert len(health.lines[0]) < 500
    peer.until(lambda: health.heard)
    assert told(health.heard[0])[0][2].startswith("axes are 0.0, 0.0")
    assert len(told(health.heard[0])[0][2]) < 500


def test_a_new_sort_of_trouble_is_logged_at_once_and_no_more_than_a_few_in_a_second(health):
    health.note("pump", "no pressure")
    health.note("pump", "")
    for step in range(100):
        health.note("pump", f"it leaks {step} litres")
    assert health.lines == ["standing still: no pressure", "standing still: it leaks 0 litres"]
    for word in "abcdefghijklmnop":
        health.note("pump", word)
    assert len(health.lines) <= 10


def test_a_trouble_that_comes_and_goes_with_each_message_is_told_ten_times_a_second(health, monkeypatch):
    told = []
    monkeypatch.setattr(health, "_publisher", SimpleNamespace(publish=told.append))
    for step in range(401):
        health.note("pump", "it leaks" if step % 2 else "")
        health.publish(step * S // 200)
    assert len(told) == 21
    counts = {pair.key: pair.value for pair in told[-1].status[1].values}
    assert counts["troubles since start"] == "200"


def test_who_is_waited_for_is_a_warning_and_logged_once_when_the_graph_has_had_time_to_start(peer, health):
    joystick = Input()
    health.watch("joystick", joystick)
    joystick.who = "waiting for a joystick on /joy"
    for step in range(1200):
        health.publish(step * S // 200)
    assert health.lines == ["waiting for a joystick on /joy"]
    joystick.who = ""
    health.publish(6 * S)
    peer.until(lambda: len(health.heard) == 7)
    assert [told(message)[0][1:] for message in health.heard] == [
        *[(DiagnosticStatus.WARN, "waiting for a joystick on /joy")] * 6,
        (DiagnosticStatus.OK, "well"),
    ]
    joystick.who = "waiting for a joystick on /joy"
    for second in range(7, 12):
        health.publish(second * S)
    assert health.lines == ["waiting for a joystick on /joy"] * 2


def test_who_is_not_heard_is_a_warning_beside_what_else_a_person_should_know(peer, health):
    pump = Input()
    health.watch("pump", pump)
    pump.whom = "/joy of /pad is not heard"
    health.warn("pump", "it is clipped")
    health.publish(S)
    health.note("pump", "no pressure")
    health.publish(2 * S)
    peer.until(lambda: len(health.heard) == 2)
    assert told(health.heard[0])[1][1:] == (DiagnosticStatus.WARN, "it is clipped; /joy of /pad is not heard")
    assert told(health.heard[1])[1][1:] == (DiagnosticStatus.ERROR, "no pressure; /joy of /pad is not heard")
    assert told(health.heard[0])[0][2] == "well"


def test_what_a_person_should_know_is_told_at_once_and_logged_without_a_consequence(health, monkeypatch):
    monkeypatch.setattr(
        "forest_msgs_py.safety.diagnostics.time.monotonic", lambda: 1000.0
    )  # within the same second
    for step in range(200):
        health.warn("pump", f"clipped {step}")
    assert health.lines == ["clipped 0"]


def test_the_values_are_asked_for_only_when_they_are_told_and_carry_their_units(peer, health):
    joystick = Input()
    health.watch("joystick", joystick, values=lambda: {"joy_timeout [s]": 0.15})
    health.note("joystick", "gone")
    for step in range(200):
        health.publish(S + step * S // 200)
    assert joystick.asked == 1
    peer.until(lambda: health.heard)
    values = {pair.key: pair.value for pair in health.heard[0].status[0].values}
    assert values == {
        "/joy age [s]": "0.01235",
        "alive": "true",
        "speeds [m/s]": "1, 0.5",
        "messages": "3",
        "joy_timeout [s]": "0.15",
        "troubles since start": "1",
    }


def test_a_value_beyond_its_rating_is_named_with_both_and_counted():
    clipping = Clipping(topics.VALVE_COMMANDS, (10.0, 10.0, 8.0))
    assert clipping.caution((10.0, -10.0, 8.0)) == ""
    assert clipping.values()["clipped since start"] == 0
    said = "valve_commands: stick is -9 V, clipped to its rating of 8 V"
    assert clipping.caution((0.0, 0.0, -9.0)) == said
    told = {"swing rating [V]": 10.0, "boom rating [V]": 10.0, "stick rating [V]": 8.0}
    assert clipping.values() == told | {"clipped since start": 1}
