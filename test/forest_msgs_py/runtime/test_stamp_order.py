"""Claims about the order of stamps: the past stays past, until a sender begins anew."""

import math

from hypothesis import given
from hypothesis import strategies as st

from forest_msgs_py.runtime.stamp_order import FIRST, NO_STAMP, disorder, is_in_order, updated_order


class Reader:
    """What remembers a topic's messages, with a patience [s]."""

    def __init__(self, patience):
        self.remembered, self.patience = FIRST, patience

    def problem(self, name, stamp, now):
        before = self.remembered
        self.remembered = updated_order(before, stamp, now, self.patience)
        assert is_in_order(before, stamp) == (disorder(before, name, stamp) == "")
        return disorder(before, name, stamp)


@given(st.lists(st.integers(1, 30) | st.integers(-(2**63), 2**63 - 1).filter(bool), max_size=40))
def test_of_messages_in_any_order_exactly_the_records_pass(stamps):
    order, newest = Reader(10.0), -math.inf
    for stamp in stamps:
        assert (order.problem("joy", stamp, 0.0) == "") == (stamp > newest)
        newest = max(newest, stamp)


def test_the_trouble_is_named():
    order = Reader(1.0)
    assert order.problem("joy", 2_000_000_000, 0.0) == ""
    assert "joy: the stamp stands still; allowed" in order.problem("joy", 2_000_000_000, 0.1)
    assert "joy: the stamp goes back by 0.5 s; allowed" in order.problem("joy", 1_500_000_000, 0.2)


def test_after_its_patience_time_may_begin_anew():
    order = Reader(0.1)
    assert order.problem("joy", 500, 0.0) == ""
    assert order.problem("joy", 3, 0.1)
    assert order.problem("joy", 4, 0.11)  # alone it proves nothing
    assert order.problem("joy", 5, 0.12) == ""
    assert order.problem("joy", 4, 0.13)


def test_a_stamp_that_stands_still_never_passes():
    order = Reader(0.1)
    assert order.problem("joy", 500, 0.0) == ""
    assert all(order.problem("joy", 7, 0.01 * k) for k in range(100))


def test_no_stamp_is_always_in_order():
    order = Reader(10.0)
    assert not any(order.problem("joy", stamp, 0.0) for stamp in (NO_STAMP, 7, NO_STAMP, 8, NO_STAMP))


BEGUN = 1_700_000_000_000_000_000  # [ns]: stamps do not begin at zero


def passed(order, *messages):
    """Which of (stamp [ns after the beginning], time of arrival [s]) pass."""
    return [order.problem("joy", BEGUN + stamp, 1000.0 + now) == "" for stamp, now in messages]


def test_a_sender_whose_time_goes_back_is_not_believed_before_the_patience_is_over():
    assert passed(Reader(0.1), (500, 0.0), (3, 0.05), (4, 0.09), (5, 0.0999)) == [
        True,
        False,
        False,
        False,
    ]


def test_patience_counts_from_the_last_message_in_order_alone():
    order = Reader(0.1)
    assert passed(order, (500, 0.0), (600, 0.08), (3, 0.15), (4, 0.16)) == [True, True, False, False]
    assert passed(order, (3, 0.19), (4, 0.2)) == [False, True]  # neither was what was refused in order


def test_a_message_without_stamp_proves_no_order():
    order = Reader(0.1)
    assert passed(order, (500, 0.0)) == [True]
    assert order.problem("joy", 0, 1000.09) == ""
    assert passed(order, (500, 0.1), (3, 0.11), (4, 0.12)) == [False, False, True]


def test_after_a_new_beginning_the_past_is_past_again():
    order = Reader(0.1)
    assert passed(order, (500, 0.0), (30, 0.2), (20, 0.25), (25, 0.26)) == [True, False, False, False]
    assert passed(order, (30, 0.27), (31, 0.28), (32, 0.29), (31, 0.3)) == [False, True, True, False]


def test_a_stamp_that_stands_still_begins_nothing_anew():
    order = Reader(0.1)
    assert passed(order, (500, 0.0), (500, 0.2), (499, 0.21), (500, 0.22)) == [True, False, False, True]


def test_the_text_tells_by_how_much_the_newest_stamp_is_missed():
    order = Reader(1.0)
    assert passed(order, (0, 0.0), (4_000_000_000, 0.1)) == [True, True]
    assert order.problem("joint state", BEGUN + 1_500_000_000, 1000.2) == (
        "joint state: the stamp goes back by 2.5 s; allowed: rising stamps, or none"
    )
