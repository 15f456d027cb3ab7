"""Many runs along a path: the same figures as one after the other in Python, drawn machines, what is told."""

import argparse
import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_control.servo.schemes import Scheme
from forest_control.taught.tip_path import polyline
from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import parameters_of, plant_parameters
from forest_study import cli, results
from forest_study.closed_loop import loop_kernel, model_mismatch
from forest_study.closed_loop.model_mismatch import Ranges
from forest_study.closed_loop.path_guide import Hand
from forest_study.tracking import tracking
from forest_study.tracking.paths import path_named
from forest_study.tracking.track_runs import Variation, quantiles, run_many

C180 = load_machine("c180_hoses")
WAY = polyline("way", [(5.5, 0.0, 1.0), (5.5, 0.2, 1.1)])
NONE = Ranges(0.0, 0.0, 1.0, 1.0)


@pytest.fixture(scope="module")
def course():
    return tracking.prepare(WAY, 0.5, Scheme.COORDINATED, C180, 2)


def varied(seed):
    return Variation(tracking.noisy(C180, seed), model_mismatch.draw(seed, Ranges()))


class Unmade:
    """The loop's machine code, before anybody made it."""

    def ready(self):
        return None

    def kernel(self):
        raise LookupError("made")


def test_a_run_in_machine_code_has_the_figures_of_the_python_loop(course, monkeypatch):
    """Which takes its place for a few runs, until it is made."""
    loop_kernel.KERNEL.kernel()
    runs, session = run_many(course, C180, [3], varied, adapt=True)
    monkeypatch.setattr(loop_kernel, "KERNEL", Unmade())
    few, python = run_many(course, C180, [3], varied, adapt=True)
    assert runs == few
    with pytest.raises(LookupError, match="made"):
        run_many(course, C180, range(20_001 // len(course.places) + 1), varied)
    np.testing.assert_array_equal(session.moved.tip, python.moved.tip)
    np.testing.assert_array_equal(session.led.levers, python.led.levers)
    np.testing.assert_array_equal(session.led.clock, python.led.clock)


def test_so_has_one_whose_joystick_is_slow_and_coarse_and_whose_machine_takes_long_steps(course):
    slow = course._replace(hand=Hand(0.5, 10.0, 4, 127.0), substeps=2)
    compiled, python = (
        tracking.follow(slow, C180, tracking.noisy(C180, 3), compiled=way) for way in (True, False)
    )
    for name in ("levers", "clock"):
        np.testing.assert_array_equal(getattr(compiled.led, name), getattr(python.led, name))
    np.testing.assert_array_equal(compiled.moved.tip, python.moved.tip)
    levers = compiled.led.levers[:, :3]
    assert np.abs(levers * 127.0 - np.round(levers * 127.0)).max() < 1e-4
    changed = np.flatnonzero(np.any(np.diff(levers, axis=0) != 0.0, axis=1)) + 1
    assert set(changed % 4) == {0}
    assert compiled.total.wish_max_mm > 10.0  # read two samples behind: 0.04 s at 0.4 m/s


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


def test_of_a_hose_known_by_its_bore_the_wall_is_drawn():
    """The oil in it is drawn with all other oil; what is rigid stays so."""
    forwarder = load_machine("forwarder")
    off = model_mismatch.draw(3, NONE._replace(stiffness=0.2))
    drawn = model_mismatch.drawn(forwarder, off)
    for axis, factor in enumerate(off.hoses):
        was, now = forwarder.hose_of(axis), drawn.hose_of(axis)
        assert factor != 1.0
        assert now == dataclasses.replace(was, wall_modulus=factor * was.wall_modulus)
    rigid = dataclasses.replace(forwarder.hose, wall_modulus=None)
    hoses = model_mismatch.drawn(dataclasses.replace(forwarder, hose=rigid), off)
    assert hoses.hose_of(1) == rigid


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


HIDDEN = Ranges(
    deadband=0.2,
    gain=0.2,
    stiffness=0.2,
    tilt=10.0,
    head=2000.0,
    dead_time=0.02,
    hysteresis=0.3,
    backlash=0.2,
    oil=80.0,
)


def test_what_more_is_drawn_leaves_valves_head_and_spools_as_they_were():
    few, many = (model_mismatch.draw(9, ranges) for ranges in (Ranges(deadband=0.2, gain=0.2), HIDDEN))
    assert few[:4] == many[:4]


def test_every_part_of_a_machine_is_what_was_drawn():
    real = load_machine("c180")
    off, own = model_mismatch.draw(12, HIDDEN), parameters_of(real)
    p = model_mismatch.applied(real, off._replace(oil=None))
    assert p.swing.oil_1.wall == pytest.approx(own.swing.oil_1.wall / off.hoses[0], rel=0.3)
    assert p.drive.gear.teeth.upper == pytest.approx(0.5 * off.backlash)
    assert math.degrees(off.backlash) < 0.2
    assert p.boom.oil_1.oil != own.boom.oil_1.oil
    assert {valve.lag.dead_time for valve in p.valves} == {off.dead_time}
    assert {valve.lag.play for valve in p.valves} == {off.hysteresis}
    assert model_mismatch.applied(real, off._replace(oil=None, tilt=0.0)).body != p.body
    assert p.head != own.head


def test_extremes_of_what_is_drawn_follow_their_ranges():
    drawn = [model_mismatch.draw(seed, HIDDEN) for seed in range(300)]
    for name, most in (("head", 2000.0), ("dead_time", 0.02), ("hysteresis", 0.3)):
        values = [getattr(m, name) for m in drawn]
        assert 0.0 <= min(values) < 0.02 * most
        assert 0.98 * most < max(values) <= most
    assert max(abs(math.degrees(m.tilt)) for m in drawn) == pytest.approx(10.0, rel=0.02)
    assert 273.15 <= min(m.oil for m in drawn) < max(m.oil for m in drawn) <= 353.15
    assert 0.8 <= min(min(m.hoses) for m in drawn) < max(max(m.hoses) for m in drawn) <= 1.2


def test_none_of_it_is_none_and_nothing_drawn_is_as_in_the_file():
    real, none = load_machine("c180"), Ranges(0.0, 0.0, 1.0, 1.0)
    bare = model_mismatch.applied(real, model_mismatch.draw(3, none._replace(hysteresis=0.0, backlash=0.0)))
    assert {valve.lag.play for valve in bare.valves} == {0.0}
    assert model_mismatch.applied(real, model_mismatch.draw(3, none)) == parameters_of(real)


def test_a_gear_that_a_machine_has_not_is_not_drawn():
    with pytest.raises(MachineError, match=r"no swing\.backlash"):
        model_mismatch.applied(C180, model_mismatch.draw(3, Ranges(backlash=0.2)))


def test_an_overlap_never_becomes_an_underlap():
    wide = model_mismatch.draw(1, Ranges(deadband=1.0))._replace(deadbands=(-9.0,) * 6)
    law = model_mismatch.applied(C180, wide).valves[0].law
    assert (law.forward.deadband_voltage, law.backward.deadband_voltage) == (0.0, 0.0)


def test_ranges_of_a_command_line():
    assert model_mismatch.ranges_from("gain=0.2,spool=3") == Ranges(gain=0.2, spool=3.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("air=1", "NAME=NUMBER of deadband, gain, head_mass, spool, stiffness, tilt"),
        ("oil=101", "0 .. 100"),
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
    monkeypatch.setattr(results, "can_compile", lambda: False)
    assert cli.main(["track", "--path", "sweep", "--out", str(tmp_path / "out")]) == 1
    assert "pip install 'forest-crane[fast]'" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_plain_valves_on_a_load_sensing_pump_lower_through_counterbalance_valves_as_told():
    """The driver took for its own what those valves throttle: 77 mm RMS along this path, in place of 8."""
    machine = load_machine(str(Path(__file__).parents[3] / "docs/studies/plain_sections.yaml"))
    course = tracking.prepare(path_named("radial"), 0.5, Scheme.COORDINATED, machine)
    (run,), _ = run_many(course, machine, [0], lambda seed: Variation(tracking.noisy(machine, seed), None))
    assert run.total.governed_rms_mm < 20.0
