"""Claims about a node's health: a trouble is told at once and every second, and logged as often."""

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from forest_msgs_py import topics
from forest_msgs_py.health import Health

S = 1_000_000_000


@pytest.fixture
def health(peer, monkeypatch):
    node = Node("machine", context=peer.node.context, enable_rosout=False, start_parameter_services=False)
    made = Health(node, ("joystick", "pump"), "standing still")
    made.lines = []
    monkeypatch.setattr(node, "get_logger", lambda: Lines(made.lines))
    made.heard = peer.hear(topics.DIAGNOSTICS)
    peer.until(made._publisher.get_subscription_count)
    yield made
    node.destroy_node()


class Lines:
    def __init__(self, lines):
        self.warning = lines.append


def told(message):
    return [(status.name, status.level, status.message) for status in message.status]


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


def test_a_trouble_is_logged_once_however_often_it_is_noted(health, monkeypatch):
    monkeypatch.setattr("forest_msgs_py.health.time.monotonic", lambda: 1000.0)  # within the same second
    for step in range(200):
        health.note("joystick", f"trouble {step}")
    health.note("pump", "no pressure")
    assert health.lines == ["standing still: trouble 0", "standing still: no pressure"]


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
