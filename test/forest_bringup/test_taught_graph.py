"""Taught work beside the live graph: the program asks the node, which keeps what is taught."""

import math
import subprocess
import sys
from pathlib import Path

import pytest
from page_examples import examples

pytest.importorskip("rclpy")

from forest_control.cli.main import main
from forest_control.taught.cycle_file import load_cycle
from forest_description.derived.limits import start_tip
from forest_description.machine import load_machine

PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "teach-a-cycle.md"
STARTED_S = 90.0  # at which the test fails rather than hangs; on a busy machine a graph starts slowly


def test_where_the_tip_is_is_taught_from_the_command_line(start_graph, wait_until, tmp_path, capsys):
    graph = start_graph("--cycles", str(tmp_path))
    teach = ["cycle", "record", "home", "--what", "pose", "--label", "here"]
    wait_until(lambda: main(teach) == 0, STARTED_S)
    (pose,) = load_cycle("home", tmp_path).segments
    assert pose.name == "here"
    assert math.dist(pose.tip, start_tip(load_machine("c180"))) < 0.05
    assert "home: here is taught" in capsys.readouterr().out
    (program,) = (one.text for one in examples(PAGE) if one.kind == "python")
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "homing: drop is taught" in told.stdout
    assert [one.name for one in load_cycle("homing", tmp_path).segments] == ["home", "drop"]
    assert main(["cycle", "resume"]) == 1
    assert "nothing waits for a person" in capsys.readouterr().err
    assert graph.poll() is None, graph.text()
