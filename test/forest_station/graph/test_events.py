"""An event counts as said once it has arrived: a bag that ends a moment later holds it."""

import asyncio
import os
import signal

import pytest

pytest.importorskip("rclpy")

from forest_bag.read.bag_reader import BagReader
from forest_bag.read.survey import survey
from forest_station.graph import events


def test_an_event_is_said_once_all_who_hear_it_have_it(
    make_node, start_process, wait_until, tmp_path, monkeypatch
):
    spoken = events.Events(make_node("station"))

    def say(text):
        return asyncio.run(spoken.say(text))

    assert not spoken.heard()
    assert not say("nobody is there")
    bag = tmp_path / "bag"
    recorder = start_process(["-m", "forest_bag.recorder_node", "--ros-args", "-p", f"output:={bag}"])
    wait_until(spoken.heard)
    assert say("heard")
    os.kill(recorder.pid, signal.SIGSTOP)
    with monkeypatch.context() as patch:
        patch.setattr(events, "ARRIVED_S", 0.2)
        assert not say("frozen")
    os.kill(recorder.pid, signal.SIGCONT)
    assert say("thawed")
    assert recorder.stop() == 0
    with BagReader(bag) as reader:
        assert [text for _time, text in survey(reader).events] == ["heard", "frozen", "thawed"]
