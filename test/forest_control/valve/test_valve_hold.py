"""Claims about when a small command opens a valve: motion does at once, noise does not, no cycle lasts."""

import math

import numpy as np
import pytest

from forest_control.valve.valve_hold import SHUT, held_command

ZONE, NOISE, PERIOD = 0.02, 0.06, 0.005  # [V], [V], [s]
both_ways = pytest.mark.parametrize("sign", [1.0, -1.0], ids=["positive", "negative"])


def step(hold, command, zone=ZONE, opens=None, noise=NOISE, held=False, learns=False):
    return held_command(hold, command, zone, zone if opens is None else opens, noise, held, learns, PERIOD)


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
        assert hold.last == sign
    assert step(feed(moved(sign), 0.0, 1.0)[0], -sign * 0.019)[1] == 0.0


@both_ways
def test_a_command_that_cannot_be_noise_is_obeyed_at_once(sign):
    rest, _ = feed(SHUT, sign * 0.001, 1.0)
    for noise, bound in ((NOISE, NOISE), (0.0, 1.5 * ZONE)):
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


def opened_again(hold, sign, shut=0.1, **options):
    """Shut for some seconds, then opened: what a cycle does."""
    hold, _ = feed(hold, 0.0, shut)
    return step(hold, sign * max(0.05, 0.55 * hold.wide * ZONE), **options)[0]


@both_ways
def test_a_cycle_doubles_its_zone_each_time_up_to_a_bound(sign):
    hold, wides = step(SHUT, sign * 0.05)[0], []
    for k in range(1, 9):
        hold = opened_again(hold, sign * (-1.0) ** k, noise=9.0)
        wides.append(hold.wide)
    fading = math.exp(-0.105 / 5.0)
    expected, wide = [], 1.0
    for _ in range(8):
        wide = min(32.0, 2.0 * (1.0 + (wide - 1.0) * fading))
        expected.append(wide)
    assert wides == pytest.approx(expected, rel=1e-9)
    assert max(wides) == 32.0


@both_ways
def test_the_first_turn_is_no_cycle_yet_and_the_second_needs_twice_the_command(sign):
    once = opened_again(step(SHUT, sign * 0.05)[0], -sign)
    assert step(feed(once, 0.0, 0.1)[0], sign * 0.0201)[1] != 0.0
    twice = opened_again(once, sign)
    rest, _ = feed(twice, 0.0, 0.1)
    half = 0.5 * step(rest, 0.0)[0].wide * ZONE
    assert half == pytest.approx(2.0 * ZONE, rel=0.05)
    assert step(rest, -sign * half * 0.999)[1] == 0.0
    assert step(rest, -sign * half * 1.001)[1] != 0.0


@both_ways
def test_what_is_briefer_than_noise_or_later_than_a_second_is_no_cycle(sign):
    for shut, cycle in ((0.03, False), (0.06, True), (0.9, True), (1.1, False)):
        assert (opened_again(step(SHUT, sign * 0.05)[0], -sign, shut).wide > 1.5) == cycle, shut


@both_ways
def test_a_valve_that_noise_keeps_shut_for_a_while_is_shut_as_one_without_command(sign):
    hold, _ = step(SHUT, sign * 0.05)
    hold, said = feed(hold, sign * 0.001, 0.3)
    assert said[-1] == 0.0
    assert feed(hold, -sign * 0.05, 0.3)[0].wide == pytest.approx(2.0, rel=0.1)
    hold, _ = feed(hold, sign * 0.001, 1.2)
    assert feed(hold, -sign * 0.05, 0.3)[0].wide == 1.0


@both_ways
def test_what_opens_again_the_same_way_is_slow_motion_unless_it_feeds_what_leaks(sign):
    before = step(SHUT, sign * 0.05)[0]
    assert opened_again(before, sign).wide == 1.0
    assert opened_again(before, sign, held=True).wide == 2.0


def turning(every, command=0.1, turns=3):
    """How wide the zone is after some turns in motion, so many seconds each, without a pause."""
    hold = SHUT
    for k in range(turns + 1):
        hold, _ = feed(hold, command * (-1.0) ** k, every)
    return hold.wide


def test_a_valve_that_turns_without_a_pause_cycles_too_but_not_if_briefly_or_seldom():
    assert turning(0.06, turns=1) == turning(0.06, -0.1, turns=1) == 1.0  # none came before
    assert turning(0.06, turns=2) == pytest.approx(2.0, rel=0.05)
    assert turning(0.06, turns=3) == pytest.approx(4.0, rel=0.05)
    assert turning(0.9, turns=2) == pytest.approx(2.0, rel=0.2)
    assert turning(0.03) == turning(1.1) == 1.0


@both_ways
def test_a_cycle_is_forgotten_in_five_seconds_and_at_once_by_a_command_that_none_reaches(sign):
    wide = SHUT._replace(wide=9.0)
    assert feed(wide, 0.0, 5.0)[0].wide == pytest.approx(1.0 + 8.0 * math.exp(-1.0))
    assert step(wide, sign * 14.0 * ZONE * 1.001)[0].wide == 1.0
    assert step(wide, sign * 14.0 * ZONE)[0].wide > 8.9
    assert step(wide, sign * 0.4, noise=0.5)[0].wide > 8.9  # it may be noise


@both_ways
@pytest.mark.parametrize(("wide", "times"), [(4.0, 2.0), (32.0, 5.0)])
def test_after_a_cycle_motion_begins_from_twice_or_at_most_five_times_the_command_on(sign, wide, times):
    wide = SHUT._replace(wide=wide)
    bound = 1.5 * times * ZONE
    assert step(wide, sign * bound * 1.001, noise=0.0, opens=9.0)[1] == sign * bound * 1.001
    assert step(wide, sign * bound * 0.99, noise=0.0, opens=9.0)[1] == 0.0
    # Learning the overlap ends the cycle, so no motion need wait.
    assert step(wide, sign * 1.501 * ZONE, noise=0.0, opens=9.0, learns=True)[1] != 0.0
    assert step(wide, sign * 1.499 * ZONE, noise=0.0, opens=9.0, learns=True)[1] == 0.0


def test_what_holds_one_way_holds_the_other():
    rng = np.random.default_rng(51)
    for scale in (0.02, 0.05, 0.2):
        one = other = SHUT
        for _ in range(3000):
            command = float(rng.choice([0.0, 1.0], p=[0.05, 0.95]) * rng.normal(0.0, scale))
            held = bool(rng.random() < 0.2)
            one, obey = step(one, command, held=held)
            other, mirrored = step(other, -command, held=held)
            assert mirrored == -obey
            assert other == (-one.slow, -one.quick, -one.way, -one.last, *one[4:])
