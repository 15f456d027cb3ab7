"""Runs in lockstep repeat to the last bit on a busy computer, and one that is stuck names who hangs."""

import os
import signal
import subprocess
import sys

import pytest
from graph_processes import kill, nodes_of

pytest.importorskip("rclpy")

from forest_msgs_py import topics
from forest_msgs_py.series import read_bag
from forest_study import graph, lockstep_run

STEPS = 200
STEP_NS = 5_000_000


def session(out, source):
    """Nodes of a whole graph, its bag in a directory."""
    faults = "" if source.is_dir() else "lost from 0.4 s until 0.43 s; frozen from 0.6 s until 0.7 s"
    return [
        graph.joystick(str(source), 0.0, 0, faults),
        *graph.control("c180", "jacobian_position", shadow=False, describe=False),
        graph.simulator("c180"),
        graph.recorder(out / "bag"),
    ]


@pytest.fixture(scope="module")
def levers(tmp_path_factory):
    path = tmp_path_factory.mktemp("levers") / "levers.csv"
    path.write_text("time_s,swing,boom,stick\n0,0,0,0\n0.1,0.6,0.4,-0.3\n0.5,0,0.2,0.5\n0.8,0,0,0\n")
    return path


@pytest.fixture
def own_domain(monkeypatch, session_domain_id):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(session_domain_id))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory, session_domain_id, levers):
    """A run on a computer that does nothing else."""
    out = tmp_path_factory.mktemp("run")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(session_domain_id))
        running = lockstep_run.run(session(out, levers), STEPS, out / "log")
    assert set(running.exit_codes.values()) == {0}
    return out / "bag"


def compare(a, b):
    return subprocess.run(
        [sys.executable, "-m", "forest_ident.bag_cli", "compare", str(a), str(b)],
        capture_output=True,
        text=True,
        check=False,
    )


def test_every_message_of_step_k_is_stamped_k_dt_and_logged_then(recorded):
    bag = read_bag(recorded)
    expected = [STEP_NS * step for step in range(1, STEPS + 1)]
    streams = [topic for topic in topics.TOPICS if topic.recorded and topic.rate_hz and bag.name(topic)]
    assert {topics.JOY, topics.JOINT_STATES, topics.VALVE_COMMANDS, topics.VALVE_VOLTAGES} <= set(streams)
    for topic in set(streams) - {topics.JOY, topics.DIAGNOSTICS}:
        series = bag.series(topic)
        assert series.time_ns.tolist() == expected, topic.name
        assert series.log_time_ns.tolist() == expected, topic.name
    assert max(abs(bag.series(topics.VALVE_VOLTAGES).values).max(axis=0)) > 1.0
    assert not bag.series(topics.AUXILIARY).column("missed_deadlines").any()


def test_a_run_repeats_to_the_last_bit_beside_programs_that_take_every_core(
    recorded, tmp_path, levers, own_domain, start_process
):
    busy = [start_process(["-c", "while True: pass"]) for _ in range(2 * (os.cpu_count() or 1))]
    lockstep_run.run(session(tmp_path, levers), STEPS, tmp_path / "log", guard=60.0)
    for process in busy:
        process.kill_group()
    done = compare(recorded, tmp_path / "bag")
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_joystick_alone_replayed_gives_every_topic_again(recorded, tmp_path, own_domain):
    lockstep_run.run(session(tmp_path, recorded), STEPS, tmp_path / "log")
    done = compare(recorded, tmp_path / "bag")
    assert done.returncode == 0, done.stdout + done.stderr


def test_faults_of_the_joystick_are_events_in_simulated_time(recorded):
    joy = read_bag(recorded).series(topics.JOY)
    steps = (joy.time_ns // STEP_NS - 1).tolist()  # since the first
    lost = sorted(set(range(STEPS)) - set(steps))
    assert lost == [80, 81, 82, 83, 84, 85]
    frozen = [steps.index(step) for step in range(120, 140)]
    assert (joy.values[frozen] == joy.values[steps.index(119)]).all()


@pytest.mark.parametrize(
    ("hanging", "awaited"),
    [
        ("joystick", "/joy of joystick"),
        ("simulator", "of simulator"),
    ],
)
def test_a_node_that_hangs_ends_the_run_and_is_named(
    hanging, awaited, tmp_path, domain_id, start_process, wait_until
):
    options = ("--lockstep", "--guard", "1", "--duration", "3600", "--out", str(tmp_path / "out"))
    demo = start_process(["-m", "forest_study.demo", *options])
    bag = tmp_path / "out" / "bag"
    wait_until(lambda: any(path.stat().st_size > 50_000 for path in bag.glob("*.mcap")), 30.0)
    kill(nodes_of(demo)[hanging], signal.SIGSTOP)
    assert demo.wait(40.0) == 1
    assert "step " in demo.text()
    assert awaited in demo.text()
