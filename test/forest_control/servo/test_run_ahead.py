"""Claims about what is taken back of a command: a joint runs ahead by little, no valve is turned round."""

import pytest

from forest_control.servo.run_ahead import taken_back


def one(u, a, v):
    """The stick's, which is not to be told from the others'."""
    swing, boom, stick = taken_back((u, u, u), (a, a, a), (v, v, v))
    assert swing == boom == stick
    assert taken_back((-u, 0.0, 0.0), (-a, 0.0, 0.0), (-v, 0.0, 0.0))[0] == -stick
    return stick


def test_a_joint_that_keeps_to_its_reference_or_lags_is_commanded_what_its_servo_asks_for():
    for u, a, v in ((0.5, 0.2, 0.0), (0.25, 0.2, 0.26), (0.03, 0.0, 0.02), (0.3, 0.0, -0.4)):
        assert one(u, a, v) == u


def test_a_joint_that_runs_ahead_has_twice_taken_back_what_it_is_too_fast_by():
    assert one(0.3, 0.1, 0.2) == pytest.approx(0.3 - 2.0 * (0.2 - 0.12 - 0.03))
    assert one(0.3, -0.2, 0.1) == pytest.approx(0.3 - 2.0 * (0.1 - 0.03))


def test_a_joint_that_runs_away_has_its_valve_shut_and_not_turned_round():
    assert one(0.3, 0.1, 0.5) == 0.0
    assert one(0.0, 0.1, 0.5) == 0.0
