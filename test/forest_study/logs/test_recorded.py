"""A person's run from a bag: the figures of a simulated trial come back from its topics."""

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_bag.read.timeseries import Series, bag_of
from forest_control.operator.levers import axes_from_levers
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_study.cli import main
from forest_study.log_work import measures, trial
from forest_study.log_work.person import read_person
from forest_study.log_work.work import LOOK_TIME
from forest_study.logs.recorded import recorded
from forest_study.results import StudyError

MACHINE = load_machine("forwarder")


@pytest.fixture(scope="module")
def done():
    return trial.work(MACHINE, "tip", read_person("expert"), 0.0, 0)


def _bag(work, acts=8):
    """Return what the station would have recorded of a trial, up to so many acts."""
    changes = 1 + np.flatnonzero(np.diff(work.loaded) != 0.0)
    rows = len(work.loaded) if acts == 8 else changes[acts]
    stamps = (1e9 * (5.0 + LOOK_TIME * np.arange(rows))).astype(np.int64)

    def series(topic, values, labels):
        table = np.asarray(values, dtype=np.float64)[:rows]
        return topic, Series(stamps, stamps, table, labels, ("1",) * len(labels), 0)

    rest = np.zeros(len(work.loaded))
    load = np.column_stack([work.loaded * work.site.log_mass, rest])
    power = np.column_stack([work.engine / LOOK_TIME, rest + 1.0, rest])
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
    found, expected = measures.figures(run.work), measures.figures(done)
    before = LOOK_TIME * np.flatnonzero(done.loaded)[0]  # the first grasp begins the recorded task
    assert found["time"] == pytest.approx(expected["time"] - before, abs=1.0)
    assert found["unloading"] == pytest.approx(expected["unloading"], abs=1.0)
    assert found["contacts"] == expected["contacts"]
    assert found["reversals"] == expected["reversals"]
    assert found["energy"] == pytest.approx(expected["energy"], rel=0.05)
    assert found["tip_over"] == pytest.approx(expected["tip_over"], abs=1e-6)
    assert max(run.misses) < 3.0 * done.site.near


def test_half_a_task_is_told_with_what_is_missing(done):
    with pytest.raises(StudyError, match="3 times a log was grasped or dropped; allowed: 8"):
        recorded(_bag(done, acts=3), MACHINE)


@pytest.mark.parametrize(
    "arguments", [["--operator", "live"], ["--bag", "x"], ["--operator", "expert", "live"]]
)
def test_live_and_a_bag_belong_together(tmp_path, capsys, arguments):
    assert main(["logs", *arguments, "--out", str(tmp_path / "out")]) == 1
    assert "allowed: --operator live --bag BAG" in capsys.readouterr().err


def test_a_bag_that_is_not_there_is_told(tmp_path, capsys):
    arguments = ["logs", "--operator", "live", "--bag", str(tmp_path / "no"), "--out", str(tmp_path / "out")]
    assert main(arguments) == 1
    assert str(tmp_path / "no") in capsys.readouterr().err
