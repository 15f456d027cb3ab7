"""The table of faults: some cells of it, and what breaks a bound; the whole is `scripts/faults.sh`."""

import json
import math

import numpy as np
import pytest

from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_study import cli
from forest_study.faults import faults_command, wires
from forest_study.faults.catalogue import FAULTS
from forest_study.faults.fault import Bound, State
from forest_study.faults.fault_report import broken, table, worst
from forest_study.faults.faulty_loop import Wires
from forest_study.faults.scenes import BEGUN, ByHand
from forest_study.faults.trials import NO_FAULT, Outcome, trial

MACHINE = load_machine("c180")
WELL = Outcome(
    3, zero=0.1, way=0.05, off=0.2, speed=0.4, told="x: y", told_after=0.1, restarted=False, again=True
)
# Where the axis does not matter, cells of a state have one seed, and so one run without the fault.
CELLS = [
    ("joystick silent", State.MOTION, 6),
    ("joystick hangs", State.POSITION, 1),
    ("joystick flickers", State.TAUGHT, 2),
    ("joystick's clock - 1 h", State.MOTION, 6),
    ("machine's clock - 1 h", State.EXPERIMENT, 4),
    ("states lost", State.TAUGHT, 2),
    ("commands lost for 0.4 s", State.POSITION, 1),
    ("commands now and then", State.MOTION, 6),
    ("controller restarted", State.LIMIT, 8),
    ("resolver absent", State.STANDING, 9),
    ("resolver frozen", State.EXPERIMENT, 10),
    ("resolvers swapped", State.MOTION, 11),
    ("swing's pressure 30 MPa high", State.STANDING, 9),
    ("spool stuck", State.MOTION, 12),
    ("supply lost", State.EXPERIMENT, 4),
    ("supply lost for 2 s", State.MOTION, 6),
    ("wrong machine file", State.LIMIT, 8),
]


@pytest.mark.parametrize(("name", "state", "seed"), CELLS, ids=[f"{n}-{s.value}" for n, s, _ in CELLS])
def test_a_fault_keeps_its_bound(name, state, seed):
    fault = FAULTS[name]
    assert broken(fault.bounds[state], trial(fault, state, seed, MACHINE)) == []


def test_a_pump_that_fails_three_times_a_second_throws_no_tip():
    crane, tips = ByHand(MACHINE, State.MOTION, Wires(NO_FAULT, 0, 0.0, 0), 0), []
    good = crane._loop._plant
    for k in range(400):
        failed = k >= 200 and (k - 200) // 33 % 2 == 0
        crane._loop._set_plant(wires.no_supply(crane._loop.simulation, good)[1] if failed else good)
        angles = crane.period(True, k * PERIOD > BEGUN).angles
        tips.append(tip_position(angles, MACHINE.manipulator.links))
    assert crane.told().startswith("the supply is under")
    assert np.linalg.norm(np.diff(tips, axis=0), axis=1).max() / PERIOD < 1.2 * 0.5 + 0.1


def test_a_trial_repeats_to_the_last_bit():
    fault = FAULTS["resolver noise x 100"]
    one, other = (trial(fault, State.MOTION, 2, MACHINE) for _ in range(2))
    assert one == other
    assert one != trial(fault, State.MOTION, 3, MACHINE)


def test_there_are_thirty_faults_in_up_to_six_states_each_with_its_reason():
    assert len(FAULTS) >= 30
    assert {state for fault in FAULTS.values() for state in fault.bounds} == set(State)
    assert all(fault.reason.endswith(".") and fault.text and fault.bounds for fault in FAULTS.values())


@pytest.mark.parametrize(
    ("bound", "outcome", "sentence"),
    [
        (Bound(), {"restarted": True}, "it moved again without a deliberate act"),
        (Bound(), {"again": False}, "it did not move after the deliberate act"),
        (Bound(zero=0.05), {}, "zero voltage after 0.10 s; allowed: 0.05 s"),
        (Bound(zero=9.0), {"zero": math.inf}, "zero voltage after inf s; allowed: 9 s"),
        (Bound(way=0.04), {}, "way is 0.050; allowed: 0.04"),
        (Bound(off=0.1), {}, "off is 0.200; allowed: 0.1"),
        (Bound(speed=0.3), {}, "speed is 0.400; allowed: 0.3"),
        (Bound(told="z"), {}, "the operator is told 'x: y'; wanted: 'z'"),
        (Bound(told="x", told_within=0.05), {}, "told after 0.10 s; allowed: 0.05 s"),
    ],
)
def test_what_breaks_a_bound_is_named(bound, outcome, sentence):
    assert broken(bound, WELL._replace(**outcome)) == [sentence]


def test_what_keeps_every_bound_breaks_none():
    kept = Bound(zero=0.1, way=0.05, off=0.2, speed=0.4, told="x:", told_within=0.1)
    assert broken(kept, WELL) == []


def test_the_table_shows_the_worst_seed_and_marks_what_is_beyond_its_bound():
    fault = FAULTS["states lost"]._replace(bounds={State.MOTION: Bound(zero=0.2, told="x")})

    def row(*outcomes):
        return table({"a": fault}, {("a", State.MOTION): worst(outcomes)}).splitlines()[-1]

    assert "| zero in 0.2 s |" in row(WELL)
    assert "| 0.15 s |" in row(WELL, WELL._replace(zero=0.15))
    assert "| **moves on** |" in row(WELL, WELL._replace(zero=math.inf))
    assert "| **0.10 s** |" in row(WELL, WELL._replace(restarted=True))
    assert row(WELL).endswith("| x: y |")
    assert row(WELL, WELL._replace(told="")).endswith("| x: y; or nothing |")
    assert row(WELL._replace(told="")).endswith("| nothing |")


def test_the_command_writes_the_page_and_fails_where_a_bound_is_broken(tmp_path, monkeypatch, capsys):
    fault = FAULTS["states lost"]
    arguments = ["faults", "--only", "states lost", "--state", "motion", "--seeds", "1", "--out"]
    assert cli.main([*arguments, str(tmp_path / "kept")]) == 0
    assert "| states lost |" in (tmp_path / "kept" / "faults.md").read_text()
    strict = {"states lost": fault._replace(bounds={State.MOTION: Bound(zero=0.01)})}
    monkeypatch.setattr(faults_command, "FAULTS", strict)
    assert cli.main([*arguments, str(tmp_path / "broken")]) == 1
    (told,) = json.loads((tmp_path / "broken" / "faults.json").read_text())["broken"]
    assert told.startswith("states lost, motion, seed 0: zero voltage after 0.10 s")
    assert told in capsys.readouterr().out
