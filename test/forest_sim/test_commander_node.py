"""The commander says zero, what its file says, and ends with it at zero."""

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import read_float_array

ROWS = "time,swing,boom,stick\n0,1.5,0,0\n0.3,0,-2,0\n0.6,0,0,0\n"
COMMANDER = "forest_sim.commander_node"


def start(start_process, path):
    return start_process(["-m", COMMANDER, *(["--ros-args", "-p", f"input:={path}"] if path else [])])


def test_once_heard_it_says_zero_and_its_file_row_by_row_and_ends_at_zero(peer, start_process, tmp_path):
    (tmp_path / "volts.csv").write_text(ROWS)
    process = start(start_process, tmp_path / "volts.csv")
    peer.until(lambda: "commander" in peer.node.get_node_names())
    heard = peer.hear(topics.VALVE_COMMANDS)
    peer.until(lambda: process.poll() is not None)
    assert process.returncode == 0, process.text()
    peer.until(lambda: values(heard[-1]) == (0.0, 0.0, 0.0))
    said = [values(message) for message in heard]
    assert list(dict.fromkeys(said)) == [(0.0, 0.0, 0.0), (1.5, 0.0, 0.0), (0.0, -2.0, 0.0)]


def values(message):
    return read_float_array(topics.VALVE_COMMANDS, message, 0).values


@pytest.mark.parametrize(
    ("file", "why"), [("absent.csv", "cannot be read as CSV"), ("", "is ''; allowed: a CSV file of voltages")]
)
def test_a_file_that_is_none_ends_it_with_one_line(domain_id, start_process, tmp_path, file, why):
    process = start(start_process, file and tmp_path / file)
    assert process.ended() == 2
    assert process.text().count("\n") == 1
    assert "parameter 'input'" in process.text()
    assert why in process.text()
