"""Claims about the time between samples: a loop's time runs no faster than the clock does."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from forest_msgs_py.runtime.stamped_period import (
    BEGIN,
    LONGEST,
    clipped_period,
    step_period,
    time_in_force,
)

BEGUN = 1_700_000_000_000_000_000  # [ns]: stamps do not begin at zero
MS = 1_000_000  # [ns]
NOMINAL = 0.004  # [s]


class Loop:
    """What remembers samples between two steps, of a nominal period [s]."""

    def __init__(self, nominal=NOMINAL):
        self.remembered, self.nominal = BEGIN, nominal

    @property
    def started(self):
        return self.remembered.started

    def since(self, stamp):
        self.remembered, dt = clipped_period(self.remembered, stamp, self.nominal)
        return dt

    def step(self, stamp, sent):
        self.remembered, dt = step_period(self.remembered, stamp, sent, self.nominal)
        return dt

    def in_force(self, stamp):
        self.remembered, dt = time_in_force(self.remembered, stamp, self.nominal)
        return dt


def stamps(*milliseconds):
    return [BEGUN + round(ms * MS) for ms in milliseconds]


def steps(period, *pairs):
    """What a period makes of (stamp, sent), both in ms after the beginning."""
    return [
        period.step(stamp, 100.0 + 1e-3 * sent)
        for stamp, sent in zip(stamps(*(p[0] for p in pairs)), (p[1] for p in pairs), strict=True)
    ]


def test_time_since_the_last_stamp_is_kept_between_half_a_period_and_fifty_milliseconds():
    period = Loop()
    found = [period.since(stamp) for stamp in stamps(0, 7, 8.5, 10.6, 60.5, 120, 90, 96)]
    assert found == pytest.approx([0.004, 0.007, 0.002, 0.0021, 0.0499, 0.05, 0.002, 0.006])


def test_a_period_has_started_with_the_first_stamp_of_either_kind():
    for measure in (lambda period: period.since(BEGUN), lambda period: period.step(BEGUN, 100.0)):
        period = Loop()
        assert not period.started
        assert measure(period) == NOMINAL
        assert period.started


def test_steps_are_what_passed_between_the_stamps():
    found = steps(Loop(), (0, 0), (5, 5), (12, 12), (14, 14))
    assert found == pytest.approx([0.004, 0.005, 0.007, 0.002])


def test_what_comes_sooner_than_half_a_period_counts_for_the_next_step():
    found = steps(Loop(), (0, 0), (1, 1), (1.9, 1.9), (3, 3), (4, 4), (5, 5))
    assert found == pytest.approx([0.004, 0.0, 0.0, 0.003, 0.0, 0.002])


def test_half_a_period_is_a_step():
    period = Loop(2.0**-8)
    stamp = 10**9
    period.step(stamp, 100.0)
    assert period.step(stamp + 1_953_125, 101.0) == 2.0**-9  # s, to the last bit


def test_a_gap_steps_by_fifty_milliseconds():
    assert steps(Loop(), (0, 0), (51, 51), (2000, 2000)) == pytest.approx([0.004, 0.05, 0.05])


def test_a_stamp_that_stands_still_is_no_step_and_one_that_goes_back_is_a_nominal_one():
    found = steps(Loop(), (0, 0), (4, 4), (4, 8), (1, 12), (5, 16))
    assert found == pytest.approx([0.004, 0.004, 0.0, 0.004, 0.004])


def test_a_burst_steps_by_fifty_milliseconds_in_all_and_not_again():
    period = Loop()
    burst = [(11.5 * k, 0) for k in range(30)]
    assert sum(steps(period, *burst)) == pytest.approx(0.05)
    assert steps(period, (345, 1.9)) == [0.0]
    assert steps(period, (349, 4.0)) == pytest.approx([0.004])


def test_a_pause_buys_no_more_than_fifty_milliseconds():
    period = Loop()
    steps(period, (0, 0), (4, 4))
    burst = [(1000 + 10 * k, 1000) for k in range(10)]
    assert sum(steps(period, *burst)) == pytest.approx(0.05)


def test_what_was_sent_before_buys_no_time():
    period = Loop()
    burst = [(10 * k, 0) for k in range(10)]
    steps(period, *burst)
    assert steps(period, (110, -50), (120, 0), (130, -50), (140, 0)) == [0.0] * 4
    assert steps(period, (150, 10)) == pytest.approx([0.01])


def test_a_sample_without_a_stamp_counts_from_when_it_was_sent():
    period = Loop()
    assert [period.step(0, 100.0 + t) for t in (0.0, 0.006, 0.016)] == pytest.approx([0.004, 0.006, 0.01])


def test_the_time_in_force_leaves_out_what_lasted_less_than_half_a_period():
    period = Loop()
    found = [period.in_force(stamp) for stamp in stamps(0, 6, 7.9, 8, 9.5, 11)]
    assert found == pytest.approx([0.004, 0.006, 0.0, 0.002, 0.0, 0.003])


def test_the_time_in_force_is_at_most_fifty_milliseconds_and_begins_anew_where_stamps_go_back():
    period = Loop()
    found = [period.in_force(stamp) for stamp in stamps(100, 200, 50, 51, 55)]
    assert found == pytest.approx([0.004, 0.05, 0.0, 0.0, 0.005])


def test_dt_comes_from_stamps_within_bounds():
    period = Loop(0.005)
    assert not period.started
    assert period.since(1_000_000_000) == 0.005
    assert period.started
    assert period.since(1_012_500_000) == pytest.approx(0.0125)
    assert period.since(1_012_500_000) == 0.0025
    assert period.since(9_000_000_000) == LONGEST
    assert period.since(1_000_000_000) == 0.0025


@pytest.mark.parametrize("rate", [200.0, 400.0, 1000.0, 5000.0])
@pytest.mark.parametrize("stamped", [True, False])
def test_the_steps_together_take_the_time_that_passes_whatever_the_rate(rate, stamped):
    period, begun = Loop(0.005), 100.0
    sent = [begun + k / rate for k in range(round(rate))]
    steps = [period.step(round(t * 1e9) * stamped, t) for t in sent]
    assert sum(steps) == pytest.approx(1.0, abs=0.01)
    assert all(dt == 0.0 or dt >= 0.0024 for dt in steps)


STAMPS = st.integers(-(2**63), 2**63 - 1) | st.integers(0, 2 * 10**9) | st.just(0)
GAPS = st.floats(-0.1, 0.2) | st.sampled_from((0.0, 0.001, 0.0025, 0.005))  # [s] until the next is sent


@given(st.lists(st.tuples(STAMPS, GAPS), max_size=40))
def test_time_does_not_run_away_whatever_stamps_say_and_no_step_is_too_long_or_too_short(samples):
    period, sent, begun, total = Loop(0.005), 100.0, 100.0, 0.0
    latest = sent
    for stamp, gap in samples:
        dt = period.step(stamp, sent)
        assert dt == 0.0 or 0.0025 <= dt <= LONGEST
        total, latest = total + dt, max(latest, sent)
        assert total <= latest - begun + LONGEST + 1e-9
        sent += gap


def test_a_burst_after_a_stall_steps_by_its_stamps():
    period = Loop(0.005)
    stamps = [10**9 + k * 5_000_000 for k in range(8)]
    assert [period.step(stamp, 7.0) for stamp in stamps] == pytest.approx([0.005] * 8)


def test_what_is_said_close_behind_something_is_in_force_from_then_on():
    period, s = Loop(0.005), 1_000_000_000
    assert [period.in_force(s), period.in_force(s + 15_000_000)] == pytest.approx([0.005, 0.015])
    assert [period.in_force(s + 15_000_000), period.in_force(s + 17_000_000)] == [0.0, 0.0]
    assert period.in_force(s + 20_000_000) == 0.005
    assert period.in_force(s) == 0.0
    assert period.in_force(s + 5_000_000) == 0.005
