"""Trials of a change, and what they are judged by."""

import json

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_study.ablation import ablation_command
from forest_study.ablation.constants import changed
from forest_study.ablation.pushes import END, QUIET, activity, misjudged, push, rest
from forest_study.ablation.trials import Figures, pushed
from forest_study.cli import main
from forest_study.closed_loop.closed_loop import Trajectory

ROWS = round(END / PERIOD)
TIME = PERIOD * np.arange(ROWS)


def trajectory(volts, tip):
    """Return a session with these voltages of the boom and this way of the tip in x."""
    none = np.zeros((ROWS, 3))
    voltages, moved = none.copy(), none.copy()
    voltages[:, 1], moved[:, 0] = volts, tip
    return Trajectory(
        time=TIME, angles=none, tip=moved, tip_wish=none, commands=none, voltages=voltages,
        pressures=np.zeros((ROWS, 12)),
    )  # fmt: skip


def test_activity_is_the_mean_of_the_busiest_valves_rate():
    square = np.tile([0.0, 1.0], ROWS // 2)
    assert activity(trajectory(square, 0.0).voltages) == pytest.approx(1.0 / PERIOD)


@pytest.mark.parametrize(("until", "cycles"), [(QUIET - 0.5, False), (END, True)])
def test_only_a_valve_that_moves_when_it_should_be_quiet_cycles(until, cycles):
    volts = np.where(until > TIME, np.sin(2.0 * np.pi * TIME), 0.0)
    assert rest(trajectory(volts, 0.0)).cycles == cycles


def test_the_dither_of_a_valve_that_feeds_is_no_cycle():
    volts = 1.0 + 0.1 * np.sin(2.0 * np.pi * 50.0 * TIME)
    assert activity(trajectory(volts, 0.0).voltages) > 10.0
    assert not rest(trajectory(volts, 0.0)).cycles


def test_the_error_at_rest_is_a_mean_over_half_a_second():
    rocking = 0.003 + 0.01 * np.sin(2.0 * np.pi * 8.0 * TIME)
    tip = np.where(QUIET - 1.0 < TIME, rocking, 0.0)
    assert rest(trajectory(0.0, tip)).error == pytest.approx(0.003, abs=3e-4)


def test_equal_seeds_are_equal_pushes_within_the_limits():
    machine = load_machine("c180_hoses")
    assert push(machine, 3) == push(machine, 3) != push(machine, 4)


def test_only_the_named_axes_are_misjudged():
    believed = misjudged(load_machine("c180_hoses"), 1.2, (1,))
    overlaps = [believed.valve_of(axis).law.backward.deadband_voltage for axis in range(3)]
    assert overlaps == pytest.approx([1.0, 1.2, 1.0])


def test_a_hold_zone_that_is_gone_lets_the_valves_cycle():
    """With it nothing does: `test_valve_driver_at_rest`."""
    settings = changed({"valve_driver.hold_zone": 0.0})
    assert pushed(load_machine("c180_hoses"), 0, 1.1, 0.0, settings).cycles


def test_a_table_from_the_command_line(tmp_path, capsys, monkeypatch):
    """The trials' own process is the one above; here only what is made of its figures."""
    usual = Figures(
        paths_mm=1.0, governed_mm=2.0, slow_mm_s=3.0, volts_s=4.0, cycles=[0, 0], rest_mm=[5.0, 5.0]
    )
    answers = {0.175: usual._replace(cycles=[0, 7]), 0.7: None}
    monkeypatch.setattr(
        ablation_command, "tried", lambda t: answers.get(next(iter(t.changes.values()), None), usual)
    )
    out = tmp_path / "ablation"
    given = ["--constants", "servo", "--only", "inching.LOOK", "--tilt", "0", "3", "--out", str(out)]
    assert main(["ablation", *given]) == 0
    table = (out / "ablation.md").read_text().splitlines()
    assert [line.split(" | ")[0] for line in table[2:]] == [
        "| servo.inching.LOOK × 2",
        "| servo.inching.LOOK × 0.5",
        "| nothing",
    ]
    assert "control failed" in table[2]
    told = json.loads((out / "ablation.json").read_text())["without"]
    assert told["servo.inching.LOOK × 0.5"]["cycles"] == [0, 7]
    assert "failed" in capsys.readouterr().out


def test_a_name_that_no_constant_has_is_told(tmp_path, capsys):
    given = ["--constants", "servo", "--only", "NOWHERE", "--out", str(tmp_path / "out")]
    assert main(["ablation", *given]) == 1
    assert "no constant or mechanism of these has 'NOWHERE' in its name" in capsys.readouterr().err
