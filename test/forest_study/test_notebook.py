"""The closed loop as a notebook has it: arrays with names and units, own levers, refusals of one sentence."""

import dataclasses

import numpy as np
import pytest

from forest_control.taught.tip_path import PathError
from forest_description.types import AXES
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.model_mismatch import Ranges
from forest_study.notebook import QUANTITIES, closed_loop, machine

LINE = [(5.6, 0.0, 0.5), (6.0, 0.0, 0.5)]


@pytest.fixture(scope="module")
def loop():
    return closed_loop(machine("c180_hoses"))


@pytest.fixture(scope="module")
def trace(loop):
    return loop.follow(LINE, speed=0.4, seed=1)


def test_every_quantity_has_a_row_a_period_and_its_columns(trace):
    rows = len(trace["time"])
    assert trace["time"] == pytest.approx(PERIOD * np.arange(rows))
    for name, (_, columns, _) in QUANTITIES.items():
        assert trace[name].shape == ((rows, len(columns)) if columns else (rows,))
    table = trace.table()
    assert table["tip_x [m]"] == pytest.approx(trace["tip"][:, 0])
    assert len(table) == sum(max(1, len(columns)) for _, columns, _ in QUANTITIES.values())


def test_a_path_is_followed_and_scored(trace):
    assert trace["tip"][0] == pytest.approx(LINE[0], abs=1e-6)
    assert trace["tip"][-1] == pytest.approx(LINE[-1], abs=0.005)
    assert 0.0 < trace.score.cross_track_rms_mm < 3.0
    assert abs(trace["reference"] - trace["tip"]).max() < 0.02
    assert trace["reference"][-1] - trace["tip"][0] == pytest.approx([0.4, 0.0, 0.0], abs=0.005)


def test_a_seed_is_a_noise_and_repeats(loop, trace):
    again, other = (loop.follow(LINE, speed=0.4, seed=seed) for seed in (1, 2))
    assert np.array_equal(again["pressures"], trace["pressures"])
    assert not np.array_equal(other["pressures"][:400], trace["pressures"][:400])


def test_a_mismatch_is_drawn_by_the_seed():
    exact, drawn = closed_loop("c180_hoses"), closed_loop("c180_hoses", mismatch=Ranges())

    def holding(loop, seed):
        return loop.drive(np.zeros((4, 3)), seed=seed)["pressures"][0, 5]

    noise = abs(holding(exact, 1) - holding(exact, 2))
    assert abs(holding(drawn, 1) - holding(drawn, 2)) > 5.0 * noise


def test_levers_of_a_function_are_asked_with_what_it_sees_and_act(loop):
    asked = []

    def levers(now):
        asked.append(now)
        return 0.0, 2.0 if now.time < 0.5 else 0.0, 0.0

    start = (6.0, 0.0, 0.5)
    trace = loop.drive(levers, seconds=1.0, start=start)
    assert [now.time for now in asked] == pytest.approx(trace["time"])
    assert asked[0].tip == pytest.approx(start)
    assert [now.tip for now in asked[1:]] == [tuple(row) for row in trace["tip"][:-1].tolist()]
    assert trace["levers"].max() == 1.0  # beyond 1 counts as 1
    assert trace["tip"][-1, 2] - start[2] > 0.1
    table = loop.drive(trace["levers"], start=start)
    assert np.array_equal(table["tip"], trace["tip"])


def test_another_believed_machine_and_other_gains_tell(loop, trace):
    believed = closed_loop("c180_hoses", model=machine("c180_thesis")).follow(LINE, speed=0.4, seed=1)
    weak = closed_loop("c180_hoses", feedback_gain=(0.1, 0.1, 0.1)).follow(LINE, speed=0.4, seed=1)
    assert believed.score.governed_rms_mm > trace.score.governed_rms_mm
    assert weak.score.governed_rms_mm != trace.score.governed_rms_mm


def test_a_picture_is_drawn_with_units(trace, loop, tmp_path):
    import matplotlib as mpl

    mpl.use("Agg")
    axes = trace.plot(tmp_path / "run.png")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert [ax.get_xlabel() for ax in axes] == ["x, m", "x, m", "time, s", "time, s"]
    assert [line.get_label() for line in axes[3].lines] == list(AXES)
    assert [line.get_label() for line in axes[2].lines][1:] == ["cross-track", "wish"]
    driven = loop.drive(np.zeros((10, 3))).plot()
    assert len(driven[2].lines) == 1
    mpl.pyplot.close("all")


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (lambda loop: closed_loop("c180", "fast"), "scheme 'fast'; allowed: joint, ik_velocity"),
        (lambda loop: closed_loop("c180", gain=3.0), "parameter 'gain' is unknown; allowed: "),
        (lambda loop: closed_loop("c180", "joint").follow(LINE), "the scheme joint follows no path"),
        (lambda loop: loop.follow([(0.0, 1.0)]), r"waypoints have shape \(1, 2\); allowed: rows of three"),
        (lambda loop: closed_loop("c180", mode="position").follow(LINE), "the mode position follows no path"),
        (lambda loop: closed_loop("c180", mismatch=Ranges(head_mass=-2.0)), r"head_mass=-2; allowed: 1 \.\."),
        (lambda loop: loop.follow(LINE, speed=0.0), r"speed 0\.0; allowed: above 0"),
        (lambda loop: loop.follow(LINE, speed=np.nan), "speed nan; allowed: above 0"),
        (lambda loop: loop.drive(lambda now: (0.0, 0.0, 0.0), -1.0), r"seconds -1\.0; allowed: above 0"),
        (lambda loop: loop.drive([0.0, 0.0]), r"levers have shape \(2,\); allowed: \[N, 3\]"),
        (lambda loop: loop.drive(lambda now: (0.0, 0.0, 0.0)), "needs seconds"),
        (lambda loop: loop.drive(lambda now: (0.0, np.nan, 0.0), 1.0), "at 0 s the levers are .*allowed"),
        (lambda loop: loop.drive(lambda now: "up", 1.0), "at 0 s the levers are 'up'; allowed: three finite"),
        (lambda loop: loop.drive(lambda now: (1j, 0.0, 0.0), 1.0), "at 0 s the levers are .*allowed"),
        (lambda loop: loop.drive("up", 1.0), r"levers are no table of numbers; allowed: \[N, 3\]"),
        (lambda loop: loop.drive(lambda now: (0.0, 0.0, 0.0), 1e9), "seconds 1000000000.0; allowed: above 0"),
        (lambda loop: loop.drive(lambda now: (0.0, 0.0, 0.0), "1"), "seconds '1'; allowed: above 0"),
        (lambda loop: loop.drive(np.zeros((4, 3)), start=(5.0, 0.0)), r"start \(5.0, 0.0\); allowed: three"),
        (lambda loop: loop.drive(np.zeros((4, 3)), start=(5.0, 0.0, 1.0, 7.0)), "start .*; allowed: three"),
        (lambda loop: loop.drive(np.zeros((4, 3)), seed=-1), r"seed -1; allowed: a whole number, 0 \.\."),
        (lambda loop: loop.follow(LINE, seed=1.5), r"seed 1\.5; allowed: a whole number"),
        (lambda loop: loop.follow(LINE, laps=0), r"laps 0; allowed: a whole number, 1 \.\. 1000"),
        (lambda loop: loop.follow(LINE, laps=1.5), r"laps 1\.5; allowed: a whole number"),
        (lambda loop: loop.follow(LINE, speed="0.5"), "speed '0.5'; allowed: a number above 0"),
        (lambda loop: loop.follow([(5.0, 0.0, 1.0), (5.0, 0.0)]), "waypoints are no table of numbers"),
        (lambda loop: closed_loop("c180", adapt="no"), "adapt 'no'; allowed: True, False"),
        (lambda loop: closed_loop("c180", mismatch={"head_mass": 2.0}), "mismatch .*; allowed: Ranges of"),
        (lambda loop: closed_loop("c180", mismatch=Ranges(head_mass="2")), "mismatch .*; allowed: Ranges of"),
    ],
)
def test_what_cannot_be_is_told_in_a_sentence(loop, wrong, told):
    with pytest.raises(ValueError, match=told):
        wrong(loop)


def test_a_load_chart_without_pressures_is_named_where_a_path_does_not_end():
    forwarder = machine("forwarder")
    blind = dataclasses.replace(forwarder, sensors=dataclasses.replace(forwarder.sensors, pressure=None))
    with pytest.raises(PathError, match="the load chart allows only motions that unload"):
        closed_loop(blind).follow([(5.0, 0.0, 0.5), (5.3, 0.0, 0.5)])


def test_an_unknown_array_names_those_there_are(trace):
    with pytest.raises(KeyError, match="'speed'; allowed: time, levers, angles, tip"):
        trace["speed"]
