"""What is in a bag is told to people and to programs."""

import json

import pytest

pytest.importorskip("rclpy")

from std_msgs.msg import String

from forest_bag.cli.main import main
from forest_msgs_py.interfaces import messages, topics

PERIOD = 5_000_000
N = 100
GAP = 40 * PERIOD  # behind message 59


def stamp(step):
    return PERIOD * step + (GAP if step >= 60 else 0)


@pytest.fixture
def content():
    return {
        topics.FLOWS: [
            (stamp(step), messages.float_array(topics.FLOWS, stamp(step), (1.0, 2.0))) for step in range(N)
        ],
        topics.EVENTS: [(7 * PERIOD, String(data="the hose burst"))],
        topics.ROBOT_DESCRIPTION: [(0, String(data="<robot/>"))],
    }


def test_counts_gaps_qos_and_events_are_told_as_json(make_bag, content, capsys):
    assert main(["info", "--json", str(make_bag(content, "bag"))]) == 0
    told = json.loads(capsys.readouterr().out)
    flows = told["topics"]["/hydraulics/flows"]
    assert (flows["messages"], flows["type"], flows["gaps"]) == (N, topics.FLOWS.type, 1)
    assert flows["longest_gap_s"] == pytest.approx((GAP + PERIOD) / 1e9)
    assert flows["longest_gap_at_ns"] == stamp(59)
    assert flows["qos"] == ["reliable, volatile, depth 200"]
    assert told["topics"]["/robot_description"]["qos"] == ["reliable, latched, depth 1"]
    assert told["events"] == [{"time_ns": 7 * PERIOD, "text": "the hose burst"}]
    assert told["duration_s"] == pytest.approx(stamp(N - 1) / 1e9)
    assert [file["name"] for file in told["files"]] == ["bag_0.mcap"]
    assert told["complete"]


def test_people_read_the_same(make_bag, content, capsys):
    assert main(["info", str(make_bag(content, "bag"))]) == 0
    text = capsys.readouterr().out
    assert "simulated time" in text
    assert "1 gap, longest 0.205 s at 0.295 s" in text
    assert "event      0.035 s  the hose burst" in text


def test_a_damaged_bag_is_told_as_far_as_it_is_whole(make_bag, content, capsys):
    assert main(["info", str(make_bag(content, "bag", closed=False))]) == 1
    text = capsys.readouterr().out
    assert "(damaged)" in text
    assert "problem" in text
    assert f"messages   {N + 2}" in text
