"""Runs in lockstep repeat to the last bit on a busy computer, and one that is stuck names who hangs."""

import os
import re
import signal

import numpy as np
import pytest
from graph_processes import kill, nodes_of
from lockstep_sessions import LEVERS, LOCKSTEP_STEPS, lockstep_session, run_in_lockstep
from mcap.reader import make_reader

pytest.importorskip("rclpy")

from forest_bag.cli.main import main as forest_bag
from forest_bag.read.timeseries import read_bag
from forest_control.operator.joystick_sources import LEAD_IN, read_levers
from forest_control.operator.levers import REST, levers_from_axes
from forest_msgs_py.interfaces import topics

STEP_NS = 5_000_000


def test_every_message_of_step_k_is_stamped_k_dt_and_logged_then(lockstep_bag):
    bag = read_bag(lockstep_bag)
    expected = [STEP_NS * step for step in range(1, LOCKSTEP_STEPS + 1)]
    streams = [
        topic for topic in topics.TOPICS if topic.recorded and topic.rate_hz >= 100.0 and bag.name(topic)
    ]
    assert {topics.JOY, topics.JOINT_STATES, topics.VALVE_COMMANDS, topics.VALVE_VOLTAGES} <= set(streams)
    for topic in set(streams) - {topics.JOY}:
        series = bag.series(topic)
        assert series.time_ns.tolist() == expected, topic.name
        assert series.log_time_ns.tolist() == expected, topic.name
    assert max(abs(bag.series(topics.VALVE_VOLTAGES).values).max(axis=0)) > 1.0
    assert not bag.series(topics.AUXILIARY).column("missed_deadlines").any()
    mass = bag.series(topics.GROUND_TRUTH_LOAD).column("mass")
    assert mass.tolist() == [0.0] * 60 + [400.0] * 80 + [0.0] * 60


def test_the_joystick_replayed_beside_programs_that_take_every_core_gives_the_run_again_to_the_last_bit(
    lockstep_bag, tmp_path, domain_id, start_process, capsys
):
    busy = [start_process(["-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    run_in_lockstep(lockstep_session(tmp_path, lockstep_bag), LOCKSTEP_STEPS, tmp_path, domain_id)
    for process in busy:
        process.kill_group()
    assert forest_bag(["compare", str(lockstep_bag), str(tmp_path / "bag")]) == 0, capsys.readouterr()


def test_what_is_attached_carries_the_run_s_time_and_not_the_computer_s(lockstep_bag):
    with next(lockstep_bag.glob("*.mcap")).open("rb") as stream:
        attached = list(make_reader(stream).iter_attachments())
    assert "parameters/simulator.yaml" in [attachment.name for attachment in attached]
    assert {(attachment.log_time, attachment.create_time) for attachment in attached} == {(0, 0)}


def test_between_the_rows_of_a_file_the_levers_go_on_lines(lockstep_bag, tmp_path):
    (tmp_path / "levers.csv").write_text(LEVERS)
    record, joy = read_levers(tmp_path / "levers.csv"), read_bag(lockstep_bag).series(topics.JOY)
    begun = joy.time_ns[0]
    usual = (joy.time_ns - begun < 600_000_000) | (joy.time_ns - begun >= 700_000_000)  # else frozen
    played = (joy.time_ns[usual] - begun) * 1e-9 - LEAD_IN
    wished = [record.at(time) if time >= 0.0 else REST for time in played.tolist()]
    said = [levers_from_axes(tuple(row)) for row in joy.values[usual].tolist()]
    assert np.array(said) == pytest.approx(np.array(wished), abs=1e-6)
    assert len({levers.swing for levers in said}) > 20  # a staircase has two


def test_faults_of_the_joystick_are_events_in_simulated_time(lockstep_bag):
    joy = read_bag(lockstep_bag).series(topics.JOY)
    steps = (joy.time_ns // STEP_NS - 1).tolist()  # since the first
    lost = sorted(set(range(LOCKSTEP_STEPS)) - set(steps))
    assert lost == [80, 81, 82, 83, 84, 85]
    frozen = [steps.index(step) for step in range(120, 140)]
    assert (joy.values[frozen] == joy.values[steps.index(119)]).all()


def test_a_recorder_that_dies_ends_the_run_and_is_named(tmp_path, domain_id, start_process, wait_until):
    options = ("--lockstep", "--duration", "0.5", "--out", str(tmp_path / "out"))
    demo = start_process(["-m", "forest_study.demo.demo", *options])
    wait_until(lambda: "recorder" in nodes_of(demo))
    kill(nodes_of(demo)["recorder"], signal.SIGKILL)
    assert demo.ended() == 1
    assert "recorder was killed by SIGKILL" in demo.text()


def test_a_node_that_hangs_ends_the_run_and_is_named(tmp_path, domain_id, start_process, wait_until):
    options = ("--lockstep", "--guard", "5", "--duration", "3600", "--out", str(tmp_path / "out"))
    demo = start_process(["-m", "forest_study.demo.demo", *options])
    bag = tmp_path / "out" / "bag"
    wait_until(lambda: any(path.stat().st_size > 200_000 for path in bag.glob("*.mcap")))
    kill(nodes_of(demo)["joystick"], signal.SIGSTOP)
    assert demo.ended() == 1
    assert re.search(r"step \d+: waited 5 s for /joy of joystick", demo.text()), demo.text()
