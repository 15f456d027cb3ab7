"""Claims about what a joint that runs ahead is commanded: little more than its reference, the same way."""

import pytest

from forest_control.servo.overspeed_limit import without_overspeed


def one(u, a, v):
    """The stick's, which is not to be told from the others'."""
    swing, boom, stick = without_overspeed((u, u, u), (a, a, a), (v, v, v))
    assert swing == boom == stick
    assert without_overspeed((-u, 0.0, 0.0), (-a, 0.0, 0.0), (-v, 0.0, 0.0))[0] == -stick
    return stick


def test_a_joint_that_keeps_to_its_reference_or_lags_is_commanded_what_its_servo_asks_for():
    for u, a, v in ((0.5, 0.2, 0.0), (0.25, 0.2, 0.26), (0.03, 0.0, 0.02), (0.3, 0.0, -0.4)):
        assert one(u, a, v) == u


def test_a_joint_that_runs_ahead_is_commanded_a_fifth_more_than_its_reference_and_a_little():
    assert one(0.3, 0.1, 0.2) == pytest.approx(0.12 + 0.03)
    assert one(0.1, 0.1, 0.2) == 0.1
    assert one(0.3, 0.0, 0.5) == pytest.approx(0.03)


@pytest.mark.parametrize("joint", [0, 1, 2])
def test_each_joint_has_its_own_bound(joint):
    u, a, bounds = (0.6, 0.7, 0.8), (0.1, 0.2, 0.3), (0.15, 0.27, 0.39)
    v = tuple(1.0 if i == joint else a[i] for i in range(3))
    assert without_overspeed(u, a, v) == pytest.approx([(u, bounds)[i == joint][i] for i in range(3)])


def test_no_valve_is_turned_round_by_it():
    assert one(0.3, -0.5, 0.4) == pytest.approx(0.03)
    assert one(0.0, -0.5, 0.4) == 0.0
