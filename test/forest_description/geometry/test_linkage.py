"""Claims about the cylinder linkage, against the thesis' own two laws and numerical derivatives."""

import math

import numpy as np
import pytest

from forest_description.derived.limits import joint_limits
from forest_description.geometry.linkage import cylinder_length, joint_angle, lever_arm
from forest_description.machine import load_machine

MACHINE = load_machine("c180_thesis")
BOOM, STICK = MACHINE.linkages


def random_angles(axis, count=100):
    lower, upper = joint_limits(MACHINE)[axis]
    return np.random.default_rng(axis).uniform(lower, upper, count).tolist()


def test_cylinder_lengths_and_arms_of_the_check_pose():
    boom, stick = math.radians(30.0), math.radians(-90.0)
    assert cylinder_length(boom, BOOM) == pytest.approx(1.891588, abs=5e-7)
    assert cylinder_length(stick, STICK) == pytest.approx(2.161331, abs=5e-7)
    assert lever_arm(boom, BOOM) == pytest.approx(0.530926, abs=5e-7)
    assert lever_arm(stick, STICK) == pytest.approx(0.790510, abs=5e-7)


def test_one_law_gives_both_printed_cylinder_lengths():
    degree = math.pi / 180.0
    for q in random_angles(1):
        a, b = 0.5625397, 1.786382
        printed = math.sqrt(a**2 + b**2 - 2 * a * b * math.cos(q + 61.7 * degree + 0.31 * degree))
        assert cylinder_length(q, BOOM) == pytest.approx(printed, abs=1e-14)
    for q in random_angles(2):
        a, b = 1.933956, 0.884292
        printed = math.sqrt(a**2 + b**2 + 2 * a * b * math.cos(q + 2.5 * degree))
        assert cylinder_length(q, STICK) == pytest.approx(printed, abs=1e-14)


@pytest.mark.parametrize(("axis", "linkage"), [(1, BOOM), (2, STICK)], ids=["boom", "stick"])
def test_joint_angle_inverts_cylinder_length(axis, linkage):
    for q in random_angles(axis):
        assert joint_angle(cylinder_length(q, linkage), linkage) == pytest.approx(q, abs=1e-12)


@pytest.mark.parametrize(("axis", "linkage"), [(1, BOOM), (2, STICK)], ids=["boom", "stick"])
def test_lever_arm_matches_finite_difference(axis, linkage):
    step = 1e-6
    for q in random_angles(axis):
        slope = (cylinder_length(q + step, linkage) - cylinder_length(q - step, linkage)) / (2.0 * step)
        assert lever_arm(q, linkage) == pytest.approx(slope, abs=1e-9)


@pytest.mark.parametrize(("axis", "linkage"), [(1, BOOM), (2, STICK)], ids=["boom", "stick"])
def test_lever_arm_is_the_printed_arm_and_the_reciprocal_of_the_printed_jacobian(axis, linkage):
    a, b = linkage.pivot_to_base, linkage.pivot_to_rod
    for q in random_angles(axis):
        x = cylinder_length(q, linkage)
        arm = a * math.sin(math.acos((a**2 + x**2 - b**2) / (2 * a * x)))
        j = x / (a * b * math.sqrt(1 - (a**2 + b**2 - x**2) ** 2 / (4 * a**2 * b**2)))
        assert lever_arm(q, linkage) == pytest.approx(arm, rel=1e-9)
        assert lever_arm(q, linkage) == pytest.approx(1.0 / j, rel=1e-9)


@pytest.mark.parametrize("length", [1.2, 2.4, -1.5, math.nan])
def test_length_at_which_the_linkage_does_not_close_is_refused_with_the_lengths_that_do(length):
    with pytest.raises(ValueError, match=r"the linkage closes only from 1\.22384 to 2\.34892 m"):
        joint_angle(length, BOOM)
