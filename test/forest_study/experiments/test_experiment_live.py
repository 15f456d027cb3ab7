"""Experiments on a graph that runs in real time: what they change is put back, whatever happens."""

import os
import signal
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("rclpy")

from graph_processes import kill, nodes_of

from forest_ident.measurements import session_bag
from forest_ident.measurements.session import SessionError
from forest_msgs_py.interfaces import topics
from forest_msgs_py.introspection import live_graph
from forest_msgs_py.introspection.live_graph import LiveGraph
from forest_msgs_py.runtime.node import publisher
from forest_study.experiments import experiment_live
from forest_study.experiments.forest_ident_main import main

OPERATOR = "experiment_operator"


def experiment(out, *options):
    """Move the boom on the graph that is running, patient with a busy computer; return the exit code."""
    asked = ("experiment", "damping_boom", "--live", "--yes", "--timeout", "1", "--out", str(out))
    return main([*asked, *options])


def switches():
    graph = LiveGraph("/")
    try:
        return graph.get("valve_driver", ["compensate"]) | graph.get("controller", ["hands_off"])
    finally:
        graph.close()


def kill_the_operator_in_motion(out, found, over):
    """Kill it once it drives, unless it is over before; keep what was switched then, and when it died."""
    log = out / "log" / "damping_boom" / f"{OPERATOR}.log"
    while not (log.exists() and "operator at " in log.read_text()):
        if over.wait(0.01):
            return
    try:
        found.append(switches())
    finally:
        found.append(time.monotonic())
        kill(nodes_of(SimpleNamespace(pid=os.getpid()))[OPERATOR], signal.SIGKILL)


@pytest.fixture
def graph(start_graph, valves, wait_until):
    started = start_graph()
    wait_until(lambda: valves.count > 10, executor=valves.executor)
    return started


def test_what_it_switches_is_put_back_at_its_end_and_after_its_death_and_an_emergency_stop_refuses_it(
    graph, valves, wait_until, tmp_path, capsys
):
    assert experiment(tmp_path / "whole", "--trial", "2.5") == 0
    assert switches() == {"compensate": True, "hands_off": False}
    session = session_bag.read(tmp_path / "whole" / "damping_boom")
    assert session.name == "damping_boom"
    assert set(np.abs(session.voltages[:, 1])) == {0.0, 2.5}  # as commanded: a quarter of the rated voltage
    assert not session.voltages[:, (0, 2)].any()
    assert not session.voltages[-1].any()

    found, over = [], threading.Event()
    killer = threading.Thread(target=kill_the_operator_in_motion, args=(tmp_path / "killed", found, over))
    killer.start()
    code = experiment(tmp_path / "killed", "--trial", "20")
    over.set()
    killer.join()
    said = capsys.readouterr().err
    assert code == 1, said
    assert f"{OPERATOR} was killed by SIGKILL" in said
    assert found[0] == {"compensate": False, "hands_off": True}
    wait_until(lambda: valves.shut > found[1], executor=valves.executor)
    assert valves.opened < valves.shut
    assert switches() == {"compensate": True, "hands_off": False}, said

    said = publisher(valves.node, topics.EMERGENCY_STOP)
    wait_until(lambda: said.get_subscription_count() >= 2, executor=valves.executor)
    said.publish(topics.message_class(topics.EMERGENCY_STOP)(data=True))
    assert experiment(tmp_path / "refused") == 1
    assert "the emergency stop is pressed" in capsys.readouterr().err
    assert not (tmp_path / "refused").exists()


def test_where_no_graph_runs_it_says_so_in_one_sentence(domain_id, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(live_graph, "LOOK", 0.2)
    assert main(["experiment", "validation", "--live", "--yes", "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert f"no graph is running in ROS domain {domain_id}, namespace /" in said
    assert len(said.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_what_needs_several_set_ups_is_not_run_unasked(tmp_path, capsys):
    assert main(["experiment", "all", "--live", "--yes", "--out", str(tmp_path / "out")]) == 1
    assert "each experiment wants another set-up" in capsys.readouterr().err


def test_nobody_who_could_confirm_is_a_no():
    assert not sys.stdin.isatty()
    with pytest.raises(SessionError, match="nobody can answer here; allowed: --yes"):
        experiment_live._ask_whether_prepared(False)
