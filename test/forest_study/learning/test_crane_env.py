"""The Gymnasium environment: Gymnasium's own check, seeds, units of what is observed, what actions do."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from forest_description.geometry.kinematics import tip_position
from forest_study.learning import driven_crane, tasks
from forest_study.learning.crane_env import MACHINE, STEPS, CraneEnv
from forest_study.learning.policies import ours

PAIRS = [(task, actions) for task in tasks.NAMES for actions in driven_crane.NAMES]
STEP = 0.02  # [s]


def env_of(task="path", actions="tip", **more):
    return CraneEnv(task, actions, "c180_hoses", **more)


def steps(env, action, count):
    return [env.step(np.array(action, np.float32)) for _ in range(count)]


@pytest.mark.parametrize(("task", "actions"), PAIRS)
def test_gymnasiums_own_check_passes(task, actions):
    check_env(env_of(task, actions), skip_render_check=True)


def test_gymnasium_makes_it_by_name():
    name = "forest_study.learning.crane_env:ForestCrane-v0"
    env = gymnasium.make(name, task="reach", actions="voltages", machine="c180_hoses")
    observation, _ = env.reset(seed=1)
    assert observation.shape == (21,)
    assert env.observation_space.contains(observation)


@pytest.mark.parametrize("actions", driven_crane.NAMES)
def test_equal_seeds_and_actions_give_equal_bits(actions):
    runs = []
    for seed in (4, 4, 5):
        env = env_of(actions=actions, mismatch=True)
        first, _ = env.reset(seed=seed)
        runs.append(np.array([first, *(one[0] for one in steps(env, (0.1, 0.2, -0.1), 20))]))
    assert np.array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


def test_the_seed_alone_draws_task_and_noise_whatever_the_actions():
    seen = [env_of(actions=actions).reset(seed=3)[0] for actions in driven_crane.NAMES]
    assert seen[1] == pytest.approx(seen[0], abs=1e-4)
    assert seen[2] == pytest.approx(seen[0], abs=1e-4)


def test_an_episode_is_truncated_after_its_time_and_never_terminates():
    env = env_of()
    env.reset(seed=0)
    ends = [one[2:4] for one in steps(env, (0.0, 0.0, 0.0), STEPS)]
    assert ends == [(False, False)] * (STEPS - 1) + [(False, True)]


@pytest.mark.parametrize("actions", driven_crane.NAMES)
def test_without_an_episode_gymnasiums_error_asks_for_a_reset(actions):
    env = env_of(actions=actions)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(3, np.float32))
    env.reset(seed=0)
    steps(env, (0.0, 0.0, 0.0), STEPS)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(3, np.float32))
    env.reset(seed=1)
    env.step(np.zeros(3, np.float32))


def test_what_is_observed_has_its_place_and_unit():
    env = env_of("reach", "joint")
    env.reset(seed=2)
    before = env.reset(seed=2)[0]
    seen = np.array([one[0] for one in steps(env, (0.0, 0.5, 0.0), 25)])
    after, way = seen[-1], seen[-1, 1] - seen[4, 1]
    assert sum(entry.size for entry in MACHINE) == 18
    assert after[1] - before[1] == pytest.approx(0.5 * 0.25 * 25 * STEP, rel=0.4)  # rad
    assert seen[5:, 4].mean() == pytest.approx(way / (20 * STEP), rel=0.1)  # rad/s
    assert 2.0 < after[8] < 30.0  # MPa under the boom
    links = env.machine.manipulator.links
    assert after[12:15] == pytest.approx(tip_position(after[:3].tolist(), links), abs=0.02)
    assert after[15:18] == pytest.approx([0.0, 0.5, 0.0])
    assert after[18:] + after[12:15] == pytest.approx(before[18:] + before[12:15], abs=1e-4)


def test_a_tip_action_is_a_velocity_of_the_tip():
    env = env_of("reach", "tip")
    env.reset(seed=2)
    seen = [one[0] for one in steps(env, (0.0, 0.0, 0.3), 30)]
    assert seen[-1][12:15] - seen[9][12:15] == pytest.approx([0.0, 0.0, 0.3 * 20 * STEP], abs=0.02)


def test_a_voltage_is_a_share_of_the_rated_one_and_crosses_the_overlap():
    env = env_of("reach", "voltages")
    within = env.reset(seed=2)[0][0], steps(env, (0.05, 0.0, 0.0), 25)[-1][0][0]
    beyond = env.reset(seed=2)[0][0], steps(env, (0.5, 0.0, 0.0), 25)[-1][0][0]
    assert within[1] == pytest.approx(within[0], abs=1e-3)  # 0.5 V of an overlap of 1 V
    assert beyond[1] - beyond[0] > 0.05


def test_a_mismatch_is_another_machine():
    pressures = [env_of(mismatch=mismatch).reset(seed=1)[0][8] for mismatch in (False, True)]
    assert abs(pressures[1] - pressures[0]) > 0.05  # MPa under the boom


def test_noise_and_mismatch_are_drawn_by_the_seed(monkeypatch):
    task = tasks.ReachTask
    monkeypatch.setattr(tasks, "drawn", lambda _, machine, chance: task(machine, np.random.default_rng(0)))
    noise = abs(np.subtract(*(env_of("reach").reset(seed=seed)[0][6:12] for seed in (1, 2))))
    drawn = abs(np.subtract(*(env_of("reach", mismatch=True).reset(seed=seed)[0][6:12] for seed in (1, 2))))
    assert noise.max() > 1e-3
    assert drawn[2] > noise.max() + 0.05  # MPa under the boom


@pytest.mark.parametrize("action", [(0.0, 0.0), (0.0, np.nan, 0.0)])
def test_an_action_that_is_none_is_refused(action):
    env = env_of()
    env.reset(seed=0)
    with pytest.raises(ValueError, match="allowed: three finite numbers"):
        env.step(np.array(action))


@pytest.mark.parametrize(("task", "actions"), [("paths", "tip"), ("path", "valves")])
def test_unknown_tasks_and_actions_name_the_known(task, actions):
    with pytest.raises(ValueError, match=r"'(paths|valves)'; allowed: (path, reach|tip, joint, voltages)"):
        CraneEnv(task, actions)


@pytest.mark.parametrize("seed", [15, 21, 34])
def test_a_forwarder_that_is_somewhat_off_its_file_is_not_stopped(seed):
    """At slow commands an overlap that is 0.15 V narrower makes the swing twice as fast."""
    env = CraneEnv("path", "tip", "forwarder", mismatch=True)
    observation, _ = env.reset(seed=seed)
    for _ in range(200):
        observation, _, _, _, told = env.step(ours(observation))
        assert not told["stopped"]
