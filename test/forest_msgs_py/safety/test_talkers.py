"""Claims about how two publishers on one topic are told from one, by the numbers of their messages."""

import itertools

import numpy as np
import pytest

from forest_msgs_py.safety.talkers import NOBODY, TOGETHER, Publishers, are_several, heard

PERIOD = 0.005  # [s]


def after(numbers, period=PERIOD, begin=NOBODY, start=0.0):
    """What is known after messages in turn; NaN stands for a pause of `TOGETHER`."""
    known, now = begin, start
    for number in numbers:
        now += TOGETHER if number != number else period
        if number == number:
            known = heard(known, number, now)
    return are_several(known, now)


PAUSE = float("nan")


@pytest.mark.parametrize(
    ("numbers", "several"),
    [
        ((1, 2, 3), False),
        ((7, 8, 12, 13, 400), False),  # messages were lost
        ((7, 8, 9, 1, 2, 3), False),  # a node was started anew
        ((7, 8, 1, 2, 1, 2, 3), False),  # and once more
        ((7, 8, 1, 9), True),
        ((7, 1, 8), True),
        ((1, 7, 2), False),  # may be one that lost messages, and was started anew
        ((1, 7, 2, 8), True),
        ((5, 5, 6, 6), True),  # two that began at once
        ((5, 900, 6, 901), True),  # one that has long talked elsewhere
        ((7, 8, 1, 2, PAUSE, PAUSE, 9, 10), False),  # handed over, and given back
        ((7, 1, 8, PAUSE, PAUSE, 2, 3), False),  # one of them has gone
        ((None, None), False),  # nobody counts
    ],
)
def test_two_talk_where_a_count_goes_on_after_another_ones(numbers, several):
    assert after(numbers) == several


def test_one_who_loses_messages_and_starts_anew_is_always_one():
    rng = np.random.default_rng(5)
    for _ in range(100):
        runs = [[*np.cumsum(rng.integers(1, 50, rng.integers(1, 40))).tolist(), PAUSE] for _ in range(5)]
        assert not after(itertools.chain.from_iterable(runs))


@pytest.mark.parametrize("rate", [1.0, 3.0, 50.0, 200.0, 5000.0])
def test_a_second_one_of_any_rate_is_found_with_the_next_message_of_the_first(rate):
    rng = np.random.default_rng(6)
    for _ in range(20):
        first, begin = int(rng.integers(100, 10_000)), rng.uniform(0.1, 0.2)
        said = [(k * PERIOD, first + k) for k in range(100)]
        said += [(begin + k / rate, 1 + k) for k in range(round(rate * 0.3) + 1)]
        known, found = NOBODY, []
        for time, number in sorted(said):
            known = heard(known, number, time)
            found += [time] if are_several(known, time) else []
        assert begin < found[0] <= begin + PERIOD


def test_who_was_silent_for_half_a_second_has_left_and_the_stop_may_be_reset_half_a_second_after_two_talked():
    for silent, several in ((0.45, True), (0.55, False)):
        known = heard(heard(NOBODY, 7, 10.0), 1, 10.0 + silent - 0.01)
        assert are_several(heard(known, 8, 10.0 + silent), 10.0 + silent) == several
    known = heard(heard(heard(NOBODY, 7, 10.0), 1, 10.01), 8, 10.02)
    assert are_several(known, 10.5)
    assert not are_several(known, 10.54)


def test_four_are_told_apart():
    known = NOBODY
    for k, number in enumerate((60, 50, 40, 30, 20, 10)):
        known = heard(known, number, 10.0 + k * PERIOD)
    assert [talker.number for talker in known.heard] == [40, 30, 20, 10]


def test_publishers_are_told_apart_as_their_messages_come(monkeypatch):
    now = 5.0
    monkeypatch.setattr("time.monotonic", lambda: now)
    publishers = Publishers()
    for number in (7, 1):
        publishers.hear({"publication_sequence_number": number})
        publishers.hear({})  # of a middleware that does not count
        assert not publishers.are_several()
    publishers.hear({"publication_sequence_number": 8})
    assert publishers.are_several()
    now += TOGETHER
    assert not publishers.are_several()
