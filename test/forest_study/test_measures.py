"""The measures against what is computed otherwise: places tried one by one, closed forms of known motions."""

import math

import numpy as np
import pytest

from forest_control.taught.tip_path import cross_track_distance, fastest, polyline
from forest_msgs_py.types import PERIOD
from forest_study.measures import NEAR, deviation, ideal, line_of, time_lost
from forest_study.tracking.paths import path_named

SPEED, RAMP = 0.5, 0.5
CORNERS = [(5.0, 0.0, 0.5), (6.0, 0.0, 0.5), (6.0, 0.8, 0.5), (5.2, 0.1, 1.0)]
PATHS = {
    "sweep": path_named("sweep"),
    "circle_v": path_named("circle_v"),
    "corners": polyline("corners", CORNERS),
    "there and back": polyline("back", [(5.0, 0.0, 0.5), (6.0, 0.0, 0.5), (5.0, 0.0, 0.5)]),
}


@pytest.fixture(params=list(PATHS))
def path(request):
    return PATHS[request.param]


def profile_of(path, speed=SPEED):
    return fastest(path, speed, RAMP, lambda _place, _along: 100.0)


def times_of(profile, rest=1.0):
    return np.arange(0.0, profile.duration + rest, PERIOD)


def test_the_distance_is_that_of_the_nearest_of_very_many_places(path):
    generator = np.random.default_rng(1)
    on = np.array([path.at(s) for s in generator.uniform(0.0, path.length, 40).tolist()])
    off = on + generator.normal(size=on.shape) * np.repeat([[2e-4], [5e-3], [0.1], [0.4]], 10, axis=0)
    brute = [nearest(path, place) for place in off]
    np.testing.assert_allclose(cross_track_distance(line_of(path), off), brute, atol=2e-7)


def nearest(path, place):
    """Try places all along the path, then ever closer around the best of them."""
    low, high = 0.0, path.length
    for _ in range(4):
        ways = np.linspace(low, high, 1001)
        away = [math.dist(path.at(s), place) for s in ways.tolist()]
        best = int(np.argmin(away))
        low, high = ways[max(0, best - 2)], ways[min(1000, best + 2)]
    return min(away)


def test_a_point_that_stands_several_times_on_a_line_changes_nothing():
    line = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0], [1.0, 1.0, 0]])
    places = np.array([[0.9, -0.2, 0], [1.3, 0.4, 0], [-1.0, 0, 0]])
    np.testing.assert_allclose(cross_track_distance(line, places), [0.2, 0.3, 1.0])


def test_a_tip_that_stands_has_one_place_as_its_line():
    assert cross_track_distance(np.zeros((5, 3)), np.array([[3.0, 4.0, 0.0]])) == pytest.approx([5.0])


def test_a_delay_costs_speed_times_delay_of_the_wish_no_cross_track_and_its_time(path):
    delay, profile = 0.08, profile_of(path)
    times = times_of(profile)
    tips = ideal(path, profile, times - delay)
    wish = np.linalg.norm(tips - ideal(path, profile, times), axis=1)
    fast = np.flatnonzero(np.interp(times, profile.time, profile.speed) > SPEED - 1e-6)
    straight = fast[np.interp(times[fast] - delay, profile.time, profile.speed) > SPEED - 1e-6]
    chord = 2.0 * math.sin(0.5 * SPEED * delay) if path.name.startswith("circle") else SPEED * delay
    assert wish[straight] == pytest.approx(chord, rel=1e-3)
    assert wish.max() <= SPEED * delay + 1e-9
    assert cross_track_distance(line_of(path), tips).max() < 1e-6
    assert time_lost(path, profile, times, tips) == pytest.approx(delay, abs=2e-3)


def test_a_tip_on_time_has_lost_nothing_and_an_early_one_has_won(path):
    profile = profile_of(path)
    times = times_of(profile)
    assert time_lost(path, profile, times, ideal(path, profile, times)) == pytest.approx(0.0, abs=2e-3)
    early = ideal(path, profile, times + 0.1)
    assert time_lost(path, profile, times, early) == pytest.approx(-0.1, abs=2e-3)


def test_a_run_that_a_limit_slows_stays_on_its_path_and_is_late(path):
    profile, slow = profile_of(path), profile_of(path, 0.2)
    times = times_of(slow)
    tips = ideal(path, slow, times)
    at = path.length - NEAR
    late = np.interp(at, slow.way, slow.time) - np.interp(at, profile.way, profile.time)
    assert time_lost(path, profile, times, tips) == pytest.approx(late, abs=5e-3)
    assert cross_track_distance(line_of(path), tips).max() < 1e-6
    assert deviation(np.linalg.norm(tips - ideal(path, profile, times), axis=1)).max_mm > 300.0


def test_a_tip_that_does_not_get_there_loses_the_time_up_to_the_end():
    path = PATHS["sweep"]
    profile = profile_of(path)
    times = times_of(profile)
    tips = ideal(path, profile, np.minimum(times, 5.0))
    assert time_lost(path, profile, times, tips) == pytest.approx(times[-1] - 5.0, abs=1e-6)


def test_a_tip_that_goes_back_for_three_periods_is_there_when_it_stays(path):
    profile = profile_of(path)
    times = times_of(profile)
    ways = profile.ways_at(times)
    back = np.flatnonzero(ways > path.length - 0.1 * NEAR)[0] + 3
    ways[back : back + 3] = path.length - 2.0 * NEAR
    tips = np.array([path.at(s) for s in ways.tolist()])
    expected = times[back + 2] - np.interp(path.length - NEAR, profile.way, profile.time)
    assert time_lost(path, profile, times, tips) == pytest.approx(expected, abs=PERIOD)


def test_a_tip_that_stays_at_a_circles_start_is_not_at_its_end():
    path = PATHS["circle_v"]
    profile = profile_of(path)
    times = times_of(profile)
    tips = np.tile(path.at(0.0), (len(times), 1))
    assert time_lost(path, profile, times, tips) == pytest.approx(times[-1], abs=1e-6)


def test_what_is_beside_the_path_costs_no_time_and_is_all_cross_track():
    path = PATHS["sweep"]
    profile = profile_of(path)
    times = times_of(profile)
    tips = ideal(path, profile, times) + np.array([0.03, 0.0, 0.04])
    assert cross_track_distance(line_of(path), tips) == pytest.approx(0.05)
    assert time_lost(path, profile, times, tips) == pytest.approx(0.0, abs=1e-9)


def test_a_deviation_is_the_root_of_the_mean_square_and_the_greatest():
    assert deviation(np.array([0.003, 0.004, 0.0, 0.0])) == pytest.approx((2.5, 4.0))
