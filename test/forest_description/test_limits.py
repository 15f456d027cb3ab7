"""Claims about joint ranges and workspace."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.kinematics import tip_position
from forest_description.limits import joint_limits, workspace_limits
from forest_description.machine import load_machine

MACHINE = load_machine()


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


@pytest.mark.parametrize("machine", [MACHINE, wide_machine()], ids=["c180", "wide joints"])
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
