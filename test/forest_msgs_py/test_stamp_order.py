"""Claims about the order of stamps: the past stays past, until a sender begins anew."""

import numpy as np

from forest_msgs_py.stamp_order import NO_STAMP, StampOrder


def test_of_shuffled_messages_exactly_the_records_pass():
    rng = np.random.default_rng(1)
    order, newest = StampOrder(10.0), 0
    for stamp in rng.integers(1, 1000, 500).tolist():
        passes = order.problem("joy", stamp, 0.0) == ""
        assert passes == (stamp > newest)
        newest = max(newest, stamp)


def test_the_trouble_is_named():
    order = StampOrder(1.0)
    assert order.problem("joy", 2_000_000_000, 0.0) == ""
    assert "joy: the stamp stands still; allowed" in order.problem("joy", 2_000_000_000, 0.1)
    assert "joy: the stamp goes back by 0.5 s; allowed" in order.problem("joy", 1_500_000_000, 0.2)


def test_after_its_patience_time_may_begin_anew():
    order = StampOrder(0.1)
    assert order.problem("joy", 500, 0.0) == ""
    assert order.problem("joy", 3, 0.1)
    assert order.problem("joy", 4, 0.11)  # alone it proves nothing
    assert order.problem("joy", 5, 0.12) == ""
    assert order.problem("joy", 4, 0.13)


def test_a_stamp_that_stands_still_never_passes():
    order = StampOrder(0.1)
    assert order.problem("joy", 500, 0.0) == ""
    assert all(order.problem("joy", 7, 0.01 * k) for k in range(100))


def test_no_stamp_is_always_in_order():
    order = StampOrder(10.0)
    assert not any(order.problem("joy", stamp, 0.0) for stamp in (NO_STAMP, 7, NO_STAMP, 8, NO_STAMP))
