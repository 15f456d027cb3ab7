"""The time left is true: what is expected follows what the records so far took, and is never nothing."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.measurements.session import Session
from forest_ident.refinement.refinement_task import simulations
from forest_ident.refinement.workload import Workload

C180 = load_machine("c180_hoses")
NAMES = (
    "deadband_swing",
    "deadband_boom",
    "deadband_stick",
    "damping_swing",
    "damping_boom",
    "damping_stick",
)


def record(name, seconds):
    time = 0.005 * np.arange(round(seconds / 0.005))
    return Session(name, time, np.zeros((len(time), 3)), {})


def left_over_true(times):
    """Return the work left as told over what was left, at each simulation but those of the last fifth.

    Args:
        times: simulations of each record, over those expected.
    """
    records = [record(name, 70.0) for name in NAMES]
    counts = [round(k * simulations(C180, one)) for k, one in zip(times, records, strict=True)]
    work, found, done = Workload(C180, records), [], 0
    for place, count in enumerate(counts):
        for _ in range(count):
            assert work.count(place) <= count
            done += 1
            share = work.share(place)
            assert 0.0 < share < 1.0
            found.append(done * (1.0 - share) / share / max(sum(counts) - done, 1))
    return found[: round(0.8 * len(found))]


@pytest.mark.parametrize("times", [(1.0,) * 6, (0.8,) * 6, (1.25, 0.9, 1.4, 1.1, 0.8, 1.2)])
def test_the_work_left_is_told_within_a_third(times):
    told = left_over_true(times)
    assert min(told) > 2.0 / 3.0
    assert max(told) < 4.0 / 3.0


def test_searches_that_all_take_twice_as_long_are_told_within_a_third_from_half_on():
    told = left_over_true((2.0,) * 6)
    assert min(told[len(told) // 2 :]) > 2.0 / 3.0
