"""A person's run from a bag: the figures of a simulated trial come back from its topics."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from expert_trial import expert_trial

from forest_bag.read.timeseries import Series, bag_of
from forest_control.operator.levers import axes_from_levers
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_study.cli import main
from forest_study.log_work import trial_measures
from forest_study.log_work.task import ACROSS, DOWN, HOLD, UP
from forest_study.log_work.work import LOOK_TIME
from forest_study.logs.recorded_logs import recorded
from forest_study.results import StudyError

MACHINE = load_machine("forwarder")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    return expert_trial(tmp_path_factory)


FLOW = 2e-3  # [m^3/s]


def _bag(work, acts=8, late=0):
    """Return what the station would have recorded of a trial: so many acts, levers from some row on."""
    changes = 1 + np.flatnonzero(np.diff(work.loaded) != 0.0)
    rows = len(work.loaded) if acts == 8 else changes[acts]
    stamps = (1e9 * (5.0 + LOOK_TIME * np.arange(rows))).astype(np.int64)

    def series(topic, values, labels):
        table, first = np.asarray(values, dtype=np.float64)[:rows], late if topic is topics.JOY else 0
        return topic, Series(stamps[first:], stamps[first:], table[first:], labels, ("1",) * len(labels), 0)

    rest = np.zeros(len(work.loaded))
    load = np.column_stack([work.loaded * work.site.log_mass, rest])
    power = np.column_stack([work.engine / LOOK_TIME / FLOW, rest + FLOW, rest])
    joy = [axes_from_levers(levers) for levers in work.levers.tolist()]
    return bag_of(
        dict(
            [
                series(topics.GROUND_TRUTH_LOAD, load, ("mass", "length")),
                series(topics.GROUND_TRUTH_JOINT_STATES, work.angles, topics.JOINTS),
                series(topics.GROUND_TRUTH_HEAD, work.head, topics.HEAD_JOINTS),
                series(topics.JOY, joy, topics.JOY_AXES),
                series(topics.SUPPLY, power, ("pressure", "flow", "saturation")),
            ]
        )
    )


def test_a_recorded_run_has_the_figures_of_the_trial(done):
    run = recorded(_bag(done), MACHINE)
    found, expected = trial_measures.figures(run.work), trial_measures.figures(done)
    before = LOOK_TIME * np.flatnonzero(done.loaded)[0]  # the first grasp begins the recorded task
    assert found["time"] == pytest.approx(expected["time"] - before, abs=1.0)
    assert found["unloading"] == pytest.approx(expected["unloading"], abs=1.0)
    assert found["contacts"] == expected["contacts"]
    assert found["reversals"] == expected["reversals"]
    assert found["energy"] == pytest.approx(expected["energy"], rel=0.05)
    assert found["tip_over"] == pytest.approx(expected["tip_over"], abs=1e-6)
    assert max(run.misses) < 3.0 * done.site.near


def _of_the_task(done):
    """Return the trial's rows from the first grasp to a second after the last act."""
    held = np.flatnonzero(done.loaded)
    return slice(held[0], held[-1] + 2 + round(1.0 / LOOK_TIME))


def test_levers_and_parts_are_those_of_their_time(done):
    run, rows = recorded(_bag(done), MACHINE), _of_the_task(done)
    levers, parts = done.levers[rows], np.array(done.part)[rows]
    n = min(len(levers), len(run.work.levers))
    assert run.work.levers[:n] == pytest.approx(levers[:n], abs=1e-6)
    alike = np.array(run.work.part)[:n] == parts[:n]
    for part in (UP, ACROSS, DOWN):
        assert np.mean(alike[parts[:n] == part]) > 0.5, part
    assert np.mean(alike[parts[:n] != HOLD]) > 0.8


def test_before_the_first_word_of_the_levers_they_are_at_rest(done):
    first, late = np.flatnonzero(done.loaded)[0], 40
    levers = recorded(_bag(done, late=first + late), MACHINE).work.levers
    assert not levers[: late - 1].any()
    assert levers[late + 1 :].any()


def test_a_log_that_hung_there_before_is_no_part_of_the_task(done):
    loaded = done.loaded.copy()
    loaded[:5] = 1.0
    again = recorded(_bag(done._replace(loaded=loaded)), MACHINE)
    assert again.work.angles.tolist() == recorded(_bag(done), MACHINE).work.angles.tolist()


def test_half_a_task_is_told_with_what_is_missing(done):
    with pytest.raises(StudyError, match="3 times a log was grasped or dropped; allowed: 8"):
        recorded(_bag(done, acts=3), MACHINE)


@pytest.mark.parametrize(
    "arguments", [["--operator", "live"], ["--bag", "x"], ["--operator", "expert", "live"]]
)
def test_live_and_a_bag_belong_together(tmp_path, capsys, arguments):
    assert main(["logs", *arguments, "--out", str(tmp_path / "out")]) == 1
    assert "allowed: --operator live --bag BAG" in capsys.readouterr().err


def test_a_bag_of_something_else_is_told_with_the_topic_that_it_lacks(tmp_path, capsys):
    bag = Path(__file__).parents[3] / "bags/coordinated"
    arguments = ["logs", "--operator", "live", "--bag", str(bag), "--out", str(tmp_path / "out")]
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert f"logs: {bag}: " in error
    assert "ground_truth/load" in error


def test_a_bag_that_is_not_there_is_told(tmp_path, capsys):
    arguments = ["logs", "--operator", "live", "--bag", str(tmp_path / "no"), "--out", str(tmp_path / "out")]
    assert main(arguments) == 1
    assert str(tmp_path / "no") in capsys.readouterr().err
