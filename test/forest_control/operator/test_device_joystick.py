"""Claims about a joystick of devices: what is dead ends at rest or in silence, never in old values."""

import random

import pytest

from forest_control.operator.device_joystick import (
    NOT_RESTED,
    RESTING,
    DeviceJoystick,
    DeviceParameters,
    Following,
    step,
)
from forest_control.operator.device_mapping import Reading
from forest_control.operator.joystick_watch import REST as WATCH
from forest_control.operator.joystick_watch import (
    WatchParameters,
    assessed_watch,
    joystick_sample,
    updated_watch,
)
from forest_control.operator.levers import LEFT_SHOULDER, LEFT_X, RIGHT_Y

TICK = 0.01  # [s]
STILL = DeviceParameters().frozen_timeout
HELD = frozenset({LEFT_SHOULDER})
UP = frozenset()


class Playing:
    """Devices in the test's hands, and what the joystick sends."""

    def __init__(self, *roles):
        self.joystick = DeviceJoystick((Following(),) * len(roles))
        self.readings = {role: Reading({}, UP, 0) for role in roles}
        self.now, self.sent = 100.0, None

    def report(self, role, buttons=UP, **axes):
        """A device says something."""
        before = self.readings[role]
        count = before.reports + 1 if before else 0
        self.readings[role] = Reading({PLACES[name]: v for name, v in axes.items()}, buttons, count)

    def tick(self, ticks=1):
        sent = []
        for _ in range(ticks):
            self.now += TICK
            self.joystick, self.sent = step(
                self.joystick, self.readings, self.now, DeviceParameters(), LEFT_SHOULDER
            )
            sent.append(self.sent.values)
        return sent

    def seconds_until_silent(self, limit=2 * STILL):
        begun = self.now
        while self.sent.values is not None and self.now - begun < limit:
            self.tick()
            before = self.sent.values if self.sent.values is not None else before  # noqa: F821
        assert before == RESTING
        return self.now - begun


PLACES = {"x": LEFT_X, "y": RIGHT_Y}


@pytest.fixture
def one():
    playing = Playing("pad")
    assert playing.tick() == [RESTING]
    playing.report("pad", HELD, x=0.5)
    assert playing.tick()[0].axes[LEFT_X] == 0.5
    assert playing.sent.values.buttons[LEFT_SHOULDER] == 1
    return playing


def test_what_a_device_says_is_sent_again_while_it_is_held_still(one):
    assert {values.axes[LEFT_X] for values in one.tick(200)} == {0.5}


def test_a_device_that_is_unplugged_ends_at_rest_at_once_and_then_in_silence(one):
    one.readings["pad"] = None
    assert one.tick(5) == [RESTING, None, None, None, None]


def test_a_device_that_comes_back_moves_nothing_before_it_was_released_and_centred(one):
    one.readings["pad"] = None
    one.tick(100)
    one.report("pad", HELD, x=0.5)
    assert set(one.tick(10)) == {RESTING}
    assert one.sent.problem == NOT_RESTED
    one.report("pad", HELD)  # centred, and the deadman still held
    assert set(one.tick(10)) == {RESTING}
    one.report("pad", UP, x=0.5)  # released, and still deflected
    assert set(one.tick(10)) == {RESTING}
    one.report("pad", UP, x=0.01)
    one.tick()
    one.report("pad", HELD, x=0.5)
    assert one.tick()[0].axes[LEFT_X] == 0.5


@pytest.mark.parametrize(("buttons", "axes"), [(HELD, {"x": 0.5}), (HELD, {}), (UP, {"x": 0.5})])
def test_a_driver_that_hangs_ends_at_rest_and_in_silence_after_the_timeout(one, buttons, axes):
    one.report("pad", buttons, **axes)
    one.tick()
    assert one.seconds_until_silent() == pytest.approx(STILL, abs=3 * TICK)
    one.report("pad", HELD, x=0.6)  # it wakes up
    assert set(one.tick(5)) == {RESTING}


def test_a_noisy_device_that_hangs_ends_within_two_seconds(one):
    noise = random.Random(1)
    for _ in range(1000):
        one.report("pad", HELD, x=0.5 + 0.001 * noise.random())
        one.tick()
    assert one.seconds_until_silent() < 2.1


def test_a_device_at_rest_may_be_still_for_ever(one):
    one.report("pad", UP, x=0.02)
    assert None not in one.tick(3000)
    one.report("pad", HELD, x=0.02)
    one.tick()
    one.report("pad", HELD, x=0.4)
    assert one.tick()[0].axes[LEFT_X] == 0.4


def test_another_device_that_moves_does_not_hide_one_that_hangs():
    two = Playing("left", "right")
    two.tick()
    two.report("left", HELD, x=0.5)
    for k in range(round(STILL / TICK) + 5):
        two.report("right", UP, y=0.3 + 0.001 * (k % 7))
        two.tick()
        assert two.sent.values is None or two.sent.values == RESTING or k < STILL / TICK + 1
    assert two.sent.values is None
    assert "left" in two.sent.problem


def test_two_devices_are_one_joystick_and_one_that_is_missing_rests_both():
    two = Playing("left", "right")
    two.tick()
    two.report("left", HELD, x=0.5)
    two.report("right", UP, y=-0.25)
    (values,) = two.tick()
    assert (values.axes[LEFT_X], values.axes[RIGHT_Y], values.buttons[LEFT_SHOULDER]) == (0.5, -0.25, 1)
    two.readings["right"] = None
    assert two.tick(3) == [RESTING, None, None]
    two.report("right")
    assert set(two.tick(3)) == {RESTING}


def test_nothing_is_sent_before_a_device_was_there():
    playing = Playing("pad")
    playing.readings["pad"] = None
    assert set(playing.tick(10)) == {None}


@pytest.mark.parametrize("end", ["unplugged", "hung"])
def test_the_controllers_watch_stops_for_a_dead_device(one, end):
    """From the sample to what the controller may act on."""
    watch, before, moving = WATCH, None, []
    one.report("pad")
    for k in range(round((STILL + 1.0) / TICK)):
        if k == 5:
            one.report("pad", HELD)
        elif 5 < k < 100:
            one.report("pad", HELD, x=0.004 * k)
        elif k == 100 and end == "unplugged":
            one.readings["pad"] = None
        (values,) = one.tick()
        if values is not None:
            stamp = round(one.now * 1e9)
            watch = updated_watch(
                watch, joystick_sample(stamp, "joy", one.now, values, before, LEFT_SHOULDER)
            )
            before = values
        watch, operator = assessed_watch(watch, one.now, True, WatchParameters())
        moving.append(operator.enabled and operator.levers.swing != 0.0)
    assert moving[99]
    assert sum(moving) == pytest.approx(94 + (end == "hung") * STILL / TICK, abs=3)
    assert not moving[-1]
