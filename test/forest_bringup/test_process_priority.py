"""Claims about precedence: live nodes take it where they may, and say nothing where not."""

import os
import subprocess
from pathlib import Path

import pytest

from forest_bringup import graph
from forest_bringup.lockstep_run import in_lockstep
from forest_bringup.process_priority import NICE, raise_priority


@pytest.fixture
def process():
    with subprocess.Popen(["cat"], stdin=subprocess.PIPE, start_new_session=True) as one:
        yield one.pid
        one.kill()


def test_a_process_takes_precedence_where_it_may(process):
    before = os.getpriority(os.PRIO_PROCESS, process)
    try:
        os.setpriority(os.PRIO_PROCESS, process, NICE)
    except OSError:
        allowed = before
    else:
        allowed = NICE
        os.setpriority(os.PRIO_PROCESS, process, before)
    raise_priority(process)
    assert os.getpriority(os.PRIO_PROCESS, process) == allowed


def test_where_it_may_not_nothing_happens(process, monkeypatch):
    def refused(*_args, **_more):
        raise PermissionError(1, "not permitted")

    before = os.getpriority(os.PRIO_PROCESS, process)
    monkeypatch.setattr(os, "setpriority", refused)
    monkeypatch.setattr(Path, "write_text", refused)
    raise_priority(process)
    assert os.getpriority(os.PRIO_PROCESS, process) == before


def test_what_must_be_in_time_is_urgent_live_and_nothing_in_lockstep(tmp_path):
    nodes = [
        graph.joystick("thesis", 1.0, 1),
        *graph.control("c180", "coordinated", shadow=False, describe=False),
        graph.simulator("c180"),
        graph.recorder(tmp_path),
    ]
    assert [node.name for node in nodes if not node.urgent] == ["recorder"]
    assert not any(node.urgent for node in in_lockstep(nodes, 10))
