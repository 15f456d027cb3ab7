from itertools import pairwise

import pytest

from forest_control.lever_hold import CENTRED, LONGEST, advanced
from forest_control.levers import REST, Levers

DT = 0.005


def followed(samples, period, steps):
    """Levers of every step, a sample heard every so many steps."""
    hold, levers = CENTRED, []
    for sample in samples:
        for _ in range(steps):
            hold = advanced(hold, sample, period, DT)
            levers.append(hold.levers)
    return levers


def test_a_joystick_that_speaks_in_every_step_is_followed_exactly():
    samples = [Levers(0.1, 0.2, 0.3), Levers(0.7, -0.2, 1.0), REST]
    assert followed(samples, DT, 1) == samples


def test_between_slower_samples_the_levers_go_straight_and_arrive():
    rising = [Levers(0.1 * k, -0.1 * k, 0.0) for k in range(1, 11)]
    levers = followed([*rising, rising[-1]], 0.02, 4)
    steps = [after.swing - before.swing for before, after in pairwise(levers[12:40])]
    assert steps == pytest.approx([0.025] * len(steps), rel=0.15)
    assert levers[-1] == rising[-1]


def test_a_sample_that_is_late_does_not_halt_the_levers():
    hold = CENTRED
    for k in (1, 2, 3):
        hold = advanced(
            advanced(hold, Levers(0.1 * k, 0.0, 0.0), 0.01, DT), Levers(0.1 * k, 0.0, 0.0), 0.01, DT
        )
    late = advanced(hold, hold.target, 0.01, DT)
    assert late.levers.swing > hold.levers.swing + 0.02


def test_after_a_pause_a_lever_does_not_creep():
    levers = followed([Levers(1.0, 0.0, 0.0)], 3.0, round(2.0 * LONGEST / DT))
    assert levers[-1].swing == 1.0
