"""Claims about stillness: a device that hangs is told from a hand that holds still by its own past."""

import copy
import csv
import math

import numpy as np
import pytest
from recorded import recorded

from forest_control.operator.joystick_watch import (
    NO_HEARTBEAT,
    REST,
    Joystick,
    Sample,
    WatchParameters,
    assessed_watch,
    is_released,
    problem_text,
    updated_watch,
)
from forest_control.operator.levers import Levers

P = WatchParameters()
HELD = 0.39


class Device:
    """A joystick of some period [s] behind the watch; what it says comes as (levers, another axis)."""

    def __init__(self, period=0.01, p=P):
        self.period, self.p, self.now = period, p, 0.0
        self.watch, self.before = REST, None

    def say(self, swing=0.0, boom=0.0, other=0.0, **changes):
        """Return whether the levers count after one more sample."""
        self.now += self.period
        return self.said(Levers(swing, boom, 0.0), other, **changes)

    def said(self, levers, other=0.0, **changes):
        same, self.before = (levers, other) == self.before, (levers, other)
        sample = Sample(self.now, round(self.now * 1e9), NO_HEARTBEAT, same, True, levers, held=True)
        self.watch = updated_watch(self.watch, sample._replace(**changes))
        return self.look()

    def look(self, wait=0.0):
        self.now += wait
        self.watch, (self.levers, enabled) = assessed_watch(self.watch, self.now, True, self.p)
        return enabled

    def jitter(self, seconds, about=HELD, bits=16, rng=None):
        """Be held about a deflection, with the noise of a converter: three of its last bits, rms."""
        rng, half = rng or np.random.default_rng(3), 2 ** (bits - 1) - 1
        for noise in rng.normal(0.0, 3.0, round(seconds / self.period)).tolist():
            assert self.say(max(-1.0, min(1.0, round(about * half + noise) / half)))
        return self

    def frozen_after(self, *levers, limit=20.0):
        """Return how long [s] the same levers count."""
        self.say(*levers)
        begun = self.now
        while self.say(*levers) and self.now - begun < limit:
            pass
        return self.now - begun


def armed(**options):
    device = Device(**options)
    assert device.say()
    return device


KNOWN = armed().jitter(45.0)


def restless():
    """A joystick of which 45 s of restless play are known."""
    return copy.copy(KNOWN)


@pytest.mark.parametrize(
    ("played", "after"), [(5.0, 4.0), (10.0, 2.0), (20.0, 1.0), (40.0, 0.5), (60.0, 0.5)]
)
def test_a_converter_with_noise_that_hangs_is_frozen_the_sooner_the_longer_it_was_restless(played, after):
    device = armed().jitter(played)
    assert device.frozen_after(HELD, 0.2) == pytest.approx(after, abs=0.01 + 0.02 * after)
    assert device.watch.joystick == Joystick.FROZEN
    assert problem_text(device.watch).startswith("joystick: held still to the last bit")
    assert not is_released(device.watch, P.centre)


@pytest.mark.parametrize("levers", [(-HELD,), (0.0, -HELD), (1.0, HELD), (0.0, 1.0, -HELD)])
def test_one_lever_in_play_is_enough_whichever_way_it_is_deflected(levers):
    watch = restless().watch._replace(levers=Levers(*levers, *(0.0,) * (3 - len(levers))), moved=100.0)
    for still, state in ((0.5 - 1e-9, Joystick.ALIVE), (0.5, Joystick.FROZEN)):
        now = 100.0 + still
        assert assessed_watch(watch._replace(fresh_since=now), now, True, P)[0].joystick == state
    told = Sample(100.2, 10**12, NO_HEARTBEAT, False, True, watch.levers, held=True)
    assert updated_watch(watch._replace(fresh_since=100.1), told).restless == pytest.approx(
        watch.restless + 0.2
    )


def test_half_a_second_of_restless_play_counts_where_the_user_waits_for_a_minute():
    watch = restless().watch._replace(restless=0.5, moved=100.0)
    for still, state in ((40.0 - 1e-9, Joystick.ALIVE), (40.0, Joystick.FROZEN)):
        now = 100.0 + still
        p = P._replace(frozen_timeout=60.0)
        assert assessed_watch(watch._replace(fresh_since=now), now, True, p)[0].joystick == state


@pytest.mark.parametrize("period", [0.002, 0.02, 0.05])
def test_so_at_every_rate(period):
    assert armed(period=period).jitter(45.0).frozen_after(HELD) == pytest.approx(0.5, abs=1.1 * period)


@pytest.mark.parametrize("period", [0.01, 0.05])
def test_a_hand_on_a_quantised_stick_may_hold_still_once_it_did(period):
    """Fast and slow movements on 8 bits, a tremor that comes and goes, and holds of more than `STILLNESS`."""
    device, rng = armed(period=period), np.random.default_rng(8)
    for _ in range(30):
        for k in range(round(1.0 / period)):
            device.say(round(127 * (0.4 + 0.2 * np.sin(6.0 * k * period)) + rng.normal(0.0, 0.6)) / 127)
        for _ in range(round(0.4 / period)):
            device.say(50 / 127)
    for _ in range(round(2.94 / period)):
        assert device.say(HELD)
    assert device.frozen_after(HELD) == pytest.approx(P.frozen_timeout - 2.94, abs=2.1 * period)


def test_a_joystick_that_is_not_known_yet_may_hold_still_for_frozen_timeout():
    assert armed().frozen_after(HELD) == pytest.approx(P.frozen_timeout, abs=0.011)


@pytest.mark.parametrize("hold", [0.24, 0.27])
def test_a_hold_longer_than_a_quarter_second_tells_a_still_hand(hold):
    device = restless()
    for _ in range(round(hold / device.period)):
        assert device.say(HELD)
    device.jitter(45.0)
    after = 0.5 if hold < 0.25 else P.frozen_timeout
    assert device.frozen_after(HELD) == pytest.approx(after, abs=0.011)


def test_a_button_or_another_axis_that_changes_shows_life():
    device = restless()
    for k in range(500):
        assert device.say(HELD, other=k // 20)
    assert device.frozen_after(HELD, 0.0) == pytest.approx(0.5, abs=0.011)


@pytest.mark.parametrize("levers", [(1.0, 0.0), (-1.0, 1.0), (1.0, -1.0)])
def test_at_an_end_where_the_clamp_hides_the_noise_it_may_hold_still(levers):
    device = restless()
    assert device.frozen_after(*levers) == pytest.approx(P.frozen_timeout, abs=0.011)


def test_rest_and_ends_teach_nothing():
    device = armed()
    for k in range(9000):
        assert device.say(float(k % 3 - 1), 0.0, other=k)
    assert device.frozen_after(HELD) == pytest.approx(P.frozen_timeout, abs=0.011)
    device = restless()
    for levers in ((0.0, 0.0), (1.0, 0.0)):
        for _ in range(100):
            assert device.say(*levers)
        device.jitter(1.0)
    assert device.frozen_after(HELD) == pytest.approx(0.5, abs=0.011)


def test_a_device_that_hung_and_goes_on_is_learnt_anew_and_not_taken_for_a_still_hand():
    device = restless()
    device.frozen_after(HELD)
    assert not device.say(HELD, 0.01)  # alive, but deflected
    assert device.watch.joystick == Joystick.ALIVE
    assert device.say()
    assert device.jitter(5.0).frozen_after(HELD) == pytest.approx(4.0, rel=0.02)
    assert device.say()
    assert device.jitter(45.0).frozen_after(HELD) == pytest.approx(0.5, abs=0.011)


def test_silence_is_no_hold_and_no_play():
    device = armed().jitter(5.0)
    for _ in range(100):
        assert not device.look(10.0)
        assert device.watch.joystick == Joystick.LOST
        device.say()
        device.jitter(0.05)
    assert 10.0 < device.watch.restless < 40.0  # 0.25 s at most of each silence
    assert 0.5 < device.frozen_after(HELD) < 2.0


def test_what_is_learnt_is_the_time_in_play_between_changes():
    device = Device()
    for k in range(1, 7):
        device.say(0.1 * k)
    assert device.watch.restless == pytest.approx(5 * device.period)
    for _ in range(30):  # a hold from almost the first moment on
        device.say(0.1)
    device.say(0.2)
    assert device.watch.restless == -math.inf
    device.say(0.3)
    assert device.watch.restless == -math.inf


@pytest.mark.parametrize(("still", "learnt"), [(0.25, 3.25), (0.25 + 1e-9, -math.inf)])
def test_a_quarter_second_is_no_hold_yet(still, learnt):
    watch = restless().watch._replace(moved=2.0, fresh_since=2.0 + still, restless=3.0)
    assert (
        updated_watch(
            watch, Sample(2.5, 10**12, NO_HEARTBEAT, False, True, Levers(0.4, 0.0, 0.0), True)
        ).restless
        == learnt
    )


def test_a_joystick_that_cannot_be_read_is_named_so_whatever_its_driver_does():
    device = Device()
    device.say(0.1, good=False)
    assert problem_text(device.watch) == "joystick: its last sample cannot be read"


def test_a_heartbeat_teaches_nothing_of_the_hand():
    device = armed()
    for k in range(9000):
        assert device.say(0.3 + 1e-5 * k, heartbeat=k)
    assert device.frozen_after(HELD) == pytest.approx(P.frozen_timeout, abs=0.011)


@pytest.mark.parametrize(("given", "after"), [(0.2, 0.2), (1.0, 0.5), (0.0, 20.0)])
def test_frozen_timeout_is_the_longest_and_zero_lets_all_hold_still(given, after):
    device = restless()
    device.p = P._replace(frozen_timeout=given)
    assert device.frozen_after(HELD) == pytest.approx(after, abs=0.011)


def test_a_frozen_stick_near_the_centre_counts_as_centred():
    device = restless()
    for _ in range(200):
        assert device.say(0.03)  # it counts as live
        still = device.now - device.watch.moved
        assert device.levers.swing == (0.03 if still < 0.5 else 0.0)
    assert still > 1.0


def test_a_driver_that_speaks_only_on_change_is_named_when_a_still_hand_makes_it_silent():
    device = armed()
    for k in range(100):
        assert device.say(0.001 + 0.004 * k)
    assert problem_text(device.watch) == problem_text(REST) == ""
    assert not device.look(P.joy_timeout + 0.01)
    assert "never repeats a sample" in problem_text(device.watch)
    for _ in range(2):
        device.say(HELD)
    assert not device.look(P.joy_timeout + 0.01)
    assert problem_text(device.watch) == "joystick: nothing new for longer than joy_timeout"


def test_a_persons_record_never_looks_frozen_and_may_hold_still_for_three_seconds():
    with recorded("operator_levers.csv").open(newline="") as file:
        rows = [tuple(map(float, row)) for row in list(csv.reader(file))[1:]]
    device, later = armed(), 0.0
    for place, (time, *levers) in enumerate(rows):
        device.now = 1.0 + time + later
        device.said(Levers(*levers))
        assert device.watch.joystick == Joystick.ALIVE
        if abs(levers[0]) > 0.3 and place % 25 == 0:  # here the hand holds still
            for _ in range(59):
                device.now += 0.05
                later += 0.05
                device.said(Levers(*levers))
                assert device.watch.joystick == Joystick.ALIVE
    assert later > 10 * 2.94
