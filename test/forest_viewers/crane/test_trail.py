"""The trails of tip and command."""

import pytest

from forest_viewers.crane.trail import SPAN, Trail, with_command, with_tip

DT = 0.01


def driven(command, seconds, trail=None, start=0.0):
    """Return the trail of a tip that stands at the origin while it is told to move."""
    trail = trail or Trail()
    for k in range(round(seconds / DT) + 1):
        time = start + k * DT
        trail = with_command(with_tip(trail, time, (0.0, 0.0, 0.0)), time, command)
    return trail


def test_the_commanded_trail_is_the_integral_of_the_command_from_the_tip():
    trail = driven((0.5, 0.0, -1.0), 2.0)
    assert trail.target.place == pytest.approx((1.0, 0.0, -2.0))
    assert trail.command[0].place == (0.0, 0.0, 0.0)


def test_a_new_motion_begins_at_the_tip():
    trail = driven((0.0, 0.0, 0.0), 0.5, driven((0.5, 0.0, 0.0), 2.0), 2.0)
    assert trail.target is None
    trail = driven((0.0, 1.0, 0.0), 1.0, trail, 2.5)
    assert trail.target.place == pytest.approx((0.0, 1.0, 0.0))


def test_a_command_after_a_gap_begins_at_the_tip():
    trail = with_command(driven((1.0, 0.0, 0.0), 1.0), 5.0, (1.0, 0.0, 0.0))
    assert trail.target.place == (0.0, 0.0, 0.0)


def test_points_are_forgotten_after_the_span_and_when_the_clock_goes_back():
    trail = driven((0.1, 0.0, 0.0), 3.0 * SPAN)
    for points in (trail.tip, trail.command):
        assert points[-1].time - points[0].time == pytest.approx(SPAN, abs=0.1)
    assert len(with_tip(trail, 1.0, (1.0, 2.0, 3.0)).tip) == 1


def test_nothing_is_commanded_before_the_tip_is_known():
    assert with_command(Trail(), 1.0, (1.0, 0.0, 0.0)) == Trail()
