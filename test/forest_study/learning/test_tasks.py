"""Drawn tasks lie within reach; rewards are what the module's table says."""

import math

import numpy as np
import pytest

from forest_description.derived.limits import pose_at
from forest_description.machine import load_machine
from forest_study.learning import tasks
from forest_study.learning.tasks import PathTask, ReachTask


@pytest.mark.parametrize("name", ["c180", "forwarder", "loader"])
def test_what_is_drawn_is_within_reach_of_any_machine(name):
    machine, chance = load_machine(name), np.random.default_rng(1)
    path, reach = PathTask(machine, chance), ReachTask(machine, chance)
    places = [path.ideal(0.1 * k) for k in range(200)] + [reach.start, *reach.targets]
    for place in places:
        pose_at(place, machine)  # raises where it is not


def test_the_ideal_point_rests_goes_at_its_speed_and_ends():
    task = PathTask(load_machine("c180"), np.random.default_rng(2))
    at = np.array([task.ideal(0.01 * k) for k in range(4000)])
    speed = np.linalg.norm(np.diff(at, axis=0), axis=1) / 0.01
    assert speed[:99].max() == 0.0
    assert speed.max() == pytest.approx(0.4, abs=1e-3)
    assert at[-1] == pytest.approx(task.path.at(task.path.length))


def test_the_path_is_seen_from_the_tip_with_its_velocity_and_future():
    task, tip = PathTask(load_machine("c180"), np.random.default_rng(2)), (5.0, 0.0, 1.0)
    here, velocity, *later = np.array(task.seen(3.0, tip)).reshape(-1, 3)
    assert here + tip == pytest.approx(task.ideal(3.0))
    assert velocity == pytest.approx(np.subtract(task.ideal(3.001), task.ideal(3.0)) / 0.001, abs=0.02)
    assert [tuple(way + tip) for way in later] == [
        pytest.approx(task.ideal(3.0 + ahead)) for ahead in (0.25, 0.5, 1.0)
    ]


def test_a_path_rewards_minus_the_distance():
    task = PathTask(load_machine("c180"), np.random.default_rng(2))
    x, y, z = task.ideal(5.0)
    assert task.judged(5.0, (x, y, z + 0.2))[0] == pytest.approx(-0.2)


def test_a_target_is_reached_after_its_time_within_its_distance_and_the_next_one_counts():
    task = ReachTask(load_machine("c180"), np.random.default_rng(2))
    first, second = task.targets[:2]
    beside = first[0] + 0.029, *first[1:]
    rewards = [task.judged(0.02 * k, beside)[0] for k in range(15)]
    assert task.reached == 0
    rewards.append(task.judged(0.3, beside)[0])
    assert task.reached == 1
    assert sum(rewards) == pytest.approx(1.0 + math.dist(task.start, first) - 0.029)
    assert task.judged(0.4, beside)[0] == 0.0
    assert task.seen(0.4, first) == pytest.approx(np.subtract(second, first))


def test_who_leaves_a_target_starts_anew():
    task = ReachTask(load_machine("c180"), np.random.default_rng(2))
    first = task.targets[0]
    for k in range(100):
        task.judged(0.02 * k, first if k % 10 else (first[0] + 0.031, *first[1:]))
    assert task.reached == 0


def test_coming_nearer_and_going_away_adds_up_to_nothing():
    task = ReachTask(load_machine("c180"), np.random.default_rng(2))
    between = [0.5 * (a + b) for a, b in zip(task.start, task.targets[0], strict=True)]
    assert task.judged(0.0, between)[0] > 0.1
    assert task.judged(0.1, task.start)[0] + task.judged(0.2, between)[0] == pytest.approx(0.0)


def test_a_machine_that_reaches_nothing_is_told(monkeypatch):
    monkeypatch.setattr(tasks, "REACH", (1.1, 1.2))
    with pytest.raises(tasks.PathError, match="c180: none of 1000 drawn places is within reach"):
        ReachTask(load_machine("c180"), np.random.default_rng(0))
