"""Trials of a change, and what they are judged by."""

import json

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_study.ablation import ablation_command, scenes
from forest_study.ablation.constants import changed
from forest_study.ablation.plants import FIGURES, NOT_ENDED
from forest_study.ablation.pushes import END, QUIET, activity, misjudged, push, pushed, rest
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


def test_a_tip_that_never_moves_is_a_failure_of_control(monkeypatch):
    monkeypatch.setattr(scenes, "_driven", lambda *_: trajectory(0.0, 0.0))
    for scene in (scenes.stops, scenes.sway):
        with pytest.raises(ValueError, match="the tip never moves"):
            scene(load_machine("c180_hoses"), changed({}))


USUAL = {"slow, mm/s": 6.0, "cycles, 1.1": 2.0, "rest, 1.1, mm": 5.0, "stop, s": 0.20}


def answers(of):
    """Return a `tried` whose figures are those of a function of the changes."""
    return lambda trials: [of(trial.changes) for trial in trials]


def test_a_table_of_constants_is_sorted_by_effect_and_tells_it_in_words(tmp_path, capsys, monkeypatch):
    """Here only what is made of the trials' figures."""

    def figures(changes):
        look, near = changes.get("servo.inching.LOOK"), changes.get("servo.inching.NEAR")
        if look == 0.175:
            return None
        more = {"cycles, 1.1": 7.0} if look else {"slow, mm/s": 6.1} if near else {}
        return {**USUAL, **more}

    monkeypatch.setattr(ablation_command, "tried", answers(figures))
    out = tmp_path / "ablation"
    given = ["--constants", "servo", "--only", "inching", "--out", str(out)]
    assert main(["ablation", *given]) == 0
    table = (out / "ablation.md").read_text().splitlines()
    assert table[2] == "| `servo.inching.LOOK` | 0.35 | control fails | cycles, 1.1 2 → 7 |"
    assert "| `servo.inching.NEAR` | 0.0003 | little | little |" in table
    assert "| `servo.inching.FAR` | 0.0008 | none | none |" in table
    told = json.loads((out / "ablation.json").read_text())["without"]
    assert told["servo.inching.LOOK × 2"]["cycles, 1.1"] == 7.0
    assert "| control fails |" in capsys.readouterr().out


def test_what_chance_does_is_no_effect_nor_what_is_as_far_beyond_it_as_it_is_wide(tmp_path, monkeypatch):
    """Chance gives 5 to 9 mm: 1 to 13 mm are no effect."""

    def figures(changes):
        look, chance = changes.get("servo.inching.LOOK"), changes.get("valve.load_estimate.FILLING")
        return {**USUAL, "rest, 1.1, mm": 9.0 if chance else {0.175: 12.0, 0.7: 15.0}.get(look, 5.0)}

    monkeypatch.setattr(ablation_command, "tried", answers(figures))
    given = ["--constants", "servo", "--only", "LOOK", "--out", str(tmp_path / "ablation")]
    assert main(["ablation", *given]) == 0
    told = (tmp_path / "ablation" / "ablation.md").read_text()
    assert "LOOK` | 0.35 | little | rest, 1.1 5.0 → 15.0 mm |" in told


def test_a_table_of_mechanisms_has_what_each_condition_gave(tmp_path, monkeypatch):
    paths = {"cross-track, mm": 1.0, "governed, mm": 2.0, "slow, mm/s": 3.0, "V/s": 4.0}
    pushes = {"cycles, 1": 0.0, "rest, 1, mm": 5.0, "cycles, 1 at 3°": 7.0, "rest, 1 at 3°, mm": 6.0}
    monkeypatch.setattr(ablation_command, "tried", answers(lambda _: {**paths, **pushes}))
    out = tmp_path / "ablation"
    assert main(["ablation", "--only", "holding", "--tilt", "0", "3", "--out", str(out)]) == 0
    assert "| holding | 1.00 | 2.00 | 3.0 | 4 | 0 7 | 5.0 6.0 |" in (out / "ablation.md").read_text()


def test_a_table_of_plants_has_median_and_worst_of_every_row(tmp_path, monkeypatch):
    told = [f"{row}, {{}}, {text}" for row, of in FIGURES.items() for text in of.values()]
    figures = {
        name.format(which): value for name in told for which, value in (("median", 1.5), ("worst", 20.0))
    }
    paths = {"cross-track, mm": 1.0, "governed, mm": 2.0, "slow, mm/s": 3.0, "V/s": 4.0, NOT_ENDED: 2.0}

    def tried(trials):
        assert [trial.plants for trial in trials] == [3] * len(trials)
        return [None if trial.changes else paths | figures for trial in trials]

    monkeypatch.setattr(ablation_command, "tried", tried)
    out = tmp_path / "ablation"
    assert main(["ablation", "--only", "search", "--plants", "3", "--out", str(out)]) == 0
    *_, head, rule, nothing, search = (out / "ablation.md").read_text().splitlines()
    assert nothing == f"| nothing | {' | '.join(['1.5 / 20'] * len(told))} | 2 |"
    assert search.startswith("| search | control failed |")
    assert len({line.count("|") for line in (head, rule, nothing, search)}) == 1


def test_a_name_that_no_constant_has_is_told(tmp_path, capsys):
    given = ["--constants", "servo", "--only", "NOWHERE", "--out", str(tmp_path / "out")]
    assert main(["ablation", *given]) == 1
    assert "no constant of these has NOWHERE in its name" in capsys.readouterr().err
