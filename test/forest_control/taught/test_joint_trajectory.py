"""A program's joint trajectory becomes a leg of the tip, with the speed that it asks for."""

import math

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.servo.link_bending import link_angles
from forest_control.taught import taught_work
from forest_control.taught.joint_trajectory import (
    MOST,
    TrajectoryPoint,
    TrajectoryRow,
    trajectory_leg,
    trajectory_points,
)
from forest_control.taught.tip_path import PathError
from forest_description.geometry.kinematics import inverse_kinematics, tip_position
from forest_description.machine import load_machine
from forest_description.types import AXES

P = parameters(load_machine("c180_hoses"), Settings())
HERE = (5.5, 0.0, 1.0)
POSE = inverse_kinematics(HERE, P.links)
BESIDE = (POSE[0] + 0.3, POSE[1], POSE[2])


def rows(*points):
    return [TrajectoryRow(time, positions, ()) for time, positions in points]


def test_what_paths_need_is_loaded_before_a_program_waits_for_an_answer(monkeypatch, tmp_path):
    loaded = []
    monkeypatch.setattr(taught_work, "load_splines", lambda: loaded.append("here"))
    taught_work.TaughtWork(tmp_path, P)
    assert loaded == ["here"]


def test_values_are_put_into_the_order_of_the_joints():
    (point,) = trajectory_points(
        ("stick", "swing", "boom"), [TrajectoryRow(1.0, (3.0, 1.0, 2.0), (6.0, 4.0, 5.0))]
    )
    assert point == TrajectoryPoint(1.0, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0))


@pytest.mark.parametrize(
    ("names", "given", "said"),
    [
        (("swing", "boom"), rows((1.0, (0.0, 0.0))), "joints swing, boom; allowed: swing, boom, stick"),
        ((), rows((1.0, ())), "joints none; allowed"),
        (AXES, [], "0 points; allowed: 1 to"),
        (AXES, rows(*[(k, POSE) for k in range(MOST + 1)]), "points; allowed: 1 to"),
        (AXES, rows((1.0, POSE[:2])), "point 0: positions .*; allowed: 3 finite numbers"),
        (AXES, rows((1.0, (0.0, math.nan, 0.0))), "allowed: 3 finite numbers"),
        (AXES, [TrajectoryRow(1.0, POSE, (math.inf, 0.0, 0.0))], "point 0: velocities .*; allowed"),
        (AXES, rows((-1.0, POSE)), "point 0 at -1 s; allowed: 0 to"),
        (AXES, rows((math.nan, POSE)), "point 0 at nan s; allowed"),
        (AXES, rows((1.0, POSE), (1.0, BESIDE)), "point 1 at 1 s; allowed: after 1 s"),
    ],
)
def test_what_is_no_trajectory_of_this_crane_is_refused_by_name(names, given, said):
    with pytest.raises(PathError, match=said):
        trajectory_points(names, given)


def test_a_crane_that_bends_ends_with_its_joints_where_they_are_asked_and_its_tip_below():
    forwarder = parameters(load_machine("forwarder"), Settings())
    here = (5.5, 0.0, 0.5)
    asked = inverse_kinematics((5.5, 1.0, 0.5), forwarder.links)
    leg = trajectory_leg([TrajectoryPoint(4.0, asked)], here, forwarder)
    end = leg.path.at(leg.path.length)
    low = tip_position(
        link_angles(asked, 0.0, forwarder.speed_limits, forwarder.coordinated.arm), forwarder.links
    )
    assert end == pytest.approx(low, abs=1e-6)
    assert 0.003 < 0.5 - end[2] < 0.03


def test_the_tip_goes_the_way_of_the_joints():
    """A swing alone draws an arc about the column; the straight line would be 6 cm beside it."""
    leg = trajectory_leg([TrajectoryPoint(4.0, BESIDE)], HERE, P)
    places = np.array([leg.path.at(s) for s in np.linspace(0.0, leg.path.length, 200)])
    assert np.hypot(places[:, 0], places[:, 1]) == pytest.approx(5.5, abs=1e-5)
    assert leg.path.length == pytest.approx(0.3 * 5.5, rel=1e-5)
    assert math.dist(leg.path.at(leg.path.length), tip_position(BESIDE, P.links)) < 1e-9


def test_the_speed_is_the_trajectorys_where_the_crane_can():
    slow = trajectory_leg([TrajectoryPoint(10.0, BESIDE)], HERE, P)
    assert slow.speed_at(0.8) == pytest.approx(1.65 / 10.0, rel=1e-3)
    assert slow.duration == pytest.approx(10.0 + 0.165 / 0.5, rel=0.01)  # ramps at both ends
    fast = trajectory_leg([TrajectoryPoint(0.2, BESIDE)], HERE, P)
    assert 0.5 < fast.speed_at(0.8) < 1.65 / 0.2
    assert fast.duration > 1.0


def test_rates_bend_the_way_between_two_points():
    """With no rate at either end the tip is slow there, and 1.5 times the mean speed in the middle."""
    points = [TrajectoryPoint(0.0, POSE, (0.0, 0.0, 0.0)), TrajectoryPoint(10.0, BESIDE, (0.0, 0.0, 0.0))]
    leg = trajectory_leg(points, HERE, P)
    assert leg.speed_at(0.5 * leg.path.length) == pytest.approx(1.5 * 0.165, rel=0.01)


def test_the_tip_stops_where_the_joints_turn_round():
    leg = trajectory_leg([TrajectoryPoint(4.0, BESIDE), TrajectoryPoint(8.0, POSE)], HERE, P)
    assert leg.path.stops == pytest.approx((0.0, 1.65, 3.3), rel=1e-4)


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (
            [TrajectoryPoint(0.0, BESIDE), TrajectoryPoint(1.0, POSE)],
            "begins 1.64 m from the tip; allowed: 0.02 m",
        ),
        ([TrajectoryPoint(1.0, POSE)], "two or more points that are not all the same"),
        ([TrajectoryPoint(5.0, (POSE[0], POSE[1] + 3.0, POSE[2]))], "joint is at its limit"),
        # The samples of these would fill the memory, and plan for ever.
        (
            [TrajectoryPoint(5.0, (1e300, *POSE[1:]))],
            "some 8.*e.300 m of the tip; allowed: 1000 m, angles in rad",
        ),
        ([TrajectoryPoint(5.0, (-1e308, *POSE[1:])), TrajectoryPoint(6.0, (1e308, *POSE[1:]))], "some inf m"),
        (
            [TrajectoryPoint(0.3 * k, (1.5 * (-1) ** k, *POSE[1:])) for k in range(1, MOST)],
            "some 2.*m of the tip",
        ),
    ],
)
def test_what_the_crane_cannot_do_is_refused_before_it_moves(points, said):
    with pytest.raises(PathError, match=said):
        trajectory_leg(points, HERE, P)
