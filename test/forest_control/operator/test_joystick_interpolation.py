"""Claims about levers between a joystick's samples: even, however unevenly these come, and soon there."""

import math
from itertools import pairwise

import numpy as np
import pytest

from forest_control.operator.joystick_interpolation import (
    CENTRED,
    DELAY,
    LONGEST_LINE,
    InterpolatedLevers,
    Knot,
    between,
    interpolated,
)
from forest_control.operator.levers import REST, Levers

DT = 0.005


def wave(time):
    """Levers of a hand that moves at 1 Hz."""
    return Levers(math.sin(2.0 * math.pi * time), 0.5 * math.cos(2.0 * math.pi * time), 0.0)


def followed(hand, said, seconds, late=lambda _k: 0.0):
    """Swing lever [N] of every step; `said`: times of the joystick's samples; `late`: states, by [s]."""
    hold, swing = CENTRED, []
    for k in range(round(seconds / DT)):
        now = k * DT + late(k)
        heard = max((time for time in said if time <= now), default=said[0])
        hold = interpolated(hold, hand(heard), heard, now, DT)
        swing.append(hold.levers.swing)
    return np.array(swing)


def test_a_joystick_that_speaks_for_every_step_is_followed_exactly():
    said = [k * DT for k in range(100)]
    assert np.array_equal(followed(wave, said, 0.5), [wave(time).swing for time in said])


@pytest.mark.parametrize("period", [0.01, 0.02, 0.05])
def test_a_slower_one_is_followed_two_periods_later_on_straight_lines(period):
    said = np.arange(0.0, 2.0, period)
    swing = followed(wave, said, 2.0)
    asked = [wave(k * DT - DELAY * period).swing for k in range(len(swing))]
    assert np.abs(swing - asked)[150:].max() < 1.1 * 0.5 * (math.pi * period) ** 2  # a chord's sagitta


def test_uneven_samples_and_late_states_leave_the_levers_even():
    rng = np.random.default_rng(3)
    said = np.sort(0.01 * np.arange(300) + rng.exponential(0.002, 300))
    delays = rng.exponential(0.002, 600)
    steps = np.diff(followed(wave, said, 3.0, lambda k: delays[k]))[100:]
    even = 2.0 * math.pi * DT  # the greatest step of an even hand
    assert np.abs(steps).max() < 1.15 * even
    assert np.abs(np.diff(steps)).max() < 0.25 * even
    held = np.diff([wave(max(said[said <= k * DT + delays[k]])).swing for k in range(100, 600)])
    assert np.abs(np.diff(held)).max() > even  # what a held sample would do


def test_a_sample_that_is_late_by_a_period_does_not_halt_the_levers():
    said = [0.01 * k for k in range(100) if k != 50]
    steps = np.diff(followed(lambda time: Levers(time, 0.0, 0.0), said, 0.9))
    assert steps[60:].min() > 0.9 * DT


def test_after_a_pause_a_lever_does_not_creep():
    hand = lambda time: Levers(1.0, 0.0, 0.0) if time > 0.0 else REST  # noqa: E731
    swing = followed(hand, [0.0, 3.0], 3.0 + DELAY * LONGEST_LINE + 2.0 * DT)
    assert swing[round(3.0 / DT)] < 0.1
    assert swing[-1] == 1.0


def test_a_lever_that_is_let_go_is_at_rest_two_periods_later():
    hand = lambda time: Levers(1.0, 0.0, 0.0) if time < 0.5 else REST  # noqa: E731
    swing = followed(hand, np.arange(0.0, 1.0, 0.01), 1.0)
    assert swing[99] > 0.9
    assert swing[round(0.52 / DT) + 1] < 1e-6
    assert all(after <= before for before, after in pairwise(swing[90:]))


def test_levers_that_are_not_believed_any_more_count_at_once_in_what_comes():
    hold = CENTRED
    for k in range(100):
        hold = interpolated(hold, Levers(1.0, 0.0, 0.0), 0.01 * (k // 2), DT * k, DT)
    for k in range(100, 110):
        hold = interpolated(hold, REST, 0.49, DT * k, DT)
    assert hold.levers == REST


KNOTS = tuple(Knot(0.02 * k, Levers(0.1 * k, 0.01 * k * k, 0.5 - 0.1 * k)) for k in range(6))
NEWEST = Levers(0.7, -0.2, 0.3)


def stepped(sent=0.1, now=0.14, at=0.095, levers=NEWEST, dt=DT):
    """A step of a joystick of 50 Hz, whose last sample was sent at 0.1 s; t has been `at`."""
    levers = levers if sent > 0.1 else KNOTS[5].levers
    return interpolated(InterpolatedLevers(REST, KNOTS, 0.02, at), levers, sent, now, dt)


def test_a_new_sample_takes_the_oldest_one_s_place_and_a_fifth_of_its_gap_the_period_s():
    assert stepped(sent=0.13).knots == (*KNOTS[1:], Knot(0.13, NEWEST))
    assert stepped(sent=0.13).period == pytest.approx(0.02 + 0.2 * (0.03 - 0.02))
    assert stepped().period == 0.02


def test_after_a_pause_the_last_sample_has_held_until_a_tenth_of_a_second_before_the_new_one():
    found = stepped(sent=0.25, now=0.25)
    assert [knot.time for knot in found.knots] == pytest.approx([0.15] * 5 + [0.25])
    assert [knot.levers for knot in found.knots] == [KNOTS[5].levers] * 5 + [NEWEST]
    assert found.period == pytest.approx(0.02 + 0.2 * (0.1 - 0.02))


@pytest.mark.parametrize("off", [0.02, -0.02, 0.29, -0.29])
def test_the_time_of_reading_follows_the_clock_within_a_fifth_of_a_second(off):
    assert stepped(at=0.1 - DT - off).at == pytest.approx(0.1 - off + DT / 0.2 * off)


@pytest.mark.parametrize("off", [0.31, -0.31])
def test_a_time_of_reading_that_is_far_astray_is_set_anew(off):
    assert stepped(at=0.1 - DT - off).at == pytest.approx(0.1)


def test_before_the_oldest_sample_the_levers_stand_and_between_two_each_is_on_its_line():
    assert stepped(now=0.0, at=-0.1).levers == KNOTS[0].levers
    assert stepped(now=0.2, at=0.2).levers == KNOTS[5].levers
    assert between(Levers(0.0, 1.0, 2.0), Levers(1.0, 3.0, 6.0), 0.25) == Levers(0.25, 1.5, 3.0)
