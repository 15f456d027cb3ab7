"""What the pages are told of a node's parts while a graph starts."""

import pytest

pytest.importorskip("rclpy")

from forest_control.safety.motion_guard import LOST_STATE, PRESSED
from forest_station.graph.notices import PartStatus, at_start

AWAITED = "waiting for the machine's state on /joint_states"


@pytest.mark.parametrize("text", [LOST_STATE, AWAITED, "waiting for commands on /valve_commands"])
def test_what_is_missing_is_the_start_of_the_graph_for_ten_seconds_and_then_a_trouble(text):
    part = PartStatus("controller: machine", "error", text, {})
    assert at_start(part, 0.0) == at_start(part, 9.9)
    assert at_start(part, 9.9)[1:3] == ("warning", f"the graph starts: {text}")
    assert at_start(part, 10.0) is part


@pytest.mark.parametrize("text", [PRESSED, "waiting for a joystick on /joy", "swing is frozen", "well"])
def test_what_a_person_can_mend_is_told_at_once(text):
    part = PartStatus("controller: machine", "error", text, {})
    assert at_start(part, 0.0) is part
