"""Joints that stand all at once, after they have gone, keep their references near."""

import pytest

from forest_control.servo.coordinated_servo import REST, all_stalled
from forest_control.servo.stalled_joints import JointMotion, is_stalled, kept_near, updated_motion

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
    stood, moving = JointMotion(0.0, 1.0), JointMotion(0.1, 1.0)
    memory = REST._replace(
        swing=REST.swing._replace(motion=stood), boom=REST.boom._replace(motion=JointMotion(0.0, -1.0))
    )
    assert all_stalled(memory, a)
    assert not all_stalled(memory, (0.001, 0.0, 0.001))
    assert not all_stalled(memory._replace(swing=REST.swing._replace(motion=moving)), a)
    assert not all_stalled(memory, (0.1, -0.1, 0.1))  # the stick has not gone


def test_a_reference_ahead_of_its_joint_is_kept_near_and_one_behind_it_stays():
    r = kept_near((0.5, 0.5, 0.501), (0.1, -0.1, 0.1), (0.4, 0.6, 0.5))
    assert r == pytest.approx((0.402, 0.598, 0.501))
    assert kept_near((0.5, 0.5, 0.5), (0.1, -0.1, 0.0), (0.6, 0.4, 0.4)) == (0.5, 0.5, 0.5)
