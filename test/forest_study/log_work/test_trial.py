"""The task done in the closed loop, once: what is told agrees with the machine."""

import numpy as np
import pytest
from expert_trial import expert_trial

from forest_description.machine import load_machine
from forest_study.log_work import trial, trial_measures
from forest_study.log_work.crane import Crane
from forest_study.log_work.person import read_person
from forest_study.log_work.site import site_of
from forest_study.log_work.task import start
from forest_study.results import StudyError

pytest.importorskip("llvmlite")
MACHINE = load_machine("forwarder")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    return expert_trial(tmp_path_factory)


def test_both_logs_go_into_the_bunk_and_back(done):
    grasps = np.flatnonzero(np.diff(done.loaded) > 0.0)
    drops = np.flatnonzero(np.diff(done.loaded) < 0.0)
    assert len(grasps) == len(drops) == 4
    inside = [done.tip[k, 0] > 3.5 and abs(done.tip[k, 1]) < 1.0 for k in (*grasps, *drops)]
    assert inside == [False, False, True, True, True, True, False, False]


def test_the_figures_add_up(done):
    told = trial_measures.figures(done)
    assert told["time"] == pytest.approx(told["loading"] + told["within"] + told["unloading"])
    assert told["time"] == pytest.approx(told["up"] + told["across"] + told["down"] + told["grapple"])
    assert 1.0 < told["path_ratio"] < 2.0
    assert 0.0 < told["tip_over"] < 1.0
    assert told["energy"] == pytest.approx(1e-3 * done.engine.sum())


def test_the_engines_work_is_that_of_the_plant_that_was_driven():
    site = site_of(MACHINE)
    x, y, z = start(site)
    crane = Crane(MACHINE, "tip", (x, y, z + site.hang), 1.0, 0.0, 0)
    while not crane.over:
        crane.look((0.0, 0.4, 0.0))
    work = crane.engine_work()
    assert len(work) == len(crane.tips()) == 50
    lifted = crane.tips()[-1, 2] - crane.tips()[0, 2]
    assert lifted > 0.1
    head = MACHINE.manipulator.head_mass * MACHINE.manipulator.gravity * lifted
    assert work.sum() > head


def test_a_late_link_delays_levers_and_sight_by_half_each():
    site = site_of(MACHINE)
    x, y, z = start(site)
    crane = Crane(MACHINE, "joint", (x, y, z + site.hang), 2.0, 0.4, 0)
    seen = [crane.look((0.0, 0.5, 0.0)) for _ in range(40)]
    assert np.flatnonzero(crane.said()[:, 1])[0] == 10
    true = crane.tips()
    np.testing.assert_array_equal([one.tip for one in seen[20:30]], true[10:20])


def test_a_task_that_is_not_done_says_where_it_ended(monkeypatch):
    monkeypatch.setattr(trial, "LONGEST", 3.0)
    with pytest.raises(StudyError, match="not done in 3 s: it ended in carry 1"):
        trial.work(MACHINE, "tip", read_person("expert"), 0.0, 0)


def test_reversals_and_axes_count_deflections_and_not_play():
    lever = np.array([0.0, 0.5, 0.02, 0.4, -0.3, -0.01, -0.2, 0.6])
    assert trial_measures.reversals(lever) == 2
    both = np.column_stack([lever, np.full(8, 0.3), np.zeros(8)])
    assert trial_measures.axes_at_once(both) == pytest.approx(13 / 8)


def test_a_crane_that_its_guard_stops_ends_the_trial(monkeypatch):
    monkeypatch.setattr(Crane, "stopped", property(lambda crane: crane.time > 0.5))
    with pytest.raises(StudyError, match="guard stopped the crane: it ended in carry 1"):
        trial.work(MACHINE, "tip", read_person("expert"), 0.0, 0)


def test_the_guard_that_disarms_the_levers_is_seen():
    site = site_of(MACHINE)
    x, y, z = start(site)
    crane = Crane(MACHINE, "tip", (x, y, z + site.hang), 1.0, 0.0, 0)
    crane.look((0.0, 0.0, 0.0))
    assert not crane.stopped
    crane._session.levers[:, 3] = 0.0  # the deadman is let go
    crane.look((0.0, 0.0, 0.0))
    assert crane.stopped
