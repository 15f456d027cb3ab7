"""The matrix: a seed's plant in every row, what is told of it, and the command."""

import json
import math

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_control.servo.schemes import Scheme
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_study import cli
from forest_study.closed_loop import model_mismatch
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.matrix import load_change, matrix_report, matrix_runs
from forest_study.matrix.figures import Figures
from forest_study.matrix.matrix_report import summary, table, told
from forest_study.matrix.matrix_rows import FACTORS, apart, drawn_from, matrix_rows
from forest_study.matrix.matrix_runs import Outcome, run_row
from forest_study.matrix.rivals import RIVALS
from forest_study.tracking.paths import path_named

REAL, ROWS = load_machine("c180"), matrix_rows()
NONE = Figures(*[0.0] * len(Figures._fields))


@pytest.fixture(scope="module")
def inches():
    return run_row(ROWS["inch"], REAL, range(5), adapt=True)


def test_equal_seeds_give_equal_figures_whatever_else_is_run(inches):
    assert run_row(ROWS["inch"], REAL, [3], adapt=True) == [inches[3]]
    assert len({one.figures for one in inches}) == 5


def test_a_seeds_figures_are_the_worst_of_its_paths(inches):
    for one in inches:
        assert set(one.paths) == {"out", "left", "up"}
        for name in Figures._fields:
            assert getattr(one.figures, name) == max(getattr(f, name) for f in one.paths.values())


def test_a_seed_says_joystick_and_sensors_of_its_own(inches):
    assert [one.drawn["joystick_hz"] for one in inches] == [200.0, 100.0, 50.0, 20.0, 200.0]
    assert [one.drawn["sensors_hz"] for one in inches] == [200.0] * 4 + [50.0]
    assert matrix_runs._plant(ROWS["inch"], REAL, 4).sensed.sensors.sample_rate == 50.0


def test_what_a_row_adds_leaves_the_rest_of_a_seeds_plant():
    plain, both = (model_mismatch.draw(8, ROWS[name].ranges) for name in ("plain", "both"))
    assert plain._replace(hysteresis=both.hysteresis, backlash=both.backlash) == both
    assert (plain.hysteresis, plain.backlash) == (0.0, 0.0)
    assert both.hysteresis > 0.0 < both.backlash


def test_the_exact_row_is_the_machine_itself():
    plant = matrix_runs._plant(ROWS["exact"], REAL, 5)
    assert (plant.parameters, plant.sensed) == (plant_parameters(REAL), REAL)
    assert (plant.every, plant.steps, plant.dead_time) == (1, 0.0, REAL.valve.dead_time)


def differing(row):
    """Return which of a seed's values differ from the file's, of seed 6."""
    filed, drawn = (matrix_runs._plant(of, REAL, 6).told for of in (ROWS["exact"], row))
    return {name for name, value in drawn.items() if value != filed[name]}


def test_one_factor_alone_and_all_but_one_leave_a_seeds_other_values():
    whole = matrix_runs._plant(ROWS["both"], REAL, 6).told
    own = {"gain": {"gains"}, "stiffness": {"hoses", "modulus"}, "joystick": {"joystick_hz"}}
    for only, without in zip(*(apart(ROWS["both"], *f) for f in ((own, ()), ((), own))), strict=True):
        name = only.name.removeprefix("both, only ")
        assert without.name == f"both, without {name}"
        assert differing(only) == own[name]
        assert differing(without) == differing(ROWS["both"]) - own[name]
        alone = matrix_runs._plant(only, REAL, 6).told
        assert all(alone[value] == whole[value] for value in own[name])


def test_every_factor_is_drawn_in_the_row_that_has_all():
    every = ROWS["both"]._replace(ranges=ROWS["both"].ranges._replace(bending=0.5))
    for name, row in zip(FACTORS, apart(every, FACTORS, ()), strict=True):
        assert differing(row) or name == "sensors"  # seed 6 has the file's 50 Hz
    assert apart(ROWS["both"], (), ()) == [ROWS["both"]]


def test_the_slow_paths_and_inches_are_as_long_as_the_rows_say():
    assert [path.length for path in ROWS["slow"].paths] == pytest.approx([0.4] * 3)
    assert [path.length for path in ROWS["inch"].paths] == pytest.approx([0.02] * 3)


def test_in_the_row_of_bending_the_links_alone_are_not_as_filed():
    assert differing(ROWS["bending"]) == {"links"}


def test_a_log_that_is_grasped_and_dropped_moves_the_tip_no_further_than_shut_valves_let_it():
    """On the machine as believed; 134 mm."""
    one = run_row(drawn_from(ROWS["load"], ()), REAL, [0])[0].figures
    assert one.cross_track_max_mm > 50.0
    assert one.overshoot_mm < 2.0
    assert one.end_mm < 30.0


def test_a_tip_is_back_when_it_stays_near():
    away = np.array([0.001, 0.006, 0.004, 0.006, 0.001, 0.002])
    assert load_change._back(away) == pytest.approx(4 * PERIOD)
    assert load_change._back(0.5 * away) == 0.0


def test_what_the_file_lets_it_lift_on_a_path_is_that_of_its_longest_reach():
    reach, load = REAL.capacity.reach, REAL.capacity.load
    assert matrix_runs.least_capacity(ROWS["plain"].paths[1], REAL) == pytest.approx(
        np.interp(7.2, reach, load)
    )
    assert matrix_runs.least_capacity(ROWS["inch"].paths[0], REAL) == pytest.approx(
        np.interp(5.92, reach, load)
    )


def test_seeds_beyond_the_capacity_are_told_apart(inches):
    least = np.interp(5.92, REAL.capacity.reach, REAL.capacity.load)
    assert [one.overloaded for one in inches] == [one.drawn["head"] > least for one in inches]
    heavy = run_row(ROWS["inch"], REAL, [22])[0]
    assert heavy.drawn["head"] > least
    assert heavy.overloaded


def test_the_last_lap_is_judged_by_which_the_driver_has_learnt():
    first, last = (
        [one.figures.governed_max_mm for one in run_row(ROWS["inch"], REAL, range(8), laps=laps)]
        for laps in (1, 3)
    )
    assert np.median(last) < 0.8 * np.median(first)


def test_an_inch_takes_half_a_second():
    course = matrix_runs.prepare(ROWS["inch"].paths[0], 0.05, Scheme.COORDINATED, REAL)
    assert course.drawn[0].lap.profile.duration == pytest.approx(0.5, rel=5e-3)


class Led:
    """A run whose tip goes beyond its end by 3 mm and comes back, late by 0.1 s."""

    def __init__(self, drawn, late):
        lap = drawn.lap
        rows = round((lap.start + lap.profile.duration + 1.0) / PERIOD)
        times = PERIOD * np.arange(rows) - lap.start - late
        ways = [lap.path.at(lap.profile.way_at(t)) for t in times.tolist()]
        beyond = 3e-3 * np.exp(-(((times - lap.profile.duration - 0.2) / 0.05) ** 2))
        volts = np.outer(np.arange(rows) % 2, [0.1, 0.3, 0.2])
        tip = np.array(ways) + np.outer(beyond, [1.0, 0.0, 0.0])
        moved = {"tip": tip, "voltages": volts, "tip_wish": np.zeros((rows, 3))}
        self.clock = np.arange(rows, dtype=float)
        self.moved = Trajectory(
            time=PERIOD * np.arange(rows), angles=tip, commands=volts, pressures=volts, **moved
        )


@pytest.fixture
def judged(monkeypatch):
    course = matrix_runs.prepare(ROWS["inch"].paths[0], 0.05, Scheme.COORDINATED, REAL)
    led = Led(course.drawn[0], 0.1)
    session = matrix_runs.Session(course.drawn, led, *matrix_runs_scores(course, led))
    return matrix_runs._judged(session, 0.02, 0.05)


def matrix_runs_scores(course, led):
    from forest_study.tracking.scores import scores_of

    return scores_of(course.drawn, led, REAL)


def test_overshoot_activity_and_bound_are_those_of_a_known_run(judged):
    assert judged.overshoot_mm == pytest.approx(3.0, rel=0.02)
    assert judged.activity == pytest.approx(0.3 / PERIOD, rel=0.01)
    assert judged.waited_s == pytest.approx(0.0, abs=PERIOD)
    assert judged.wish_over_bound == pytest.approx(judged.wish_max_mm / (50.0 * 0.07 + 15.0))
    assert judged.time_lost_s == pytest.approx(0.1, abs=0.01)


def test_the_table_tells_the_worst_the_median_and_what_did_not_end():
    figures = [NONE._replace(cross_track_max_mm=x, wish_over_bound=x / 10.0) for x in (4.0, 9.0, 30.0)]
    outcomes = [Outcome(k, {}, False, one, {"way": one}) for k, one in enumerate(figures)]
    outcomes.append(Outcome(3, {}, False, None, {"way": None}))
    outcomes.append(Outcome(4, {}, True, figures[2], {"way": figures[2]}))
    found = summary(outcomes[:4])
    assert (found["worst"]["cross_track_max_mm"], found["median"]["cross_track_max_mm"]) == (30.0, 9.0)
    assert (found["over_bound"], found["not_ended"]) == ([2], [3])
    text = table({"fast": told(ROWS["fast"], outcomes)})
    assert "| 4, 1 not ended | 0.0 / 30.0 |" in text
    assert "| | median | 0.0 / 9.0 |" in text
    assert "| beyond the capacity | 1 | 0.0 / 30.0 |" in text
    assert "| 2 of 3 |" in text
    assert "8 / 20 mm" in text


def test_a_row_in_which_nothing_ended_is_told(tmp_path):
    lost = {"fast": told(ROWS["fast"], [Outcome(0, {}, False, None, {"way": None})])}
    assert "| 1, 1 not ended |" in table(lost)
    matrix_report.draw(lost, tmp_path / "matrix.png")
    assert (tmp_path / "matrix.png").stat().st_size > 1000


def test_the_command_leaves_numbers_table_and_picture(tmp_path, capsys):
    out = tmp_path / "out"
    assert cli.main(["matrix", "--seeds", "2", "--seed", "6", "--row", "inch", "--out", str(out)]) == 0
    report = json.loads((out / "matrix.json").read_text())
    assert [run["seed"] for run in report["rows"]["inch"]["runs"]] == [6, 7]
    assert all(math.isfinite(x) for x in report["rows"]["inch"]["within"]["worst"].values())
    assert (out / "matrix.md").read_text().strip() in capsys.readouterr().out
    assert (out / "matrix.png").stat().st_size > 1000


def test_an_unknown_row_is_answered_with_those_there_are(tmp_path, capsys):
    with pytest.raises(SystemExit):
        cli.main(["matrix", "--row", "slippery", "--out", str(tmp_path / "out")])
    assert "'plain'" in capsys.readouterr().err


def test_a_machine_that_reaches_no_path_is_refused_in_one_sentence(tmp_path, capsys):
    out = str(tmp_path / "out")
    assert cli.main(["matrix", "--machine", "loader", "--row", "plain", "--seeds", "1", "--out", out]) == 1
    assert capsys.readouterr().err.startswith("forest-study: matrix: sweep: ")


def test_a_rival_drives_with_its_own_settings():
    """Open-loop joint rates lose the path where ours keeps it."""
    row = ROWS["exact"]._replace(paths=(path_named("radial"),))
    lost = {
        name: run_row(row, REAL, [0], rival=RIVALS[name])[0].figures.cross_track_max_mm
        for name in ("coordinated", "joint_velocity")
    }
    assert lost["coordinated"] < 3.0 < 20.0 < lost["joint_velocity"]
