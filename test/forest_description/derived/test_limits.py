"""Claims about joint ranges and workspace."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.derived.limits import THESIS_START, joint_limits, pose_at, start_tip, workspace_limits
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine

MACHINE, LOADER = load_machine("c180_hoses"), load_machine("loader")


def test_joint_ranges_that_follow_from_the_strokes():
    swing, boom, stick = (tuple(math.degrees(angle) for angle in pair) for pair in joint_limits(MACHINE))
    assert swing == pytest.approx((-180.0, 180.0))
    assert boom == pytest.approx((-36.7, 72.0), abs=0.05)
    assert stick == pytest.approx((-121.0, -50.0), abs=0.05)


def test_workspace_of_the_c180():
    limits = workspace_limits(MACHINE)
    assert limits.reach_max == pytest.approx(7.8, abs=0.05)
    assert limits.reach_min == pytest.approx(-0.5266, abs=1e-4)  # folded under itself, 4.1 m below the pivot
    assert (limits.height_min, limits.height_max) == pytest.approx((-6.8, 5.5), abs=0.05)


def wide_machine():
    """A crane whose joint box holds a straight stick and a boom that points up and back."""
    wide = {"retracted_length": 1.25, "stroke": 1.09, "angle_offset": 0.0}
    return dataclasses.replace(
        MACHINE,
        boom=dataclasses.replace(MACHINE.boom, **wide),
        stick=dataclasses.replace(MACHINE.boom, **wide | {"angle_offset": 1.5}),
    )


def test_a_stick_that_goes_past_straight_starts_folded():
    short = dataclasses.replace(wide_machine().manipulator, boom_length=1.0)
    machine = dataclasses.replace(wide_machine(), manipulator=short)
    low = joint_limits(machine)[2][0]
    assert pose_at(start_tip(machine), machine)[2] == pytest.approx(0.5 * low)


@pytest.mark.parametrize("machine", [MACHINE, wide_machine()], ids=["c180_hoses", "wide joints"])
def test_workspace_limits_are_the_extremes_of_a_dense_grid_of_poses(machine):
    _, boom, stick = joint_limits(machine)
    grid = [
        tip_position((0.0, q2, q3), machine.manipulator.links)
        for q2 in np.linspace(*boom, 400).tolist()
        for q3 in np.linspace(*stick, 400).tolist()
    ]
    reaches, _, heights = np.array(grid).T
    expected = (reaches.min(), reaches.max(), heights.min(), heights.max())
    assert workspace_limits(machine) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("machine", [MACHINE, LOADER], ids=["c180_hoses", "loader"])
def test_every_pose_inside_the_limits_is_found_again_from_its_tip(machine):
    low, high = np.array(joint_limits(machine)).T
    low[0], high[0] = -3.0, 3.0
    for q in np.random.default_rng(8).uniform(low, high, (100, 3)).tolist():
        tip = tip_position(tuple(q), machine.manipulator.links)
        if math.hypot(tip[0], tip[1]) > 0.1 and math.cos(math.atan2(tip[1], tip[0]) - q[0]) > 0.0:
            np.testing.assert_allclose(pose_at(tip, machine), q, atol=1e-9)


@pytest.mark.parametrize(
    ("tip", "told"),
    [
        ((9.0, 0.0, 0.0), "the reach from there is 0.2 .. 4.3 m"),
        ((2.0, 0.0, 2.5), r"it needs the boom at [0-9.]+ deg; allowed: -16.2 .. 70.3 deg"),
        ((4.3, 0.0, 0.3), r"it needs the stick at -[0-9.]+ deg; allowed: -130.4 .. -36.7 deg"),
    ],
)
def test_a_place_that_the_tip_cannot_reach_is_refused_with_what_is_allowed(tip, told):
    with pytest.raises(ValueError, match=told):
        pose_at(tip, LOADER)


def test_sessions_start_where_those_of_the_thesis_did_or_in_the_middle_of_the_ranges():
    assert start_tip(MACHINE) == THESIS_START
    start = pose_at(start_tip(LOADER), LOADER)
    middle = [0.0, *(0.5 * sum(interval) for interval in joint_limits(LOADER)[1:])]
    np.testing.assert_allclose(start, middle, atol=1e-12)
    aside = dataclasses.replace(LOADER, swing=dataclasses.replace(LOADER.swing, lower_limit=0.5))
    assert pose_at(start_tip(aside), aside)[0] == pytest.approx(0.5)
