"""Claims about deadlines: a late machine catches up, and leaves out what is too late."""

import pytest

from forest_sim.live.deadlines import CATCH_UP, Deadlines

PERIOD = 5_000_000


def test_on_time_one_period_is_due_and_nothing_is_missed():
    deadlines = Deadlines(0, PERIOD)
    assert deadlines.wait(0) == pytest.approx(0.005)
    assert deadlines.due(PERIOD - 1) == (0, 0)
    assert deadlines.due(PERIOD) == (1, 0)
    assert deadlines.missed == 0
    assert deadlines.wait(PERIOD) == pytest.approx(0.005)


def test_a_late_machine_makes_up_for_every_period():
    deadlines = Deadlines(0, PERIOD)
    assert deadlines.due(4 * PERIOD) == (4, 0)
    assert deadlines.missed == 3
    assert deadlines.wait(4 * PERIOD) == pytest.approx(0.005)
    assert deadlines.wait(9 * PERIOD) == 0.0


def test_what_is_too_late_is_left_out_and_counted():
    deadlines = Deadlines(0, PERIOD)
    assert deadlines.due((CATCH_UP + 7) * PERIOD) == (CATCH_UP, 7)
    assert deadlines.missed == CATCH_UP + 6
    assert deadlines.due((CATCH_UP + 8) * PERIOD) == (1, 0)
