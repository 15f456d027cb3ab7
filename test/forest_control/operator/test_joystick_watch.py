"""Claims about the joystick's watch: what is lost, frozen or deflected from the start moves nothing."""

import itertools
import math

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule
from properties import holds

from forest_control.operator.joystick_watch import (
    NO_HEARTBEAT,
    NO_STAMP,
    REST,
    Joystick,
    Sample,
    WatchParameters,
    assessed_watch,
    heartbeat_of,
    is_deflected_unarmed,
    is_released,
    joystick_sample,
    unreadable_sample,
    updated_watch,
)
from forest_control.operator.levers import REST as CENTRED
from forest_control.operator.levers import Levers
from forest_msgs_py.runtime.parameter_table import table_rows

P = WatchParameters()
PERIOD = 0.01
PUSHED = Levers(0.5, 0.0, -0.2)


class OperatorProfile:
    """A joystick in simulated time: what it says next can be changed."""

    def __init__(self, p=P):
        self.p, self.now, self.watch, self.before = p, 0.0, REST, None
        self.operator = None

    def say(self, levers, held=True, **changes):
        """One period on, a sample comes, and is judged."""
        self.hear(levers, held, **changes)
        return self.look()

    def hear(self, levers, held=True, **changes):
        self.now += PERIOD
        content = (levers, held)
        sample = Sample(
            self.now, round(self.now * 1e9), NO_HEARTBEAT, content == self.before, True, levers, held
        )
        self.before = content
        self.watch = updated_watch(self.watch, sample._replace(**changes))

    def look(self, wait=0.0, allowed=True):
        self.now += wait
        self.watch, self.operator = assessed_watch(self.watch, self.now, allowed, self.p)
        return self.operator.enabled

    def arm(self):
        assert self.say(CENTRED)
        assert self.say(PUSHED)
        return self


def test_a_centred_stick_and_the_deadman_arm_and_then_levers_pass():
    hand = OperatorProfile()
    assert not hand.look()
    assert hand.watch.joystick == Joystick.SILENT
    assert not hand.say(CENTRED, held=False)
    hand.arm()
    assert hand.operator.levers == PUSHED


def test_the_defaults_are_those_of_the_safety_document():
    assert WatchParameters() == (0.15, 10.0, 0.05)  # timeout, frozen_timeout [s], centre


@pytest.mark.parametrize("lever", range(3))
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_up_to_centre_and_no_further_each_lever_counts_as_centred(lever, side):
    for deflection, armed in ((0.05, True), (0.0501, False)):
        hand, levers = OperatorProfile(), [0.0, 0.0, 0.0]
        levers[lever] = side * deflection
        assert hand.say(Levers(*levers)) == armed
        assert is_released(hand.watch._replace(held=False), 0.05) == armed


def test_at_its_very_timeout_a_joystick_is_not_lost_yet_and_at_its_time_it_is_frozen():
    p = P._replace(joy_timeout=0.25)
    watch = OperatorProfile().arm().watch._replace(fresh_since=4.0, moved=2.0, restless=10.0)
    assert assessed_watch(watch._replace(moved=4.0), 4.25, True, p)[0].joystick == Joystick.ALIVE
    assert assessed_watch(watch._replace(moved=4.0), 4.25 + 1e-9, True, p)[0].joystick == Joystick.LOST
    assert assessed_watch(watch, 4.0, True, p)[0].joystick == Joystick.FROZEN
    assert assessed_watch(watch, 4.0 - 1e-9, True, p)[0].joystick == Joystick.ALIVE


def test_enabling_with_a_deflected_stick_moves_nothing_until_it_is_centred():
    hand = OperatorProfile()
    for k in range(50):
        assert not hand.say(Levers(0.5 + 0.001 * k, 0.0, 0.0))
        assert hand.operator.levers == CENTRED
    assert hand.say(Levers(0.0, 0.04, 0.0))
    assert hand.say(PUSHED)


def test_release_always_commands_zero_and_needs_a_centred_stick_again():
    hand = OperatorProfile().arm()
    assert not hand.say(PUSHED, held=False)
    assert hand.operator.levers == CENTRED
    assert not hand.say(PUSHED)
    hand.arm()


def test_a_joystick_that_falls_silent_is_lost_after_the_timeout_and_must_be_centred():
    hand = OperatorProfile().arm()
    assert hand.look(0.15 - 1e-9)
    assert not hand.look(2e-9)
    assert hand.watch.joystick == Joystick.LOST
    assert not hand.say(PUSHED)
    assert hand.watch.joystick == Joystick.ALIVE
    hand.arm()


def test_a_stamp_that_stands_still_is_a_lost_joystick():
    hand, wobble = OperatorProfile().arm(), itertools.count(1)
    stamp, lost_after = hand.watch.stamp, hand.now + P.joy_timeout
    while hand.say(Levers(0.5, 0.001 * next(wobble), 0.0), stamp=stamp):
        assert hand.now <= lost_after + 1e-9
    assert hand.watch.joystick == Joystick.LOST
    assert not hand.say(CENTRED, stamp=stamp)


def test_held_still_while_deflected_it_is_frozen_after_its_time_and_moves_nothing_until_centred():
    hand = OperatorProfile().arm()
    begun = hand.now
    while hand.say(PUSHED):
        assert hand.now - begun < 2.0 * P.frozen_timeout
    assert hand.now - begun == pytest.approx(P.frozen_timeout, abs=PERIOD)
    assert hand.watch.joystick == Joystick.FROZEN
    assert not hand.say(Levers(0.5, 0.01, -0.2))  # alive, but deflected
    assert hand.watch.joystick == Joystick.ALIVE
    hand.arm()


@pytest.mark.parametrize(
    ("p", "still"), [(P._replace(frozen_timeout=0.0), PUSHED), (P, CENTRED), (P, Levers(0.03, 0.0, 0.0))]
)
def test_still_is_not_frozen_when_switched_off_or_near_the_centre(p, still):
    hand = OperatorProfile(p).arm()
    for _ in range(1100):
        assert hand.say(still)
    assert hand.operator.levers == (PUSHED if still == PUSHED else CENTRED)


def test_a_heartbeat_lets_a_source_hold_still_and_one_that_stops_counting_is_lost():
    hand, count = OperatorProfile().arm(), itertools.count()
    for _ in range(500):
        assert hand.say(PUSHED, heartbeat=next(count))
    stopped = hand.now
    while hand.say(PUSHED, heartbeat=499):
        assert hand.now - stopped <= P.joy_timeout + 1e-9
    assert hand.watch.joystick == Joystick.LOST


def test_a_heartbeat_that_begins_anew_is_new():
    hand = OperatorProfile().arm()
    for count in (900, 901, 0, 1, 2, 900, 17):
        for _ in range(10):
            assert hand.say(PUSHED, heartbeat=count)
            assert hand.watch.heartbeat == count


def test_a_first_sample_counts_whatever_its_stamp():
    for stamp in (-5, 1, 2**62):
        hand = OperatorProfile()
        assert hand.say(CENTRED, stamp=stamp)
        assert hand.watch.stamp == stamp
        hand.say(PUSHED, stamp=stamp)  # it stands still
        assert hand.watch.levers == CENTRED
        assert hand.say(PUSHED, stamp=stamp + 1)


def test_without_a_stamp_content_alone_decides():
    hand = OperatorProfile()
    hand.say(CENTRED, stamp=0)
    assert hand.say(PUSHED, stamp=0)
    begun = hand.now
    while hand.say(PUSHED, stamp=0):
        assert hand.now - begun < 2.0 * P.frozen_timeout
    assert hand.now - begun == pytest.approx(P.frozen_timeout, abs=2 * PERIOD)


def test_a_sample_from_before_is_dropped_and_counted_until_the_joystick_is_lost():
    hand = OperatorProfile().arm()
    for k in range(10):
        assert hand.say(Levers(-1.0, 0.01 * k, 1.0), stamp=hand.watch.stamp - 1)
        assert hand.operator.levers == PUSHED
    assert hand.watch.out_of_order == 10
    while hand.say(PUSHED, stamp=5):
        pass
    assert hand.watch.joystick == Joystick.LOST
    hand.say(CENTRED, stamp=6)  # a source that was started anew, its clock set back
    assert hand.say(PUSHED, stamp=7)


@pytest.mark.parametrize("back", [0, 1, 10**9])
def test_a_release_is_obeyed_in_any_order_and_needs_a_centred_stick_again(back):
    """Two joysticks on one topic, say, of which one has the later clock."""
    hand = OperatorProfile().arm()
    assert not hand.say(PUSHED, held=False, stamp=hand.watch.stamp - back)
    assert not hand.say(PUSHED)
    hand.arm()


def test_a_sample_that_cannot_be_read_stops_and_disarms():
    hand = OperatorProfile().arm()
    assert not hand.say(PUSHED, good=False)
    assert hand.watch.joystick == Joystick.BAD
    assert not hand.say(PUSHED)
    hand.arm()


@pytest.mark.parametrize("what", [{"held": False}, {"good": False}, {"held": False, "stamp": 5}])
@pytest.mark.parametrize("same_stamp", [False, True])
def test_what_disarms_counts_though_the_next_sample_comes_before_anybody_judges(what, same_stamp):
    hand = OperatorProfile().arm()
    usual = Sample(hand.now, hand.watch.stamp + 1, NO_HEARTBEAT, False, True, PUSHED, True)
    between = usual._replace(**({"stamp": hand.watch.stamp} if same_stamp else {}) | what)
    hand.watch = updated_watch(updated_watch(hand.watch, between), usual._replace(stamp=hand.watch.stamp + 2))
    assert not hand.look()
    hand.arm()


def test_what_else_forbids_motion_disarms():
    hand = OperatorProfile().arm()
    assert not hand.look(allowed=False)
    assert not hand.say(PUSHED)
    hand.arm()


def test_what_a_deflected_stick_waits_for_is_known_while_nothing_else_is_in_the_way():
    watch = REST._replace(joystick=Joystick.ALIVE, held=True, levers=PUSHED)
    assert is_deflected_unarmed(watch, P.centre)
    for else_ in (
        {"joystick": Joystick.LOST},
        {"held": False},
        {"armed": True},
        {"levers": CENTRED},
    ):
        assert not is_deflected_unarmed(watch._replace(**else_), P.centre)


def test_a_reset_needs_the_deadman_released_and_levers_centred_as_the_last_words():
    hand = OperatorProfile()
    assert is_released(hand.watch, P.centre)
    for levers, held, released in ((CENTRED, True, False), (PUSHED, False, False), (CENTRED, False, True)):
        hand.say(levers, held)
        assert is_released(hand.watch, P.centre) == released
        hand.look(1.0)
        assert is_released(hand.watch, P.centre) == released
    hand.say(CENTRED, held=False, good=False)
    assert not is_released(hand.watch, P.centre)


class Watched(RuleBasedStateMachine):
    """What comes in any order, against a plain statement of the rule."""

    def __init__(self):
        super().__init__()
        self.hand = OperatorProfile()
        self.held = self.alive = self.centred = False
        self.levers, self.fresh, self.stamp = CENTRED, -math.inf, 0

    @rule(
        levers=st.just(CENTRED) | st.builds(Levers, *[st.floats(-1.0, 1.0)] * 3),
        held=st.sampled_from((True, True, True, False)),
        late=st.sampled_from((0, 0, 0, 0, 1, 7)),
        good=st.sampled_from((True, True, True, True, False)),
    )
    def a_sample_comes(self, levers, held, late, good):
        newer = self.hand.watch.stamp if late else round((self.hand.now + PERIOD) * 1e9) - 1
        stamp = newer + 1 - late
        self.hand.hear(levers, held, stamp=stamp, good=good)
        if not good:
            self.held = self.alive = False
            self.fresh = self.hand.now
        elif stamp != NO_STAMP and (stamp == self.stamp or (stamp < self.stamp and self.alive)):
            self.held = self.held and held
        else:
            self.held, self.alive, self.levers = held, True, levers
            self.fresh, self.stamp = self.hand.now, stamp
        self.centred = self.centred and self.held

    @rule(wait=st.sampled_from((0.0, 0.0, 0.1, 0.149, 0.2)), allowed=st.sampled_from((True, True, False)))
    def somebody_looks(self, wait, allowed):
        enabled = self.hand.look(wait, allowed)
        self.alive = self.alive and self.hand.now - self.fresh <= 0.15
        may = self.alive and self.held and allowed
        self.centred = may and (self.centred or max(map(abs, self.levers)) <= 0.05)
        assert enabled == self.centred
        assert self.hand.operator.levers == (self.levers if enabled else CENTRED)


def test_whatever_comes_levers_pass_only_live_held_and_once_centred():
    holds(Watched, examples=30, steps=40)


def test_a_messages_sample_says_what_the_watch_needs():
    axes, deadman = (0.1, 0.2, 0.9, -0.3), 2
    rest, again = ((tuple([0.0] * 4), tuple([0] * 4)) for _ in range(2))
    made = joystick_sample(7, "heartbeat:3", 1.5, (axes, (0, 0, 1, 0)), rest, deadman)
    assert made == Sample(1.5, 7, 3, False, True, Levers(0.1, -0.3, 0.2), held=True)
    for buttons in ((1, 1, 0, 1), (0, 0, 2, 0), (0, 0, -1, 0)):
        assert not joystick_sample(7, "", 1.5, (axes, buttons), None, deadman).held
    for before, same in (
        (None, False),
        (again, True),
        ((rest[0], (0, 0, 0, 1)), False),
        ((axes, rest[1]), False),
    ):
        assert joystick_sample(7, "", 1.5, rest, before, deadman).same == same
    assert joystick_sample(7, "", 1.5, rest, rest, deadman).heartbeat == NO_HEARTBEAT


def test_what_cannot_be_read_has_no_stamp_no_heartbeat_and_no_levers():
    assert unreadable_sample(1.5) == Sample(1.5, 0, NO_HEARTBEAT, False, False, CENTRED, False)


@pytest.mark.parametrize(
    ("frame", "count"),
    [
        *(("heartbeat:0", 0), ("heartbeat:123", 123), ("joystick", NO_HEARTBEAT), ("", NO_HEARTBEAT)),
        *(("heartbeat:", NO_HEARTBEAT), ("heartbeat:-3", NO_HEARTBEAT), ("heartbeat:²", NO_HEARTBEAT)),
        *(("123", NO_HEARTBEAT), ("a heartbeat:1", NO_HEARTBEAT), ("heartbeat:1 ", NO_HEARTBEAT)),
        *(("heartbeat:" + "9" * 18, 10**18 - 1), ("heartbeat:" + "9" * 19, NO_HEARTBEAT)),
    ],
)
def test_the_heartbeat_is_read_from_the_frame_id(frame, count):
    assert NO_HEARTBEAT < 0  # no count is negative
    assert heartbeat_of(frame) == count


def test_nobody_may_choose_to_believe_a_joystick_that_has_been_silent_for_long():
    told = {row.name: (row.low, row.default, row.high) for row in table_rows(WatchParameters)}
    assert told == {
        "joy_timeout": (0.01, 0.15, 2.0),
        "frozen_timeout": (0.0, 10.0, 60.0),
        "centre": (0.001, 0.05, 0.5),
    }
