"""What a hand asked of the tip: a session in memory, each measure against its closed form."""

import numpy as np
import pytest

from forest_bag.read.timeseries import Series, bag_of
from forest_control.operator.levers import Levers, axes_from_levers
from forest_msgs_py.interfaces import topics
from forest_study.demo.hand_measures import hand_measures, profile_of, wished

STEP_NS, ROWS = 5_000_000, 601
TIME = 0.005 * np.arange(ROWS)
STAMPS = STEP_NS * np.arange(1, ROWS + 1)
EXACT = {"deadzone": [0.0] * 3, "expo": [0.0] * 3, "tip_speed": 0.4}
START = np.array([5.5, 0.0, 1.0])


def series(values, labels, stamps=STAMPS):
    values = np.asarray(values, dtype=float)
    return Series(stamps, stamps, values, tuple(labels), ("",) * len(labels), 0)


def session(levers, command, tip, factor=1.0, armed=None, swing=0.0):
    """A bag: levers [N, 3], governed velocity [N, 3] m/s, true tip [N, 3] m."""
    axes = [axes_from_levers(Levers(*row)) for row in np.broadcast_to(levers, (ROWS, 3)).tolist()]
    status = np.zeros((ROWS, 5))
    status[:, 0], status[:, 2] = factor, np.ones(ROWS) if armed is None else armed
    joints = np.zeros((ROWS, 3))
    joints[:, 0] = swing
    pose = np.hstack([np.broadcast_to(tip, (ROWS, 3)), np.zeros((ROWS, 4))])
    return bag_of(
        {
            topics.JOY: series(axes, topics.JOY.labels),
            topics.JOINT_STATES: series(joints, topics.JOINTS),
            topics.CONTROLLER_STATUS: series(status, topics.CONTROLLER_STATUS.labels),
            topics.TIP_TWIST_COMMAND: series(np.broadcast_to(command, (ROWS, 3)), "xyz"),
            topics.GROUND_TRUTH_TIP_POSE: series(pose, topics.GROUND_TRUTH_TIP_POSE.labels),
        }
    )


def along_x(speed, time=TIME):
    return START + np.outer(time, [speed, 0.0, 0.0])


def test_a_tip_that_does_as_the_levers_say_is_nowhere_off():
    bag = session((0.0, 0.0, 0.5), (0.2, 0.0, 0.0), along_x(0.2))
    found = hand_measures(bag, profile_of(EXACT))
    for off in (found.governed, found.cross_track, found.wish):
        assert off.max_mm < 1e-6
    assert found.time_lost_s == 0.0


def test_a_limit_that_halves_the_speed_is_unseen_by_reference_and_path_but_not_by_the_wish():
    bag = session((0.0, 0.0, 0.5), (0.1, 0.0, 0.0), along_x(0.1), factor=0.5)
    found = hand_measures(bag, profile_of(EXACT))
    assert found.governed.max_mm < 1e-6
    assert found.cross_track.max_mm < 1e-6
    assert found.wish.max_mm == pytest.approx(300.0)
    assert found.time_lost_s == pytest.approx(1.5)


def test_a_tip_that_is_moved_aside_is_off_by_every_measure():
    tip = along_x(0.2) + np.outer(TIME > 1.0, [0.0, 0.03, 0.04])
    found = hand_measures(session((0.0, 0.0, 0.5), (0.2, 0.0, 0.0), tip), profile_of(EXACT))
    for off in (found.governed, found.cross_track, found.wish):
        assert off.max_mm == pytest.approx(50.0)


def test_levers_ask_for_nothing_until_the_joystick_is_armed():
    bag = session((0.0, 0.0, 0.5), (0.0, 0.0, 0.0), START, armed=TIME >= 2.0)
    assert hand_measures(bag, profile_of(EXACT)).wish.max_mm == pytest.approx(200.0)


def test_the_profile_says_what_a_deflection_means():
    curved = {**EXACT, "deadzone": [0.2] * 3, "expo": [1.0] * 3, "axis_frame": "cylindrical"}
    bag = session((0.0, 0.0, 0.6), (0.0, 0.0, 0.0), START, swing=np.pi / 2.0)
    way = wished(bag, profile_of(curved))[-1] - START
    assert way == pytest.approx([0.0, 3.0 * 0.4 * 0.5**3, 0.0])  # outwards is y; z = (0.6 - 0.2) / 0.8


def test_position_mode_draws_no_path():
    bag = session((0.0, 0.0, 0.5), (0.2, 0.0, 0.0), along_x(0.2))
    found = hand_measures(bag, profile_of({**EXACT, "mode": "position"}))
    assert (found.cross_track, found.wish) == (None, None)
    assert found.governed.max_mm < 1e-6


def test_taught_work_is_no_hand():
    bag = session((0.0, 0.0, 0.0), (0.2, 0.0, 0.0), along_x(0.2))
    played = np.zeros((ROWS, len(topics.TAUGHT_COMMAND.labels)))
    bag = bag_of(
        {
            **{t: bag.series(t) for t in (topics.JOY, topics.JOINT_STATES, topics.CONTROLLER_STATUS)},
            **{t: bag.series(t) for t in (topics.TIP_TWIST_COMMAND, topics.GROUND_TRUTH_TIP_POSE)},
            topics.TAUGHT_COMMAND: series(played, topics.TAUGHT_COMMAND.labels),
        }
    )
    assert wished(bag, profile_of(EXACT)) is None
