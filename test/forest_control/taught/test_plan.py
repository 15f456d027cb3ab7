"""A plan is refused before motion where the crane cannot go, and is slow enough everywhere else."""

import math

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.config.workspace_file import load_workspace
from forest_control.limits.velocity_scaling import velocity_scaling
from forest_control.pipeline.motion_limits import velocity_limits_at
from forest_control.taught.cycle import Cycle, Grapple, Path, Pose
from forest_control.taught.cycle_file import load_cycle
from forest_control.taught.plan import RAMP, Hold, Leg, greatest_speed, planned
from forest_control.taught.tip_path import PathError
from forest_description.geometry.kinematics import inverse_kinematics, joint_rates
from forest_description.machine import load_machine

C180 = load_machine("c180_hoses")
P = parameters(C180, Settings())
START = (5.5, 0.0, 1.0)


def plan_of(*segments, p=P):
    return planned(Cycle("tried", segments), START, p)


@pytest.mark.parametrize(
    ("place", "why"),
    [
        ((20.0, 0.0, 1.0), "a joint is at its limit"),
        ((3.0, 0.0, 0.5), "a joint is at its limit"),
        ((0.0, 0.0, 3.0), "a joint is at its limit"),  # on the swing axis
        ((5.0, 0.0, 6.5), "a joint is at its limit"),
    ],
)
def test_what_is_out_of_reach_is_refused_and_its_segment_named(place, why):
    with pytest.raises(PathError, match=f"segment 'far': .*{why}"):
        plan_of(Pose("near", (6.0, 0.0, 1.0), 0.3), Pose("far", place, 0.3))


def test_a_place_beyond_the_arm_is_told_with_the_reach():
    with pytest.raises(PathError, match=r"far: tip position \(20, 0, 1\) m is .* the reach from there is"):
        greatest_speed("far", (20.0, 0.0, 1.0), (1.0, 0.0, 0.0), 1.0, P)


def test_a_wall_in_the_way_is_refused_and_its_segment_named(tmp_path):
    walls = tmp_path / "walls.yaml"
    walls.write_text("boxes:\n  - {lower: [5.8, -1, 0], upper: [6.0, 1, 2]}\nmargin: 0.1\n")
    walled = parameters(C180, Settings(), load_workspace(str(walls)))
    with pytest.raises(PathError, match=r"segment 'through': at \(5\.[67]\d*, 0\.0, 1\.0\) m a wall"):
        plan_of(Pose("through", (6.5, 0.0, 1.0), 0.3), p=walled)
    assert plan_of(Pose("before", (5.6, 0.0, 1.0), 0.3), p=walled)


def test_a_path_that_begins_elsewhere_is_reached_by_a_straight_leg_of_its_segment():
    approach, path = plan_of(Path("bow", ((5.0, 1.0, 0.5), (5.5, 1.5, 0.7), (6.0, 1.5, 0.5)), 0.3))
    assert approach.path.at(0.0) == pytest.approx(START)
    assert approach.path.at(approach.path.length) == pytest.approx(path.path.at(0.0))
    assert (approach.number, path.number) == (1, 1)


def test_a_tip_that_is_there_needs_no_leg():
    (step,) = plan_of(Pose("here", START, 0.3), Grapple("grasp", "close"))
    assert isinstance(step, Hold)
    assert step.number == 2


def test_a_cycle_without_segments_is_refused():
    with pytest.raises(PathError, match="no segment"):
        plan_of()


def test_a_leg_stands_at_its_stops_and_can_brake_for_all_that_follows():
    corner = ((5.5, 0.0, 1.0), (6.5, 0.0, 1.0), (6.5, 0.0, 1.5), (6.0, 0.8, 1.5))
    (leg,) = plan_of(Path("corner", corner, 0.5))
    assert [leg.speed_at(s) for s in leg.path.stops] == [0.0] * len(leg.path.stops)
    slope = np.diff(leg.square) / np.diff(leg.ways) / 2.0
    assert slope.min() >= -RAMP - 1e-9
    assert math.sqrt(leg.square.max()) == pytest.approx(0.5)


@pytest.mark.parametrize("seed", range(5))
def test_at_the_planned_speed_no_limit_takes_more_than_its_smooth_beginning(seed):
    """Near a joint's limit the scaling begins early, in a smooth curve; the others leave the plan alone."""
    rng = np.random.default_rng(seed)
    points = [(5.5, 0.0, 1.0)]
    for k in range(1, 5):
        reach, angle = rng.uniform(5.3, 6.8), 0.3 * k
        points.append((reach * math.cos(angle), reach * math.sin(angle), rng.uniform(0.0, 1.0)))
    (leg,) = plan_of(Path("wild", tuple(points), 1.5))
    for s in np.linspace(0.01, leg.path.length - 0.01, 60).tolist():
        a, b = np.array(leg.path.at(s - 1e-3)), np.array(leg.path.at(s + 1e-3))
        velocity = tuple((leg.speed_at(s) * (b - a) / np.linalg.norm(b - a)).tolist())
        angles = inverse_kinematics(leg.path.at(s), P.links)
        rates = joint_rates(angles, velocity, P.links)
        left = velocity_scaling(angles, rates, velocity_limits_at(angles, rates, P))
        assert left.factor > 1.0 - 1e-6, left


def test_the_shipped_cycles_are_within_the_shipped_machines_reach_and_walls(tmp_path):
    walled = parameters(C180, Settings(), load_workspace("c180"))
    for name in ("transport", "reach-grasp"):
        assert planned(load_cycle(name, tmp_path), START, walled)


def test_the_reach_grasp_cycle_reaches_grasps_brings_and_releases(tmp_path):
    steps = planned(load_cycle("reach-grasp", tmp_path), (5.0, 0.0, 0.8), P)
    assert [step.name for step in steps] == ["reach", "grasp", "bring", "release", "transport"]
    assert [isinstance(step, Leg) for step in steps] == [True, False, True, False, True]


def test_the_greatest_speed_is_what_the_governor_leaves():
    speed = greatest_speed("free", START, (0.0, 1.0, 0.0), 100.0, P)
    angles = inverse_kinematics(START, P.links)
    rates = joint_rates(angles, (0.0, speed, 0.0), P.links)
    assert rates[0] == pytest.approx(0.8, rel=0.2)
