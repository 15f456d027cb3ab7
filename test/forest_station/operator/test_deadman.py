"""The deadman of a page, judged by receive times: what holds it, and after what it must be pressed anew."""

import math

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule
from properties import holds

from forest_station.operator.deadman import REST, Deadman, State, expiry, heard_hands, judged, stopped, text
from forest_station.operator.hands_message import Hands

TIMEOUT, ROUND_TRIP = 0.08, 0.25  # [s] bounds of the safety page
PERIOD = 0.02  # [s] of a page's messages
WAY = 0.003  # [s]
CENTRED = (0.0,) * 6
DEFLECTED = (0.0, 0.0, 0.0, 0.5, 0.0, 0.0)


class Page:
    """A page whose clock began at another time; messages reach the deadman after a way."""

    def __init__(self, ahead=1000.0):
        self.now, self.ahead, self.number = 50.0, ahead, 0
        self.deadman: Deadman = REST

    def message(self, held, axes=CENTRED):
        self.number += 1
        return Hands(held, self.number, self.now + self.ahead, axes, 0, 1)

    def send(self, held, axes=CENTRED, way=WAY, round_trip=0.02):
        self.deadman = heard_hands(self.deadman, self.message(held, axes), self.now + way, round_trip)
        self.now += PERIOD
        return self.deadman.state

    def press(self):
        self.send(False)
        assert self.send(True) == State.HELD
        return self


def test_released_and_centred_then_pressed_it_is_held():
    page = Page()
    assert page.send(False) == State.READY
    assert page.send(True) == State.HELD
    assert page.send(True, DEFLECTED) == State.HELD


def test_held_from_the_beginning_it_moves_nothing():
    page = Page()
    assert {page.send(True) for _ in range(100)} == {State.WAITING}


def test_released_with_levers_away_from_the_centre_it_waits():
    page = Page()
    assert page.send(False, DEFLECTED) == State.WAITING
    assert page.send(True, DEFLECTED) == State.WAITING
    assert page.send(False) == State.READY


def test_without_a_heartbeat_it_ends_within_the_timeout_and_not_before():
    page = Page().press()
    last = page.deadman.heartbeat
    assert judged(page.deadman, last + TIMEOUT - 1e-6).state == State.HELD
    ended = judged(page.deadman, last + TIMEOUT)
    assert ended.state == State.WAITING
    assert "too late" in text(ended)
    assert expiry(page.deadman) == last + TIMEOUT
    assert expiry(ended) == math.inf


def test_a_message_after_a_gap_does_not_go_on():
    page = Page().press()
    page.now += TIMEOUT
    assert page.send(True) == State.WAITING
    assert page.send(True) == State.WAITING
    assert page.send(False) == State.READY


def test_a_server_that_was_late_itself_hears_that_it_was_held_all_the_time():
    page = Page().press()
    waited, late = [], page.now + 0.07  # 0.087 s after the last heartbeat
    for _ in range(4):
        waited.append(page.message(True))
        page.now += PERIOD
    for message in waited:
        page.deadman = heard_hands(page.deadman, message, late, 0.02)
    assert page.deadman.state == State.HELD
    assert expiry(page.deadman) < page.now + WAY + TIMEOUT - PERIOD + 1e-4  # as of when the last was sent


def test_a_burst_that_waited_in_a_buffer_is_no_heartbeat():
    page = Page().press()
    last = page.deadman.heartbeat
    burst = []
    for _ in range(15):
        burst.append(page.message(True))
        page.now += PERIOD
    for message in burst[:10]:  # the youngest of these is 0.1 s old when they come
        page.deadman = heard_hands(page.deadman, message, page.now, 0.02)
    assert page.deadman.state == State.WAITING
    assert page.deadman.heartbeat == last


def test_messages_that_come_late_one_by_one_hold_nothing():
    page = Page().press()
    states = [page.send(True, way=WAY + 0.3) for _ in range(50)]
    assert states[-1] == State.WAITING
    page.send(False, way=WAY + 0.3)
    assert page.deadman.state == State.WAITING
    assert "too late" in text(page.deadman)


def test_a_message_that_comes_late_does_not_hide_that_none_came():
    page = Page().press()
    message, heard = page.message(True), page.now + TIMEOUT + 0.01
    assert heard_hands(page.deadman, message, heard, 0.02).state == State.WAITING


def test_a_network_that_was_slow_from_the_beginning_is_found_by_its_round_trip():
    page = Page()
    states = [page.send(k % 2 == 1, way=0.3, round_trip=ROUND_TRIP) for k in range(20)]
    assert set(states) == {State.WAITING}
    assert "too late" in text(page.deadman)


def test_below_its_bound_a_round_trip_is_no_trouble():
    page = Page()
    page.send(False, round_trip=ROUND_TRIP - 1e-6)
    assert page.send(True, round_trip=ROUND_TRIP - 1e-6) == State.HELD


def test_a_network_is_slow_only_where_a_page_that_was_answered_waits_for_it():
    page = Page()
    page.send(True)
    assert "slow" not in text(page.deadman)  # in time: it waits for a release
    page.send(False, round_trip=math.inf)
    assert "slow" not in text(page.deadman)  # its first messages tell of no pong
    page.press()
    late = page.message(True)._replace(sent=page.now + page.ahead - 0.3)
    held = heard_hands(page.deadman, late, page.now, 0.02)
    assert (held.state, held.cause) == (State.HELD, "")


def test_a_page_that_was_never_answered_holds_nothing():
    page = Page()
    assert {page.send(k % 2 == 1, round_trip=math.inf) for k in range(20)} == {State.WAITING}


def test_a_number_that_is_not_new_is_no_heartbeat():
    page = Page().press()
    last = page.deadman
    again = Hands(True, page.number, page.now + page.ahead, CENTRED, 0, 1)
    assert heard_hands(last, again, page.now + WAY, 0.02).heartbeat == last.heartbeat


def test_a_release_counts_even_if_it_comes_late_or_twice():
    page = Page().press()
    assert page.send(False, way=WAY + 0.3) == State.WAITING
    page = Page().press()
    old = Hands(False, page.number - 1, page.now + page.ahead, CENTRED, 0, 1)
    assert heard_hands(page.deadman, old, page.now + WAY, 0.02).state == State.WAITING


def test_after_a_stop_it_must_be_pressed_anew():
    page = Page().press()
    page.deadman = stopped(page.deadman, "The emergency stop is pressed.")
    assert {page.send(True) for _ in range(10)} == {State.WAITING}
    assert text(page.deadman).startswith("The emergency stop is pressed.")
    assert page.send(False) == State.READY
    assert page.send(True) == State.HELD


def test_clocks_that_drift_apart_do_not_end_it():
    for drift in (-4e-4, 4e-4):
        page = Page().press()
        for _ in range(300 * 20):  # they differ by 0.12 s then
            page.ahead += drift * 0.05
            page.now += 0.05 - PERIOD
            page.send(True)
        assert page.deadman.state == State.HELD


def test_a_way_that_grows_faster_than_clocks_drift_ends_it():
    page = Page().press()
    for _ in range(1000 * 20):  # 0.12 s more than clocks may
        page.ahead -= 6.2e-4 * 0.05
        page.now += 0.05 - PERIOD
        page.send(True)
    assert page.deadman.state == State.WAITING


class Judged(RuleBasedStateMachine):
    """Losses, delays, bursts, repetitions, stops, jumps of the page's clock."""

    def __init__(self):
        super().__init__()
        self.page, self.now, self.way = Page(), 50.0, []
        self.ready = False  # a release with centred levers was heard in time, and nothing stopped it since

    @rule(count=st.integers(1, 4), held=st.booleans(), axes=st.sampled_from((CENTRED, CENTRED, DEFLECTED)))
    def the_page_sends(self, count, held, axes):
        for _ in range(count):
            self.page.now = self.now = self.now + PERIOD
            self.way.append(self.page.message(held, axes))
            self.arrives(-1, 0.02, again=True)

    @rule()
    def the_operator_presses(self):
        self.the_page_sends(1, False, CENTRED)
        self.the_page_sends(1, True, CENTRED)

    @rule(held=st.booleans(), seconds=st.sampled_from((0.0, 0.005, 0.06, 0.3)))
    def a_message_waits(self, held, seconds):
        self.page.now = self.now
        self.way.append(self.page.message(held))
        self.now += seconds

    @precondition(lambda self: self.way)
    @rule(
        which=st.integers(0, 9),
        round_trip=st.sampled_from((0.02, 0.02, 0.249, 0.25, math.inf)),
        again=st.booleans(),
    )
    def arrives(self, which, round_trip, again):
        message = self.way[which % len(self.way)] if again else self.way.pop(which % len(self.way))
        before = self.page.deadman
        after = heard_hands(before, message, self.now, round_trip)
        if after.heartbeat != before.heartbeat:
            assert self.now - TIMEOUT < after.heartbeat <= self.now
            assert message.number > before.number
            assert round_trip < ROUND_TRIP
        if after.state == State.HELD:
            assert message.held
            assert self.ready
            assert before.state != State.WAITING
            assert after.heartbeat < before.heartbeat + TIMEOUT
            assert self.now - after.heartbeat < TIMEOUT
        self.page.deadman = after
        self.ready = after.state != State.WAITING
        if self.ready and before.state == State.WAITING:
            assert not message.held
            assert message.axes == CENTRED
        self.looks()

    @rule(seconds=st.sampled_from((0.0, 0.001, 0.05, 0.079, 0.1)))
    def looks(self, seconds=0.0):
        self.now += seconds
        self.page.deadman = judged(self.page.deadman, self.now)
        held = self.page.deadman.state == State.HELD
        assert not held or self.now - self.page.deadman.heartbeat < TIMEOUT
        self.ready = self.ready and self.page.deadman.state != State.WAITING

    @rule(seconds=st.sampled_from((-10.0, -0.1, 0.1, 10.0)))
    def the_pages_clock_jumps(self, seconds):
        self.page.ahead += seconds

    @rule()
    def a_stop(self):
        self.page.deadman, self.ready = stopped(self.page.deadman, "A stop."), False


def test_whatever_arrives_it_is_never_held_for_longer_than_the_timeout_after_a_heartbeat():
    holds(Judged, examples=30, steps=40)
