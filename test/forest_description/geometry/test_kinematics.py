"""Claims about the tip kinematics, against numbers and numerical derivatives."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from properties import between, vectors

from forest_description.geometry.kinematics import (
    Links,
    inverse_kinematics,
    is_singular,
    jacobian,
    jacobian_determinant,
    joint_rates,
    nearest_pose,
    tip_orientation,
    tip_position,
    tip_velocity,
)

LINKS = Links(0.1524, 4.118356, 4.2991)
CHECK_POSE = (0.0, math.radians(30.0), math.radians(-90.0))


def reach(q):
    """Distance of the tip from the swing axis, negative behind it."""
    return tip_position((0.0, *q[1:]), LINKS)[0]


def random_poses(count=100, seed=1):
    """Poses all around, stick folded by 0.1 to 3 rad, tip ahead of the swing axis by at least 0.5 m."""
    generator = np.random.default_rng(seed)
    poses = []
    while len(poses) < count:
        q = tuple(generator.uniform((-3.1, -1.5, -3.0), (3.1, 2.5, -0.1)).tolist())
        if (
            math.hypot(*tip_position(q, LINKS)[:2]) > 0.5
            and -jacobian_determinant(q, LINKS) / math.sin(q[2]) > 0
        ):
            poses.append(q)
    return poses


POSES = random_poses()


def test_tip_of_the_check_pose():
    assert tip_position(CHECK_POSE, LINKS) == pytest.approx((5.86855, 0.0, -1.66395), abs=5e-6)


def turned(quaternion, vector):
    """A vector turned by a unit quaternion, v + 2 u × (u × v + w v)."""
    u, w = np.array(quaternion[:3]), quaternion[3]
    return vector + 2.0 * np.cross(u, np.cross(u, vector) + w * np.array(vector))


@pytest.mark.parametrize("q", POSES)
def test_the_tips_frame_lies_along_the_stick_and_its_y_axis_is_level_to_the_left(q):
    stick = np.subtract(tip_position(q, LINKS), tip_position(q, LINKS._replace(stick=0.0)))
    quaternion = tip_orientation(q)
    assert np.linalg.norm(quaternion) == pytest.approx(1.0, abs=1e-12)
    assert turned(quaternion, (1.0, 0.0, 0.0)) == pytest.approx(stick / LINKS.stick, abs=1e-12)
    left = (-math.sin(q[0]), math.cos(q[0]), 0.0)
    assert turned(quaternion, (0.0, 1.0, 0.0)) == pytest.approx(left, abs=1e-12)


def test_determinant_of_the_check_pose():
    assert jacobian_determinant(CHECK_POSE, LINKS) == pytest.approx(103.904, abs=5e-4)


def test_positive_angles_swing_left_lift_the_boom_and_unfold_the_stick():
    q = (0.0, 0.2, -1.0)
    p = tip_position(q, LINKS)
    assert tip_position((0.1, 0.2, -1.0), LINKS)[1] > 0.0
    assert tip_position((0.0, 0.3, -1.0), LINKS)[2] > p[2]
    assert tip_position((0.0, 0.2, -0.9), LINKS)[0] > p[0]


def test_jacobian_matches_finite_difference():
    step = 1e-6
    for q in POSES:
        for axis in range(3):
            ahead = tuple(angle + step * (k == axis) for k, angle in enumerate(q))
            behind = tuple(angle - step * (k == axis) for k, angle in enumerate(q))
            slope = (np.array(tip_position(ahead, LINKS)) - tip_position(behind, LINKS)) / (2.0 * step)
            np.testing.assert_allclose(np.array(jacobian(q, LINKS))[:, axis], slope, atol=1e-8)


def test_determinant_is_that_of_the_matrix():
    for q in POSES:
        assert jacobian_determinant(q, LINKS) == pytest.approx(np.linalg.det(jacobian(q, LINKS)), abs=1e-10)


def test_tip_velocity_is_jacobian_times_rates():
    rates = (0.3, -0.2, 0.5)
    for q in POSES:
        np.testing.assert_allclose(
            tip_velocity(q, rates, LINKS), np.array(jacobian(q, LINKS)) @ rates, atol=1e-13
        )


def test_joint_rates_solve_the_linear_system_of_the_jacobian():
    velocity = (0.4, -0.7, 0.2)
    for q in POSES:
        expected = np.linalg.solve(jacobian(q, LINKS), velocity)
        np.testing.assert_allclose(joint_rates(q, velocity, LINKS), expected, rtol=1e-9, atol=1e-12)


def test_inverse_kinematics_returns_the_pose_of_a_folded_stick():
    for q in POSES:
        np.testing.assert_allclose(inverse_kinematics(tip_position(q, LINKS), LINKS), q, atol=1e-9)


def test_inverse_kinematics_chooses_the_elbow_above_the_line_to_the_tip():
    _, boom, stick = inverse_kinematics((5.5, 0.0, 1.0), LINKS)
    assert stick < 0.0
    assert boom > math.atan2(1.0, 5.5 - LINKS.base_offset)


def test_inverse_kinematics_reaches_both_edges_of_the_reach():
    straight = inverse_kinematics((LINKS.base_offset + LINKS.boom + LINKS.stick, 0.0, 0.0), LINKS)
    assert straight == pytest.approx((0.0, 0.0, 0.0), abs=1e-7)
    folded = inverse_kinematics((LINKS.base_offset + LINKS.stick - LINKS.boom, 0.0, 0.0), LINKS)
    assert folded == pytest.approx((0.0, math.pi, -math.pi), abs=1e-7)


def test_rounding_at_full_reach_is_not_an_error():
    for q in POSES:
        straight = (q[0], 0.3 * q[1], 0.0)
        again = inverse_kinematics(tip_position(straight, LINKS), LINKS)
        assert again == pytest.approx(straight, abs=1e-6)


def test_boom_angle_of_inverse_kinematics_stays_within_half_a_turn():
    position = (0.0, 0.0, 0.3)
    q = inverse_kinematics(position, LINKS)
    assert -math.pi <= q[1] <= math.pi
    assert tip_position(q, LINKS) == pytest.approx(position, abs=1e-12)


@pytest.mark.parametrize("position", [(9.0, 0.0, 0.0), (0.16, 0.0, 0.05), (math.nan, 0.0, 0.0)])
def test_unreachable_position_is_refused_with_the_reach_that_is_allowed(position):
    with pytest.raises(ValueError, match=r"the reach from there is 0\.180744 \.\. 8\.41746 m"):
        inverse_kinematics(position, LINKS)


def swing_axis_pose():
    """A pose whose tip is on the swing axis, up to rounding."""
    return inverse_kinematics((0.0, 0.0, 5.0), LINKS)


@pytest.mark.parametrize(
    "q",
    [(0.3, 0.5, 0.0), (0.3, 0.5, -math.pi), swing_axis_pose(), (0.0, math.nan, -1.0)],
    ids=["straight", "folded flat", "on the swing axis", "not a number"],
)
def test_singular_pose_is_recognised_and_its_joint_rates_are_zero(q):
    assert is_singular(q, LINKS)
    assert joint_rates(q, (1.0, 1.0, 1.0), LINKS) == (0.0, 0.0, 0.0)


def test_no_working_pose_is_singular():
    assert not any(is_singular(q, LINKS) for q in POSES)


@given(st.tuples(between(-4.0, 4.0), between(-1.5, 2.8), between(-3.0, 3.0)), vectors(-0.02, 0.02))
def test_the_pose_of_a_pose_s_tip_is_that_pose_whatever_its_branch(q, beside):
    """Both elbows, behind the swing axis, swung by more than half a turn."""
    assume(abs(math.sin(q[2])) >= 0.1 and abs(reach(q)) >= 0.5)
    near = tuple(a + b for a, b in zip(q, beside, strict=True))
    assert nearest_pose(tip_position(q, LINKS), near, LINKS) == pytest.approx(q, abs=1e-9)


def test_nearest_pose_of_a_tip_out_of_reach_points_there_stretched():
    swing, boom, stick = nearest_pose((50.0, 50.0, 0.0), (0.5, 0.1, -0.2), LINKS)
    assert swing == pytest.approx(math.pi / 4.0)
    assert (boom, stick) == pytest.approx((0.0, 0.0), abs=1e-9)
