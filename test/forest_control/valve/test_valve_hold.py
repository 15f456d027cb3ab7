"""Claims about when a small command opens a valve: motion does at once, noise does not."""

import math

import numpy as np
import pytest

from forest_control.valve.valve_hold import SHUT, held_command

ZONE, NOISE, PERIOD = 0.02, 0.06, 0.005  # [V], [V], [s]
both_ways = pytest.mark.parametrize("sign", [1.0, -1.0], ids=["positive", "negative"])


def step(hold, command, zone=ZONE, opens=None, side=0.0, noise=NOISE, held=False):
    return held_command(hold, command, zone, zone if opens is None else opens, side, noise, held, PERIOD)


def feed(hold, command, seconds, **options):
    """The state after a steady command, and what it obeys."""
    said = []
    for _ in range(round(seconds / PERIOD)):
        hold, obey = step(hold, command, **options)
        said.append(obey)
    return hold, said


def first(said, condition):
    """When a condition is first met [s]."""
    return (next(k for k, obey in enumerate(said) if condition(obey)) + 1) * PERIOD


def moved(sign=1.0, command=2.0):
    """After a second of motion."""
    return feed(SHUT, sign * command, 1.0)[0]


def opened(sign=1.0):
    """At rest, opened by a steady command that may be noise."""
    hold, said = feed(SHUT, sign * 0.05, 1.0)
    assert said[-1] == sign * 0.05
    return hold


@both_ways
def test_no_command_shuts_the_valve_at_once_and_nothing_is_left_of_the_last(sign):
    for before in (moved(sign), opened(sign)):
        hold, obey = step(before, 0.0)
        assert (obey, hold.slow, hold.quick, hold.way) == (0.0, 0.0, 0.0, 0.0)
    assert step(feed(moved(sign), 0.0, 1.0)[0], -sign * 0.019)[1] == 0.0


@both_ways
def test_in_motion_the_valve_is_open_towards_the_command(sign):
    assert moved(sign).way == opened(sign).way == sign


@both_ways
def test_a_command_that_cannot_be_noise_is_obeyed_at_once(sign):
    rest, _ = feed(SHUT, sign * 0.001, 1.0)
    for noise, bound in ((NOISE, NOISE), (0.0, ZONE)):
        assert step(rest, sign * bound * 1.001, noise=noise)[1] == sign * bound * 1.001
        assert step(rest, sign * bound, noise=noise)[1] == 0.0
        assert step(rest, -sign * bound * 1.001, noise=noise)[1] == -sign * bound * 1.001


@both_ways
def test_one_that_may_be_noise_opens_when_its_mean_of_a_fifth_of_a_second_is_over_the_zone(sign):
    rest, _ = feed(SHUT, sign * 0.001, 1.0)
    _, said = feed(rest, sign * 0.05, 1.0)
    assert first(said, bool) == pytest.approx(0.2 * math.log(0.049 / 0.03), abs=PERIOD)
    assert said[-1] == sign * 0.05
    assert not any(feed(rest, sign * ZONE, 3.0)[1])
    assert any(feed(rest, sign * ZONE * 1.02, 3.0)[1])
    assert not any(feed(SHUT, sign * ZONE, 3.0)[1])
    assert feed(rest, sign * 0.1, 0.1)[0].slow == pytest.approx(
        sign * (0.1 - 0.099 * math.exp(-0.5))
    )  # in motion, too


@both_ways
def test_where_leakage_must_be_fed_a_valve_opens_for_less_than_the_zone(sign):
    assert feed(SHUT, sign * 0.006, 0.1, opens=0.005)[1][-1] == sign * 0.006
    assert not any(feed(SHUT, sign * 0.0049, 3.0, opens=0.005)[1])


@both_ways
def test_a_valve_that_a_small_command_opened_shuts_when_that_is_back_at_a_quarter_of_the_zone(sign):
    _, said = feed(opened(sign), sign * 0.004, 0.5)
    assert first(said, lambda obey: obey == 0.0) == pytest.approx(0.02 * math.log(46.0), abs=PERIOD)
    assert not any(said[60:])
    assert feed(opened(sign), sign * 0.0051, 5.0)[1][-1] == sign * 0.0051
    hold, _ = step(SHUT, sign * 0.05)
    _, said = feed(hold, sign * 0.004, 0.5)  # of one that has just begun the first sample counts whole
    assert first(said, lambda obey: obey == 0.0) == pytest.approx(0.02 * math.log(46.0), abs=PERIOD)


@both_ways
def test_while_its_noise_turns_round_an_open_valve_is_held_barely_open(sign):
    _, said = feed(opened(sign), -sign * 0.01, 0.5)
    shuts = first(said, lambda obey: obey == 0.0)
    assert shuts == pytest.approx(0.02 * math.log(4.0), abs=PERIOD)
    assert all(0.0 < sign * obey < 1e-6 for obey in said[: round(shuts / PERIOD) - 1])


@both_ways
def test_in_motion_a_fifth_of_the_zone_is_obeyed_at_once_in_either_direction(sign):
    for way in (sign, -sign):
        assert step(moved(sign), way * 0.2 * ZONE * 1.001)[1] == way * 0.2 * ZONE * 1.001
        assert step(moved(sign), way * 0.2 * ZONE)[1] == 0.0


@both_ways
def test_motion_is_over_half_a_second_after_the_last_command_that_must_be_one(sign):
    motion = moved(sign, 0.07)
    for seconds, obeys in ((0.485, True), (0.505, False)):
        hold, _ = feed(motion, sign * 0.001, seconds)
        assert (step(hold, -sign * 0.015)[1] != 0.0) == obeys
    hold, _ = feed(motion, sign * 0.001, 0.25)
    hold, _ = feed(step(hold, -sign * 0.061)[0], sign * 0.001, 0.485)
    assert step(hold, -sign * 0.015)[1] != 0.0  # it counts anew


@both_ways
def test_an_actuator_that_is_held_has_come_to_rest_within_a_twentieth_of_a_second(sign):
    for seconds, rests in ((0.045, False), (0.055, True)):
        hold, _ = feed(moved(sign), sign * 0.001, seconds, held=True)
        assert (step(hold, sign * 0.015)[1] == 0.0) == rests


@both_ways
def test_what_an_actuator_moved_at_does_not_open_the_valve_of_one_that_is_held(sign):
    """Leakage that drives the other way is fed the other way only."""
    _, said = feed(moved(sign), -sign * 0.03, 1.0, held=True)
    assert all(sign * obey <= 0.0 for obey in said)
    assert said[-1] == -sign * 0.03


def test_with_no_zone_every_command_is_obeyed():
    for command in (1e-9, -1e-9, 0.001, -0.05, 3.0):
        assert step(SHUT, command, zone=0.0)[1] == command
        assert step(moved(), command, zone=0.0)[1] == command
        assert step(opened(math.copysign(1.0, -command)), command, zone=0.0)[1] == command


@both_ways
def test_at_rest_a_valve_that_feeds_what_leaks_stays_on_its_side(sign):
    """Or a jump over an overlap thought too wide is answered by one over all of it."""
    assert feed(SHUT, sign * 0.05, 1.0, side=sign)[1][-1] == sign * 0.05
    assert not any(feed(SHUT, -sign * 0.05, 1.0, side=sign)[1])
    assert step(opened(sign), -sign * 0.05, side=-sign)[1] == 0.0
    assert step(SHUT, -sign * 0.061, side=sign)[1] == -sign * 0.061  # motion goes where it is told
    assert step(moved(sign), -sign * 0.05, side=sign)[1] == -sign * 0.05


@both_ways
def test_a_command_that_turns_round_takes_a_valve_that_feeds_back_into_its_overlap(sign):
    fed, _ = feed(SHUT, sign * 0.05, 1.0, side=sign)
    kept, said = feed(fed, -sign * 0.03, 2.0, side=sign)
    assert (kept.way, said[0], said[-1]) == (sign, -sign * 0.03, -sign * 0.03)
    assert feed(fed, -sign * 0.03, 2.0)[0].way == -sign  # nothing leaks any more


def test_what_holds_one_way_holds_the_other():
    rng = np.random.default_rng(51)
    for scale in (0.02, 0.05, 0.2):
        one = other = SHUT
        for _ in range(3000):
            command = float(rng.choice([0.0, 1.0], p=[0.05, 0.95]) * rng.normal(0.0, scale))
            held, side = bool(rng.random() < 0.2), float(rng.integers(-1, 2))
            one, obey = step(one, command, side=side, held=held)
            other, mirrored = step(other, -command, side=-side, held=held)
            assert mirrored == -obey
            assert other == (-one.slow, -one.quick, -one.way, one.calm_for)
