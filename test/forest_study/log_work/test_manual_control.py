"""ManualControl: a delay slows them, attention serves few levers, equal seeds do the same."""

import numpy as np
import pytest

from forest_study.log_work.manual_control import ManualControl
from forest_study.log_work.person import Person

EXACT = Person(precision=0.0, joint_error=0.0, boldness=1.0, axes=3.0)
LOOK = 0.02


def _reached(person, trip, seconds=12.0, crane_lag=0.15):
    """Return the ways of three integrators behind delays that are steered from (1, 0.5, -0.4) to zero."""
    manual, left, rate = ManualControl(person, 0.0, trip, LOOK, 0), np.array([1.0, 0.5, -0.4]), np.zeros(3)
    seen, ways = [left], []
    late = round((person.delay + trip) / LOOK)
    for k in range(round(seconds / LOOK)):
        levers = np.array(manual.steer(seen[max(0, k - late)], np.full(3, 0.5), k * LOOK))
        rate = rate + LOOK / crane_lag * (0.5 * levers - rate)
        left = left - LOOK * rate
        seen.append(left)
        ways.append(left)
    return np.array(ways)


@pytest.mark.parametrize("trip", [0.0, 0.3, 0.6])
def test_a_delay_slows_the_hands_and_does_not_make_them_overshoot(trip):
    way = _reached(EXACT, trip)[:, 0]
    assert way.min() > -0.05
    assert abs(way[-1]) < 0.05
    assert np.argmax(way < 0.1) > np.argmax(_reached(EXACT, max(0.0, trip - 0.3))[:, 0] < 0.1) or trip == 0.0


def test_whoever_sees_late_still_pushes_beyond_the_levers_play():
    manual = ManualControl(EXACT, 0.0, 2.0, LOOK, 0)
    for k in range(100):
        levers = manual.steer(np.array([0.02, -0.04, 0.03]), np.ones(3), k * LOOK)
        assert not levers.swing
        assert not levers.stick
    assert -0.021 < levers.boom < -0.019


@pytest.mark.parametrize(("axes", "least", "most"), [(1.0, 1.0, 1.0), (1.5, 1.2, 1.8), (3.0, 3.0, 3.0)])
def test_attention_serves_so_many_levers_at_once(axes, least, most):
    manual = ManualControl(EXACT._replace(axes=axes, hand=0.02), 0.0, 0.0, LOOK, 1)
    counts = []
    for k in range(5000):
        manual.steer(np.array([3.0, -2.0, 1.0]), np.ones(3), k * LOOK)
        counts.append(np.count_nonzero(manual._served))
    assert least <= np.mean(counts) <= most


def test_the_lever_of_the_longest_way_is_served_first():
    manual = ManualControl(EXACT._replace(axes=1.0), 0.0, 0.0, LOOK, 0)
    levers = manual.steer(np.array([0.2, -2.0, 1.0]), np.ones(3), 0.0)
    assert levers.swing == levers.stick == 0.0
    assert levers.boom < 0.0


def test_equal_seeds_do_the_same_and_others_do_not():
    def said(seed):
        manual = ManualControl(Person(), 0.3, 0.0, LOOK, seed)
        manual.new_leg()
        return [manual.steer(np.array([1.0, 0.5, 0.2]), np.ones(3), k * LOOK) for k in range(20)]

    assert said(1) == said(1) != said(2)
