"""Losses are counted from the numbers alone, also where several publishers share a topic."""

import random

from forest_msgs_py.runtime.sequences import SequenceGaps


def test_one_publisher_joined_late_loses_only_what_is_missing_after():
    gaps = SequenceGaps()
    assert [gaps.observe(number) for number in (500, 501, 504, 505)] == [0, 0, 2, 0]
    assert gaps.lost == 2


def test_interleaved_publishers_without_loss_count_none():
    generator = random.Random(3)
    waiting = {"a": list(range(1, 400)), "b": list(range(250, 700)), "c": list(range(399, 450))}
    gaps = SequenceGaps()
    while any(waiting.values()):
        queue = generator.choice([queue for queue in waiting.values() if queue])
        gaps.observe(queue.pop(0), lambda: 3)
    assert gaps.lost == 0


def test_a_loss_among_two_publishers_is_found():
    gaps = SequenceGaps()
    for number in (10, 900, 11, 901, 14, 902, 15):
        gaps.observe(number, lambda: 2)
    assert gaps.lost == 2


def test_a_restarted_publisher_is_no_loss():
    gaps = SequenceGaps()
    for number in (70, 71, 1, 2, 3):
        gaps.observe(number, lambda: 1)
    assert gaps.lost == 0


def test_a_middleware_without_numbers_counts_nothing():
    gaps = SequenceGaps()
    assert [gaps.observe(0) for _ in range(3)] == [0, 0, 0]
