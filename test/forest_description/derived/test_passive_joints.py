"""Claims about the cylinders' and the hanging head's joints; `test_robot_description.py` has those."""

import cmath
import dataclasses
import math

import numpy as np
import pytest

from forest_description.derived.limits import joint_limits
from forest_description.derived.passive_joints import (
    CYLINDER_JOINTS,
    HEAD_JOINTS,
    barrel_pivot,
    cylinder_followers,
    cylinder_joint_positions,
    head_joint_positions,
)
from forest_description.machine import load_machine

MACHINE = load_machine("c180_hoses")
DRIVES = (MACHINE.boom, MACHINE.stick)


def test_barrel_and_rod_reach_from_pivot_to_eye():
    """As complex numbers in the parent's frame: pivot + length e^(i angle) is the eye on the driven link."""
    for q in np.random.default_rng(1).uniform((-3.0, -0.6, -2.1), (3.0, 1.2, -0.9), (50, 3)).tolist():
        positions = cylinder_joint_positions(tuple(q), MACHINE)
        for number, drive in enumerate(DRIVES):
            angle, extension = positions[2 * number : 2 * number + 2]
            eye = complex(*barrel_pivot(drive.linkage)) + cmath.rect(
                drive.retracted_length + extension, angle
            )
            assert eye == pytest.approx(cmath.rect(drive.pivot_to_rod, q[1 + number]), abs=1e-12)


def test_rods_are_in_and_out_at_the_joints_limits():
    _, boom, stick = joint_limits(MACHINE)
    for end, share in ((0, 0.0), (1, 1.0)):
        positions = cylinder_joint_positions((0.0, boom[end], stick[end]), MACHINE)
        expected = (share * MACHINE.boom.stroke, share * MACHINE.stick.stroke)
        assert positions[1::2] == pytest.approx(expected, abs=1e-12)


def test_booms_cylinder_stands_before_the_column_and_sticks_under_the_boom():
    along, up = barrel_pivot(MACHINE.boom.linkage)
    assert along > 0.0 > up
    along, up = barrel_pivot(MACHINE.stick.linkage)
    assert -MACHINE.manipulator.boom_length < along < 0.0
    assert cylinder_joint_positions((0.0, 0.0, -math.pi / 2), MACHINE)[2] < 0.0  # barrel points down


def test_followers_are_the_nearest_straight_lines():
    """No other line has a smaller sum of squares: shifting or turning one makes it worse."""
    _, boom, stick = joint_limits(MACHINE)
    q2, q3 = np.linspace(*boom, 101), np.linspace(*stick, 101)
    exact = np.array([cylinder_joint_positions((0.0, a, b), MACHINE) for a, b in zip(q2, q3, strict=True)])
    for number, follower in enumerate(cylinder_followers(MACHINE)):
        x, y = (q2, q2, q3, q3)[number], exact[:, number]

        def loss(offset, multiplier, x=x, y=y):
            return np.sum((offset + multiplier * x - y) ** 2)

        best = loss(follower.offset, follower.multiplier)
        for change in ((1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3)):
            assert loss(follower.offset + change[0], follower.multiplier + change[1]) > best


def test_cylinders_follow_their_machine():
    longer = dataclasses.replace(MACHINE.boom, retracted_length=MACHINE.boom.retracted_length + 0.1)
    q = (0.0, 0.3, -1.2)
    ours, theirs = (
        cylinder_joint_positions(q, m) for m in (MACHINE, dataclasses.replace(MACHINE, boom=longer))
    )
    assert np.subtract(ours, theirs) == pytest.approx((0.0, 0.1, 0.0, 0.0), abs=1e-12)


def test_head_joint_counts_from_the_stick():
    assert head_joint_positions((2.0, 0.5, -1.25), (0.0, 0.2)) == (0.75, 0.2)
    assert len(HEAD_JOINTS) == 2
    assert len(CYLINDER_JOINTS) == 4
