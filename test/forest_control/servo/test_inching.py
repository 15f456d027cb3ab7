"""Claims about how a joint at rest is brought to its place."""

from itertools import pairwise

import pytest

from forest_control.servo.inching import ARRIVED, FAR, LOOK, MOVING, NEAR, SETTLED, inched, is_due, served

DT = 0.005
RATE, COMMAND = 0.06, 0.3  # U [rad/s] of how many volts
CROSSED = 6.0  # [V] to cross an overlap to and fro


def at_rest(error, misjudged, duration, sinks=0.0, fed=False, free_way=0.0, pushed=(1e9, 0.0)):
    """Return the error's course [rad] and when inches began [s]; thought too wide by [V].

    From a time [s] on the joint is pushed away [rad] within half a second, its valve shut.
    """
    i, errors, begun = MOVING, [error], []
    for k in range(round(duration / DT)):
        shut = i.rate == 0.0 and not fed
        before = i.rate
        i = inched(i, error, shut, RATE, free_way, DT) if is_due(i, shut) else served(i, DT)
        if i.rate != 0.0 and before == 0.0:
            begun.append(k * DT)
        sign = (i.rate > 0.0) - (i.rate < 0.0)
        error += pushed[1] / 0.5 * DT * (pushed[0] <= k * DT < pushed[0] + 0.5)
        error += DT * sinks - DT * sign * max(0.0, abs(i.rate) + misjudged * RATE / COMMAND * (i.rate != 0.0))
        errors.append(error)
    return errors, begun


@pytest.mark.parametrize("misjudged", [-0.15, -0.1, 0.0, 0.1, 0.15])
@pytest.mark.parametrize("error", [5e-3, -2e-3])
def test_an_overlap_that_is_misjudged_still_lets_a_joint_be_inched_to_its_place(misjudged, error):
    errors, begun = at_rest(error, misjudged, 8.0)
    assert abs(errors[-1]) < FAR
    assert max(begun) < SETTLED + LOOK
    settled = errors[round((SETTLED + LOOK) / DT) :]
    assert max(settled) == min(settled)  # no cycle


def test_its_servo_has_its_time_first_and_what_is_near_is_near_enough():
    assert min(at_rest(1e-3, 0.0, 2.0)[1]) > ARRIVED
    assert at_rest(0.9 * NEAR, 0.0, 8.0)[1] == []


@pytest.mark.parametrize("free_way", [1e-3, 2e-3])
def test_what_the_play_of_a_gear_may_make_of_an_error_is_left_alone(free_way):
    for limit, after in ((NEAR, 0.0), (FAR, SETTLED)):
        _, begun = at_rest(0.95 * (0.5 * free_way + limit), 0.0, 20.0, free_way=free_way)
        assert [time for time in begun if time > after + LOOK] == []
    assert at_rest(1.05 * (0.5 * free_way + FAR), 0.0, 8.0, free_way=free_way)[1] != []


def test_an_inch_that_does_not_help_is_followed_by_a_stronger_one():
    """0.35 V too narrow: the inch that is set does not open the valve."""
    errors, begun = at_rest(2e-3, -0.35, 4.0)
    assert len(begun) > 1
    assert abs(errors[-1]) < FAR


def test_a_settled_joint_is_left_alone_but_for_what_can_be_seen():
    sinks = 3e-5  # [rad/s] a spool that leaks
    errors, begun = at_rest(0.0, 0.1, 60.0, sinks)
    assert max(map(abs, errors)) < 1.2 * FAR
    assert 0 < len(begun) < 5


def test_whatever_happens_the_valve_crosses_its_overlap_ever_more_seldom_but_twice_a_minute():
    begun = at_rest(2e-3, -2.0, 300.0)[1]  # it never opens
    last = [time for time in begun if time > 200.0]
    assert len(last) * CROSSED / 100.0 < 0.5
    assert max(after - before for before, after in pairwise(begun)) < 31.0


def test_an_actuator_that_is_fed_is_left_to_the_servo():
    assert at_rest(5e-3, 0.0, 5.0, fed=True)[1] == []


def test_a_joint_that_a_load_pushes_away_is_looked_at_anew_however_long_it_has_rested():
    """An overlap that no inch crosses has made it wait for 30 s between two inches."""
    *_, before, last = at_rest(2e-3, -2.0, 200.0)[1]
    assert last - before > 25.0
    then = last + 3.0
    begun = at_rest(2e-3, -2.0, 230.0, pushed=(then, 4e-3))[1]
    assert min(time for time in begun if time > then) < then + 1.0
    errors, begun = at_rest(0.0, 0.0, 70.0, pushed=(60.0, 4e-3))
    assert abs(errors[round(62.5 / DT)]) < NEAR
    assert len(begun) < 6
