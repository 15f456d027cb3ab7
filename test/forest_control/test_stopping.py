"""Claims about the stop along the path."""

import numpy as np
import pytest

from forest_control import stopping

TIMES = np.linspace(0.0, stopping.CLOSED_LOOP, 2001)


def shares(of=stopping.share):
    begun = stopping.NO_STOP._replace(duration=stopping.CLOSED_LOOP)
    return np.array([of(begun._replace(elapsed=time)) for time in TIMES.tolist()])


def test_the_velocity_falls_to_nothing_on_the_way_that_is_told():
    left = shares()
    assert (left[0], left[-1]) == (1.0, 0.0)
    assert np.all(np.diff(left) < 0.0)
    assert left.mean() == pytest.approx(4.0 / 9.0, abs=1e-3)


def test_the_deceleration_is_the_one_that_is_told_and_vanishes_at_both_ends():
    braking = -np.gradient(shares(), TIMES) * stopping.CLOSED_LOOP
    assert braking.max() == pytest.approx(1.63, abs=5e-3)
    assert max(braking[0], braking[-1]) < 0.01


def test_the_reference_goes_by_what_was_commanded_a_lag_ago():
    lag = round(stopping.LAG / (TIMES[1] - TIMES[0]))
    late = shares(stopping.share_late)
    np.testing.assert_allclose(late[lag:], shares()[:-lag], atol=2e-3)
    assert np.all(late[: lag - 1] == 1.0)


def test_a_joint_that_would_turn_round_is_not_commanded():
    assert stopping.onwards((0.1, -0.02, 1e-9), (0.05, 0.01, 0.0)) == (0.1, 0.0, 0.0)
