"""The tip along a path: profiles, scores, the command; and what the coordinated scheme reaches."""

import dataclasses
import json
import math
from functools import lru_cache

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.servo.joint_angle_filter import Source
from forest_control.servo.schemes import Scheme
from forest_control.taught.plan import RAMP, greatest_speed
from forest_control.taught.tip_path import PathError, fastest, is_closed, polyline, reverse
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_study import cli
from forest_study.tracking import track_command
from forest_study.tracking.paths import NAMES, path_named
from forest_study.tracking.tracking import noisy, plan, track

C180 = load_machine("c180_hoses")
UNLIMITED = 100.0


@lru_cache(maxsize=16)
def session(name, machine=C180, speed=0.5, scheme=Scheme.COORDINATED, seed=0, **options):
    return track(path_named(name), speed, scheme, machine, C180, noisy(machine, seed), **options)


def changed(**manipulator):
    return dataclasses.replace(C180, manipulator=dataclasses.replace(C180.manipulator, **manipulator))


@pytest.mark.parametrize("name", NAMES)
def test_a_free_profile_is_the_trapezoid(name):
    path = path_named(name)
    profile = fastest(path, 0.5, RAMP, lambda place, along: UNLIMITED)
    assert profile.duration == pytest.approx(path.length / 0.5 + 0.5 / RAMP, rel=1e-3)
    times = np.arange(0.0, profile.duration, PERIOD)
    speed = np.gradient([profile.way_at(t) for t in times], PERIOD)
    assert speed.max() < 0.5 + 1e-6
    assert np.abs(np.gradient(speed, PERIOD))[2:-2].max() < RAMP * 1.01


def test_a_profile_keeps_below_a_limit_on_the_way_and_stops_at_corners():
    path = polyline("corner", [(5.0, 0.0, 0.0), (6.0, 0.0, 0.0), (6.0, 0.0, 1.0)])
    slow = fastest(path, 0.5, RAMP, lambda place, along: 0.2 if 5.3 < place[0] < 5.5 else UNLIMITED)
    inside = (slow.way > 0.3) & (slow.way < 0.5)
    assert slow.speed[inside].max() <= 0.2
    assert slow.speed[np.isclose(slow.way, 1.0)].max() == 0.0
    assert slow.speed[slow.way > 1.2].max() > 0.3


@pytest.mark.parametrize("count", [24, 360])
def test_a_circle_of_waypoints_is_as_quick_as_a_circle(count):
    turns = np.linspace(0.0, 2.0 * np.pi, count + 1)
    slope = np.sqrt(0.5)
    points = [(5.9 - slope * np.cos(t), np.sin(t), 0.8 - slope * np.cos(t)) for t in turns.tolist()]
    path = polyline("tilted", points)
    assert path.length == pytest.approx(2.0 * np.pi, rel=1e-3)
    assert path.stops == (0.0, path.length)
    away = [
        np.linalg.norm(np.array(path.at(s)) - (5.9, 0.0, 0.8)) for s in np.linspace(0.0, path.length, 999)
    ]
    assert np.abs(np.array(away) - 1.0).max() < 1e-3
    profile = fastest(path, 0.5, RAMP, lambda place, along: UNLIMITED)
    assert profile.duration == pytest.approx(path.length / 0.5 + 0.5 / RAMP, rel=1e-3)


def test_a_path_stops_at_corners_and_at_repeated_points_and_slows_down_in_bends():
    here, there, back = (5.0, 0.0, 1.0), (6.0, 0.0, 1.0), (7.0, 0.0, 1.0)
    assert polyline("through", [here, there, back]).stops == (0.0, 2.0)
    assert polyline("stop", [here, there, there, back]).stops == (0.0, 1.0, 2.0)
    assert polyline("and back", [here, here, there, here]).stops == (0.0, 1.0, 2.0)
    turns = np.linspace(0.0, 2.0 * np.pi, 61).tolist()
    tight = polyline("tight", [(5.5 + 0.05 * np.cos(t), 0.05 * np.sin(t), 1.0) for t in turns])
    speeds = fastest(tight, 2.0, 10.0, lambda place, along: UNLIMITED).speed
    assert speeds.max() == pytest.approx(np.sqrt(1.5 * 0.05), rel=0.05)  # 1.5 m/s^2 across the way


@pytest.mark.parametrize("name", NAMES)
def test_a_reversed_path_ends_where_the_path_starts(name):
    path = path_named(name)
    assert reverse(path).at(path.length) == pytest.approx(path.at(0.0))
    assert is_closed(path) == name.startswith("circle")


@pytest.mark.parametrize("name", ["radial", "circle_h"])
def test_a_plan_takes_at_most_1_1_of_the_least_time_and_the_governor_leaves_it_alone(name):
    settings = controller_settings.Settings(scheme=Scheme.COORDINATED, tip_speed=1.0)
    p = controller_settings.parameters(C180, settings)
    path = path_named(name)
    planned = plan(path, 1.0, p, 1)[0].profile.duration
    free = fastest(path, 1.0, RAMP, lambda place, along: greatest_speed(path.name, place, along, 1.0, p))
    least = free.duration
    assert least <= planned <= 1.1 * least
    moved = session(name, speed=1.0).moved
    assert np.sum(np.linalg.norm(moved.tip_wish, axis=1)) * PERIOD == pytest.approx(path.length, rel=2e-3)


@pytest.mark.parametrize("name", NAMES)
def test_coordinated_tracks_with_noise_as_the_results_say(name):
    score = session(name).total
    assert score.governed_rms_mm < 1.0
    assert score.governed_max_mm < 3.5
    assert score.saturated_s == 0.0


def test_the_cylinders_take_the_resolvers_static_error_out_of_boom_and_stick():
    way, suite = path_named("vertical"), noisy(C180, 1, static_errors=True)
    cylinders, joints = (
        track(way, 0.5, Scheme.COORDINATED, C180, C180, suite, source=source).total
        for source in (Source.CYLINDERS, Source.JOINTS)
    )
    assert joints.governed_rms_mm > 1.2
    assert cylinders.governed_rms_mm < 0.8


def test_the_thesis_schemes_are_far_behind():
    """(c) drifts with what the valve's model leaves out, (d) lags by the speed over its gain."""
    best = session("vertical").total.governed_rms_mm
    assert session("vertical", scheme=Scheme.JACOBIAN_VELOCITY).total.governed_rms_mm > 4.0 * best
    assert session("vertical", scheme=Scheme.JACOBIAN_POSITION).total.governed_rms_mm > 40.0 * best


def test_coordinated_stands_a_heavier_head_a_slower_spool_and_a_tilt():
    slow = dataclasses.replace(C180, valve=dataclasses.replace(C180.valve, spool_bandwidth=8.0))
    heavy = changed(head_mass=2.0 * C180.manipulator.head_mass)
    tilted = changed(platform_tilt=math.radians(10.0))
    for machine in (heavy, slow, tilted):
        score = session("sweep", machine).total
        assert score.governed_rms_mm < 3.0
        assert score.governed_max_mm < 10.0


@pytest.mark.parametrize(("name", "speed"), [("sweep", 0.1), ("radial", 0.02), ("circle_v", 0.05)])
def test_slow_motion_does_not_swing_up_on_the_oil(name, speed):
    """A cylinder's valve that is open a little does not damp what a quick position loop feeds at 8 Hz."""
    assert session(name, speed=speed).total.velocity_rms < 0.02  # 0.07 to 0.18 m/s before


@pytest.mark.parametrize(("name", "seed"), [("circle_h", 0), ("sweep", 1)])
def test_a_slow_swing_is_not_taken_for_a_cycle_at_rest(name, seed):
    """Its valve opens and shuts, always the same way; the hold zone grew, and the tip went in jerks."""
    assert session(name, speed=0.02, seed=seed).total.governed_rms_mm < 2.5  # 9.8 on circle_h before


def test_fast_paths_are_governed_not_saturated():
    score = session("radial", speed=1.0).total
    assert score.governed_rms_mm < 1.0
    assert score.saturated_s == 0.0
    assert 3.0 < score.duration_s < 7.0  # 4.5 s unlimited


def test_the_run_is_as_long_as_its_plan_and_ends_at_the_paths_end():
    moved = session("radial", speed=1.0)
    lap = moved.drawn[0].lap
    assert moved.total.duration_s == pytest.approx(lap.profile.duration, abs=2 * PERIOD)
    way = np.sum(moved.moved.tip_wish, axis=0) * PERIOD
    assert way == pytest.approx([2.5, 0.0, 0.0], abs=2e-3)


def test_laps_go_back_and_forth_and_equal_seeds_repeat_exactly():
    one, same, other = (session.__wrapped__("vertical", seed=seed, laps=2) for seed in (1, 1, 2))
    assert len(one.scores) == 2
    assert np.linalg.norm(one.moved.tip[-1] - one.moved.tip[0]) < 0.01
    assert np.array_equal(one.moved.tip, same.moved.tip)
    assert not np.array_equal(one.moved.tip, other.moved.tip)


def test_the_command_writes_scores_and_a_picture(tmp_path, capsys):
    way = tmp_path / "way.csv"
    way.write_text("x,y,z\n5.5,0,1\n5.5,0.3,1\n5.5,0.3,1.2\n")
    out = tmp_path / "out"
    arguments = ["track", "--path", str(way), "--noise", "--seeds", "2", "--out", str(out)]
    assert cli.main(arguments) == 0
    report = json.loads((out / "track.json").read_text())
    assert [run["seed"] for run in report["runs"]] == [0, 1]
    assert {"governed_rms_mm", "governed_max_mm", "velocity_rms", "duration_s", "saturated_s"} <= set(
        report["runs"][0]["laps"][0]
    )
    assert (out / "way.png").stat().st_size > 1000
    assert "| way |" in capsys.readouterr().out
    assert cli.main(arguments) == 1
    assert "is not empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("x,y,z\n5,0,1\n1e300,0,1\n", "longer than 200 m"),
        ("x,y\n1,2\n", "header"),
        ("x,y,z\n1,2,up\n", "way.csv:2"),
        ("x,y,z\n1,2,3\n", "two or more points"),
    ],
)
def test_a_wrong_file_of_waypoints_is_answered_with_what_is_wrong(tmp_path, text, says):
    way = tmp_path / "way.csv"
    way.write_text(text)
    with pytest.raises(PathError, match=says):
        path_named(str(way))


def test_static_errors_without_noise_are_refused_not_ignored(tmp_path, capsys):
    assert cli.main(["track", "--path", "radial", "--static-errors", "--out", str(tmp_path / "out")]) == 1
    assert "--noise" in capsys.readouterr().err


def test_a_path_out_of_reach_is_refused(tmp_path, capsys):
    way = tmp_path / "far.csv"
    way.write_text("x,y,z\n5,0,1\n9,0,1\n")
    assert cli.main(["track", "--path", str(way), "--out", str(tmp_path / "out")]) == 1
    assert "far:" in capsys.readouterr().err


def mistaken(overlap, gain):
    """A model whose valves' deadbands are wider by [V] and whose valves are faster by a factor."""
    valve = C180.valve
    return dataclasses.replace(
        C180,
        valve=dataclasses.replace(
            valve,
            deadband_voltage=valve.deadband_voltage + overlap,
            minimum_resistance=valve.minimum_resistance / gain**2,
        ),
    )


@pytest.mark.parametrize(("overlap", "gain"), [(0.15, 1.4), (-0.15, 1.4), (0.15, 0.6), (-0.15, 0.6)])
def test_adapting_learns_a_wrong_valve_within_two_laps(overlap, gain):
    way, model = polyline("way", [(5.6, -0.8, 1.0), (5.6, 0.8, 0.6)]), mistaken(overlap, gain)
    runs = track(way, 0.5, Scheme.COORDINATED, C180, model, noisy(C180, 0), 4, adapt=True).scores
    assert runs[0].governed_max_mm < 38.0
    assert runs[2].governed_max_mm < 18.0  # what a first trial reached
    assert runs[2].governed_rms_mm < 4.1
    assert runs[3].governed_max_mm < 18.0


def test_adapting_to_a_model_that_is_exact_changes_next_to_nothing():
    way = polyline("way", [(5.6, -0.8, 1.0), (5.6, 0.8, 0.6)])
    plain, adapting = (
        track(way, 0.5, Scheme.COORDINATED, C180, C180, noisy(C180, 0), 2, adapt=adapt).total
        for adapt in (False, True)
    )
    assert adapting.governed_max_mm < plain.governed_max_mm + 1.0
    assert adapting.governed_rms_mm < plain.governed_rms_mm + 0.3


def test_the_command_adapts_and_tells_every_lap(tmp_path, capsys):
    way = tmp_path / "way.csv"
    way.write_text("x,y,z\n5.5,0,1\n5.5,0.3,1\n")
    arguments = ["track", "--path", str(way), "--adapt", "--laps", "3", "--out", str(tmp_path / "out")]
    assert cli.main(arguments) == 0
    report = json.loads((tmp_path / "out" / "track.json").read_text())
    assert report["adapt"] is True
    assert len(report["runs"][0]["laps"]) == 3
    assert "| way, lap 3 |" in capsys.readouterr().out


def test_a_path_that_is_not_finished_leaves_the_others(tmp_path, capsys, monkeypatch):
    """With a head of 2.5 t the boom lifts nothing."""
    monkeypatch.setattr(track_command, "NAMES", ("vertical", "radial"))
    machine = tmp_path / "heavy.yaml"
    mass = "head_mass: {value: 2500, unit: kg, source: drawn}"
    machine.write_text(f"name: heavy\nbased_on: c180\nmanipulator: {{{mass}}}\n")
    out = tmp_path / "out"
    assert (
        cli.main(["track", "--path", "all", "--machine", str(machine), "--speed", "1", "--out", str(out)])
        == 1
    )
    told = capsys.readouterr()
    assert "| radial |" in told.out
    assert "vertical: after 6 times the profile's time the tip is" in told.err
    assert "m from the end: a limit of the controller holds it" in told.err
    assert {run["path"] for run in json.loads((out / "track.json").read_text())["runs"]} == {"radial"}
