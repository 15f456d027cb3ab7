"""A whole graph in lockstep, run by a process that is forked, as its nodes are: a start costs little."""

import json
import os
import sys
from pathlib import Path

from processes import ForkedNode

from forest_bringup import graph, lockstep_run
from forest_bringup.supervisor import NodeSpec

LOCKSTEP_STEPS = 200
LEVERS = "time_s,swing,boom,stick\n0,0,0,0\n0.1,0.6,0.4,-0.3\n0.5,0,0.2,0.5\n0.8,0,0,0\n"
GUARD = 60.0  # [s] for a busy computer


def lockstep_session(out, source):
    """Return the nodes of a whole graph, its bag in a directory; levers from a file are not faultless."""
    faults = "" if source.is_dir() else "lost from 0.4 s until 0.43 s; frozen from 0.6 s until 0.7 s"
    return [
        graph.joystick(str(source), 0.0, 0, faults),
        *graph.control("c180", "jacobian_position", shadow=False, describe=False),
        graph.simulator("c180", "400 kg from 0.3 s; 0 kg from 0.7 s"),
        graph.recorder(out / "bag"),
    ]


def run_in_lockstep(nodes, steps, out, domain):
    """Run nodes for a number of steps in a ROS domain; their logs go into a directory."""
    (out / "nodes.json").write_text(json.dumps([node._asdict() for node in nodes]))
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    session = ForkedNode(__name__, [str(out), str(steps)], out / "session.log", environment)
    assert session.ended() == 0, session.text()


def main():
    """Run what `run_in_lockstep` was given."""
    out, steps = Path(sys.argv[1]), int(sys.argv[2])
    nodes = [NodeSpec(**node) for node in json.loads((out / "nodes.json").read_text())]
    running = lockstep_run.run(nodes, steps, out / "log", GUARD)
    assert set(running.exit_codes.values()) == {0}, running.exit_codes
