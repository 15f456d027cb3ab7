"""Claims about the joystick without hands as a process: it plays what it is given, lets go, and ends."""

import signal

import numpy as np
import pytest
from stall import Stall

pytest.importorskip("rclpy")

from forest_control.operator.joystick_sources import LEAD_IN, thesis_tip_velocity
from forest_control.operator.levers import LEFT_SHOULDER, REST, Levers, levers_from_axes
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import read_joy, stamp_to_ns

ROWS = "time_s,swing,boom,stick\n0.0,0.25,0,0\n0.1,0,-0.5,0\n0.2,0,0,1\n0.3,0,0,0\n"


def levers(message):
    reading = read_joy(message, 4, LEFT_SHOULDER + 1)
    assert reading.problem == ""
    return levers_from_axes(reading.values.axes)


def held(message):
    return message.buttons[LEFT_SHOULDER] == 1


@pytest.fixture
def levers_file(tmp_path):
    path = tmp_path / "levers.csv"
    path.write_text(ROWS)
    return path


def test_it_plays_a_file_row_by_row_lets_the_deadman_go_and_ends_by_itself(peer, start_node, levers_file):
    heard = peer.hear(topics.JOY)
    process = start_node("joystick_node", "-p", f"source:={levers_file}", "-p", "interpolate:=false")
    stall = Stall(process.pid)
    peer.until(lambda: stall.look() and process.poll() is not None)
    assert process.returncode == 0
    peer.until(lambda: not held(heard[-1]))
    played = [levers(message) for message in heard]
    changes = [new for old, new in zip([None, *played], played, strict=False) if new != old]
    rows = [REST, Levers(0.25, 0, 0), Levers(0, -0.5, 0), Levers(0, 0, 1), REST]
    steps = np.diff([stamp_to_ns(message.header.stamp) for message in heard]) * 1e-9
    if max(steps) < 0.1:  # else this machine stood still for as long as a row lasts
        assert changes == rows
    following = iter(rows)
    assert all(row in following for row in changes)
    assert changes[-1] == REST
    assert all(held(message) for message, lever in zip(heard, played, strict=True) if lever != REST)
    assert held(heard[0])
    assert min(steps) > 0.0
    lost = stall.seconds() / len(steps)
    assert np.median(steps) == pytest.approx(1.0 / topics.JOY.rate_hz, rel=0.2, abs=lost)
    assert "Traceback" not in process.text()


def test_the_thesis_input_begins_when_somebody_listens_and_lets_go_when_stopped(peer, start_node):
    process = start_node("joystick_node", "-p", "tip_speed:=0.5")
    peer.until(lambda: "joystick" in peer.node.get_node_names())
    heard = peer.hear(topics.JOY)
    peer.until(lambda: heard and levers(heard[-1]) != REST)
    assert levers(heard[0]) == REST
    peer.until(lambda: levers(heard[-1]).swing > 0.5)
    stamps = [stamp_to_ns(message.header.stamp) * 1e-9 for message in heard]
    played = [levers(message).swing for message in heard]
    assert any(follows_the_thesis(stamps, played, stamps[0] - before) for before in np.arange(0, 0.2, 0.002))
    process.send_signal(signal.SIGINT)
    peer.until(lambda: process.poll() is not None)
    assert process.returncode == 0
    peer.until(lambda: not held(heard[-1]))
    assert levers(heard[-1]) == REST


def follows_the_thesis(stamps, played, begun):
    """Whether each lever is that of a moment after the message before and until its own stamp."""
    for before, stamp, lever in zip(stamps, stamps[1:], played[1:], strict=False):
        times = np.linspace(before, stamp, 11) - begun - LEAD_IN
        wished = [thesis_tip_velocity(time)[1] / 0.5 if time >= 0.0 else 0.0 for time in times]
        if not min(wished) - 0.01 <= lever <= max(wished) + 0.01:
            return False
    return True


def test_duration_and_deadman_button_are_as_set(peer, start_node):
    heard = peer.hear(topics.JOY)
    process = start_node("joystick_node", "-p", "duration:=0.1", "-p", "deadman_button:=3")
    stall = Stall(process.pid)
    peer.until(lambda: stall.look() and process.poll() is not None)
    assert process.returncode == 0

    def span():
        return (stamp_to_ns(heard[-1].header.stamp) - stamp_to_ns(heard[0].header.stamp)) * 1e-9

    peer.until(lambda: heard[-1].buttons[3] == 0 and span() > 0.8)  # what was said last may still wait
    assert span() < 1.3 + stall.seconds()  # 0.5 s at rest, 0.1 s playing, 0.3 s released
    assert any(message.buttons[3] == 1 for message in heard)
    assert not any(map(held, heard))


def test_a_bad_file_or_parameter_ends_the_node_with_one_line(domain_id, start_node, levers_file):
    levers_file.write_text(ROWS + "0.4,2,0,0\n")
    refused = {
        f"source:={levers_file}": "levers.csv:6: swing is '2'; allowed: -1 .. 1",
        "duration:=-1.0": "parameter 'duration' is -1.0; allowed: 0 .. 86400 s",
    }
    processes = {said: start_node("joystick_node", "-p", given) for given, said in refused.items()}
    for said, process in processes.items():
        assert process.ended() == 2
        assert process.text().count("\n") == 1
        assert said in process.text()
