"""Joints that stand all at once, after they have gone, keep their references near."""

import math

import pytest

from forest_control.servo.coordinated_servo import REST, all_stalled
from forest_control.servo.schemes import ERROR_LAG
from forest_control.servo.stalled_joints import (
    JointMotion,
    is_ahead,
    is_slow,
    is_stalled,
    kept_near,
    updated_motion,
)

DT = 0.005


RESTED = JointMotion()


def after(seconds, a, v, before=RESTED):
    for _ in range(round(seconds / DT)):
        before = updated_motion(before, a, v, DT)
    return before


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_that_has_gone_and_stops_stands_within_a_tenth_of_a_second(side):
    a = side * 0.1
    gone = after(0.5, a, a)
    assert not is_stalled(gone, a)
    assert is_stalled(after(0.1, a, 0.0, gone), a)
    assert not is_stalled(after(1.0, a, 0.45 * a, gone), a)  # slow
    assert not is_stalled(after(1.0, a, -a, gone), a)  # it is driven back
    assert not is_stalled(after(9.0, a, 0.0), a)  # it has not gone yet: its overlap may be wider
    assert not is_stalled(after(0.005, -a, 0.0, after(0.1, a, 0.0, gone)), -a)  # it shall go the other way


def test_all_joints_stand_that_shall_go():
    a = (0.1, -0.1, 0.001)
    stood, moving = JointMotion(0.0, 0.1), JointMotion(0.1, 0.1)
    memory = REST._replace(
        swing=REST.swing._replace(motion=stood), boom=REST.boom._replace(motion=JointMotion(0.0, -0.1))
    )
    assert all_stalled(memory, a)
    assert not all_stalled(memory, (0.001, 0.0, 0.001))
    assert not all_stalled(memory._replace(swing=REST.swing._replace(motion=moving)), a)
    assert not all_stalled(memory, (0.1, -0.1, 0.1))  # the stick has not gone


def test_a_reference_ahead_of_its_joint_is_kept_near_and_one_behind_it_stays():
    r = kept_near((0.5, 0.5, 0.501), (0.1, -0.1, 0.1), (0.4, 0.6, 0.5))
    assert r == pytest.approx((0.402, 0.598, 0.501))
    assert kept_near((0.5, 0.5, 0.5), (0.1, -0.1, 0.0), (0.6, 0.4, 0.4)) == (0.5, 0.5, 0.5)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_has_gone_2_milliradians_and_stands_below_two_fifths_of_its_rate(side):
    a, far = side * 0.1, side * 0.0021
    assert is_stalled(JointMotion(0.39 * a, far), a)
    assert not is_stalled(JointMotion(0.41 * a, far), a)
    assert not is_stalled(JointMotion(0.0, side * 0.0019), a)
    assert not is_stalled(JointMotion(0.0, -far), a)
    assert is_slow(side * 0.0049)
    assert not is_slow(side * 0.0051)
    assert is_ahead(a, side * 0.0021)
    assert not is_ahead(a, side * 0.0019)


def test_a_reference_that_rests_forgets_that_its_joint_has_gone():
    for v in (0.0, 0.1):
        assert updated_motion(JointMotion(v, 0.1), 0.0, v, DT).gone == 0.0
    assert not is_stalled(JointMotion(0.0, 0.1), 0.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_that_has_hopped_has_not_gone(side):
    a = side * 0.02
    hopped = after(0.05, a, a)  # 0.45 mrad, as of a spool that swings over the edge of a wide overlap
    assert not is_stalled(after(0.2, a, 0.0, hopped), a)
    assert is_stalled(after(0.2, a, 0.0, after(0.25, a, a)), a)


def test_the_way_of_a_joint_is_that_of_its_low_passed_rate_and_ends_when_it_is_driven_back():
    passed = 1.0 - math.exp(-0.01 / ERROR_LAG)
    assert updated_motion(JointMotion(0.0, 0.05), 0.1, 0.1, 0.01).gone == pytest.approx(0.05 + 0.001 * passed)
    assert updated_motion(JointMotion(-0.1, 0.0005), 0.1, -0.1, 0.01).gone == 0.0
    assert updated_motion(JointMotion(-0.1, 0.05), -0.1, -0.1, 0.01).gone == pytest.approx(-0.001)


def test_a_rate_is_low_passed_as_the_error_is():
    passed = 1.0 - math.exp(-0.01 / ERROR_LAG)
    assert updated_motion(JointMotion(0.02), 0.1, 0.05, 0.01).rate == pytest.approx(0.02 + 0.03 * passed)


@pytest.mark.parametrize("joint", [0, 1, 2])
def test_each_reference_is_kept_by_its_own_rate_and_angle(joint):
    r, s = (0.5, 0.6, 0.7), (0.4, 0.49, 0.58)
    a = tuple(0.1 if i == joint else -0.1 for i in range(3))
    near = tuple(s[i] + 0.002 if i == joint else r[i] for i in range(3))
    assert kept_near(r, a, s) == pytest.approx(near)
