"""A piece of path leads the tip along it and back to it, whatever slows the tip."""

import math

import numpy as np
import pytest

from forest_control.operator.taught_command import (
    NO_COMMAND,
    SHARPEST,
    WITHIN,
    TaughtCommand,
    distance_from_path,
    from_values,
    implausible,
    taught_velocity,
    to_values,
)
from forest_msgs_py.types import PERIOD

STRAIGHT = TaughtCommand((5.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), 0.3, 1.0)


def circle(radius, angle, speed=0.3, left=1.0):
    """The piece of a circle about the origin, and how far it reaches."""
    c, s = math.cos(angle), math.sin(angle)
    return TaughtCommand(
        (radius * c, radius * s, 0.0), (-s, c, 0.0), (-c / radius, -s / radius, 0.0), speed, left
    )


def test_on_the_path_the_tip_goes_along_it_at_its_speed():
    assert taught_velocity(STRAIGHT, (5.0, 0.0, 1.0), 0.5) == pytest.approx((0.0, 0.3, 0.0))


def test_beside_the_path_the_tip_comes_back_to_it():
    assert taught_velocity(STRAIGHT, (5.01, 0.0, 1.0), 0.5) == pytest.approx((-0.03, 0.3, 0.0))


def test_before_a_stop_the_tip_slows_down_and_behind_it_comes_back():
    near = STRAIGHT._replace(left=0.01)
    assert taught_velocity(near, (5.0, 0.005, 1.0), 0.5) == pytest.approx((0.0, 0.05, 0.0))
    assert taught_velocity(near, (5.0, 0.012, 1.0), 0.5) == pytest.approx((0.0, -0.006, 0.0))


@pytest.mark.parametrize("seed", range(20))
def test_no_piece_asks_for_more_than_the_profile_allows(seed):
    rng = np.random.default_rng(seed)
    t, k, place, x = rng.normal(size=(4, 3))
    k = np.cross(t, k) * rng.uniform(0.0, SHARPEST) / np.linalg.norm(np.cross(t, k))
    tangent = tuple((t / np.linalg.norm(t)).tolist())
    c = TaughtCommand(tuple(place.tolist()), tangent, tuple(k.tolist()), 3.0, float(rng.uniform(0.0, 2.0)))
    assert not implausible(c)
    velocity = taught_velocity(c, tuple((place + 0.1 * x).tolist()), 0.4)
    assert math.hypot(*velocity) <= 0.4 + 1e-12


@pytest.mark.parametrize("slow", [1.0, 0.3])
@pytest.mark.parametrize("late", [0.0, 0.03])
def test_a_bend_is_kept_although_the_pieces_come_late_and_a_limit_slows_the_tip(slow, late):
    """The pieces, of 0.4 m radius, are cut some mm behind the tip; a limit leaves a part of all speed."""
    x, radius, cross = np.array([0.4, 0.0, 0.0]), 0.4, []
    for _ in range(1500):
        angle = math.atan2(x[1], x[0]) - late / radius
        x = x + PERIOD * slow * np.array(taught_velocity(circle(radius, angle), tuple(x.tolist()), 0.5))
        cross.append(abs(np.linalg.norm(x) - radius))
    assert max(cross) < 5e-4
    assert np.linalg.norm(x - (0.4, 0.0, 0.0)) > 0.1


def test_the_distance_counts_from_the_piece_and_not_from_what_it_does_not_tell():
    assert distance_from_path(STRAIGHT, (5.03, 0.02, 1.04)) == pytest.approx(0.05)
    assert distance_from_path(STRAIGHT, (5.0, WITHIN + 0.2, 1.0)) == pytest.approx(0.2)
    assert distance_from_path(STRAIGHT._replace(left=0.01), (5.0, 0.03, 1.0)) == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"tangent": (0.0, 1.01, 0.0)}, "no unit vector"),
        ({"tangent": (0.0, 0.0, 0.0)}, "no unit vector"),
        ({"curvature": (SHARPEST, SHARPEST, 0.0)}, "its curvature is over 15 1/m"),
        ({"speed": -0.1}, "speed or way left is negative"),
        ({"left": -0.1}, "speed or way left is negative"),
        ({}, ""),
        ({"speed": 0.0, "tangent": (0.0, 0.0, 0.0)}, ""),
    ],
)
def test_what_cannot_be_is_told(change, sentence):
    said = implausible(STRAIGHT._replace(**change))
    assert sentence in said
    assert bool(sentence) == bool(said)


def test_a_command_is_the_same_behind_its_message():
    assert from_values(to_values(7.0, circle(0.4, 1.0))) == (7.0, circle(0.4, 1.0))


# In no plane of the axes, the direction a unit vector: (2, 3, 6) / 7.
SKEW = TaughtCommand((5.0, -1.0, 1.5), (2 / 7, 3 / 7, 6 / 7), (0.6, 1.2, -0.8), 0.3, 0.08)


@pytest.mark.parametrize("ahead", [0.01, -0.02, 0.2, -0.2])
def test_a_piece_asks_for_its_speed_along_the_bow_and_for_the_way_back_three_times_a_second(ahead):
    p, t, k = np.array(SKEW.place), np.array(SKEW.tangent), np.array(SKEW.curvature)
    off = np.cross(t, (0.01, -0.02, 0.03))
    x = p + ahead * t + off
    d = max(-0.05, min(ahead, 0.05))
    back = p + d * t + 0.5 * d * d * k - x
    speed = min(0.3, 10.0 * (0.08 - d))
    wanted = speed * (t + d * k) / np.linalg.norm(t + d * k) + 3.0 * back
    place = tuple(x.tolist())
    assert taught_velocity(SKEW, place, 9.0) == pytest.approx(wanted.tolist())
    assert distance_from_path(SKEW, place) == pytest.approx(np.linalg.norm(back))
    size = float(np.linalg.norm(wanted))
    assert taught_velocity(SKEW, place, 0.5 * size) == pytest.approx((0.5 * wanted).tolist())


def test_a_stop_is_no_further_than_what_is_left():
    near = SKEW._replace(left=0.01)
    x = tuple((np.array(SKEW.place) + 0.03 * np.array(SKEW.tangent)).tolist())
    found = np.array(taught_velocity(near, x, 9.0))
    bow = 0.5 * 0.01**2 * np.array(SKEW.curvature)
    assert found.tolist() == pytest.approx((3.0 * (bow - 0.02 * np.array(SKEW.tangent))).tolist())


@pytest.mark.parametrize(
    ("change", "fits"),
    [
        ({"tangent": (0.0, 1.0009, 0.0)}, True),
        ({"tangent": (0.0, 1.0011, 0.0)}, False),
        ({"tangent": (0.0, 0.9991, 0.0)}, True),
        ({"tangent": (0.0, 0.9989, 0.0)}, False),
        ({"curvature": (0.0, 0.0, -14.9)}, True),
        ({"curvature": (0.0, 0.0, -15.1)}, False),
        ({"left": 0.0}, True),
        ({"left": -1e-9}, False),
        ({"speed": 1e-9}, True),
        ({"speed": -1e-9}, False),
        ({"speed": math.nan}, False),
    ],
)
def test_the_bounds_of_what_can_be(change, fits):
    assert (implausible(STRAIGHT._replace(**change)) == "") == fits


def test_nothing_to_follow_has_no_speed():
    assert NO_COMMAND == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0)
    assert implausible(NO_COMMAND) == ""
