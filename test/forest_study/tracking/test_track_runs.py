"""Many runs along a path: the same figures as one after the other in Python, drawn machines, what is told."""

import argparse
import json
import math

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_control.operator.levers import Levers
from forest_control.servo.schemes import Scheme
from forest_control.taught.tip_path import polyline
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import parameters_of, plant_parameters
from forest_study import cli
from forest_study.closed_loop import closed_loop, model_mismatch
from forest_study.closed_loop.closed_loop import Operator
from forest_study.closed_loop.model_mismatch import Ranges
from forest_study.tracking import track_command, tracking
from forest_study.tracking.track_runs import Variation, quantiles, run_many

C180 = load_machine("c180")
WAY = polyline("way", [(5.5, 0.0, 1.0), (5.5, 0.2, 1.1)])
NONE = Ranges(0.0, 0.0, 1.0, 1.0)


@pytest.fixture(scope="module")
def course():
    return tracking.prepare(WAY, 0.5, Scheme.COORDINATED, C180, 2)


def varied(seed):
    return Variation(tracking.noisy(C180, seed), model_mismatch.draw(seed, Ranges()))


def interpreted(machine, table, start, control, drive, model, suite, plant):
    def operator(time):
        *levers, enabled = table[round(time / PERIOD)].tolist()
        return Operator(Levers(*levers), enabled > 0.5)

    end = PERIOD * len(table)
    return closed_loop.run(machine, operator, end, start, control, drive, model, suite, plant=plant)


def test_a_run_has_the_figures_of_the_python_loop(course, monkeypatch):
    runs, session = run_many(course, C180, [3], varied, adapt=True)
    monkeypatch.setattr(tracking.loop_kernel, "run", interpreted)
    python = tracking.follow(
        course,
        C180,
        tracking.noisy(C180, 3),
        True,
        model_mismatch.applied(C180, model_mismatch.draw(3, Ranges())),
    )
    assert runs[0].total == python.total
    assert runs[0].laps == python.scores
    np.testing.assert_array_equal(session.moved.tip, python.moved.tip)


def test_threads_change_nothing_and_seeds_do(course):
    together, _ = run_many(course, C180, range(6), varied, workers=3)
    alone = [run_many(course, C180, [seed], varied)[0][0] for seed in range(6)]
    assert together == alone
    assert len({run.total.governed_rms_mm for run in together}) == 6


def test_quantiles_are_those_of_the_runs(course):
    runs, _ = run_many(course, C180, range(5), varied)
    spread = quantiles(runs)
    values = sorted(run.total.governed_max_mm for run in runs)
    assert list(spread["governed_max_mm"].values()) == sorted(spread["governed_max_mm"].values())
    assert (spread["governed_max_mm"]["least"], spread["governed_max_mm"]["median"]) == (values[0], values[2])
    assert spread["governed_max_mm"]["greatest"] == values[4]
    assert len(spread["laps"]) == 2


def test_no_ranges_draw_the_machine_itself():
    assert model_mismatch.applied(C180, model_mismatch.draw(5, NONE)) == plant_parameters(C180)


def test_draws_stay_in_their_ranges_and_reach_them():
    drawn = [model_mismatch.draw(seed, Ranges()) for seed in range(300)]
    deadbands = np.array([m.deadbands for m in drawn])
    gains = np.array([m.gains for m in drawn])
    assert 0.145 < -deadbands.min() <= 0.15
    assert 0.145 < deadbands.max() <= 0.15
    assert 0.6 <= gains.min() < 0.61
    assert 1.39 < gains.max() <= 1.4
    assert math.isclose(max(m.head_mass for m in drawn), 2.0, rel_tol=0.02)
    assert math.isclose(min(m.spool for m in drawn), 1.0 / 1.5, rel_tol=0.02)
    assert drawn[7] == model_mismatch.draw(7, Ranges())


def test_a_gain_is_flow_at_a_drop_and_a_deadband_is_added():
    p, off = parameters_of(C180), model_mismatch.draw(11, Ranges())
    mine, own = model_mismatch.applied(C180, off).valves[1], p.valves[1]
    back, before = mine.law.backward, own.law.backward
    assert back.deadband_voltage == pytest.approx(before.deadband_voltage + off.deadbands[3])
    assert math.sqrt(before.resistance_2 / back.resistance_2) == pytest.approx(off.gains[3])
    assert mine.lag.frequency == pytest.approx(off.spool * own.lag.frequency)
    assert model_mismatch.applied(C180, off).body != p.body


def test_an_overlap_never_becomes_an_underlap():
    wide = model_mismatch.draw(1, Ranges(deadband=1.0))._replace(deadbands=(-9.0,) * 6)
    law = model_mismatch.applied(C180, wide).valves[0].law
    assert (law.forward.deadband_voltage, law.backward.deadband_voltage) == (0.0, 0.0)


def test_ranges_of_a_command_line():
    assert model_mismatch.ranges_from("gain=0.2,spool=3") == Ranges(gain=0.2, spool=3.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("oil=1", "NAME=NUMBER of deadband, gain, head_mass, spool"),
        ("gain", "gain=NUMBER"),
        ("gain=most", "gain=NUMBER"),
        ("gain=nan", "0 .. 0.9"),
        ("head_mass=0.5", "1 .. 10"),
    ],
)
def test_wrong_ranges_are_answered_with_what_is_allowed(text, says):
    with pytest.raises(argparse.ArgumentTypeError, match=says):
        model_mismatch.ranges_from(text)


def test_the_command_tells_every_run_and_how_they_spread(tmp_path):
    way, out = tmp_path / "way.csv", tmp_path / "out"
    way.write_text("x,y,z\n5.5,0,1\n5.5,0.2,1\n")
    arguments = ["track", "--path", str(way), "--noise", "--runs", "4", "--mismatch", "gain=0.2"]
    assert cli.main([*arguments, "--seed", "7", "--adapt", "--out", str(out)]) == 0
    report = json.loads((out / "track.json").read_text())
    assert [run["seed"] for run in report["runs"]] == [7, 8, 9, 10]
    assert report["mismatch"]["gain"] == 0.2
    assert all(0.8 <= gain <= 1.2 for run in report["runs"] for gain in run["mismatch"]["gains"])
    for name in ("governed_rms_mm", "cross_track_max_mm", "wish_rms_mm", "time_lost_s"):
        greatest = max(run[name] for run in report["runs"])
        assert report["quantiles"]["way"][name]["greatest"] == greatest
    assert (out / "runs.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("given", "allowed"),
    [
        (("--runs", "many"), "'many'; allowed: 1 .. 1000, whole"),
        (("--runs", "0"), "'0'; allowed: 1 .. 1000, whole"),
        (("--seed", "-1"), "'-1'; allowed: 0 .. 2147483647, whole"),
        (("--speed", "nan"), "'nan'; allowed: 0.01 .. 3 m/s"),
    ],
)
def test_wrong_numbers_are_answered_with_what_is_allowed(given, allowed, tmp_path, capsys):
    with pytest.raises(SystemExit) as stopped:
        cli.main(["track", "--path", "sweep", *given, "--out", str(tmp_path / "out")])
    assert stopped.value.code == 2
    assert allowed in capsys.readouterr().err


def test_without_llvm_the_command_says_what_to_install(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(track_command, "can_compile", lambda: False)
    assert cli.main(["track", "--path", "sweep", "--out", str(tmp_path / "out")]) == 1
    assert "pip install 'forest-crane[fast]'" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
