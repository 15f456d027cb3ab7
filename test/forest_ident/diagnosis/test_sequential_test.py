import math

import numpy as np
import pytest

from forest_ident.diagnosis import sequential_test
from forest_ident.diagnosis.sequential_test import NEW, Limits, score

KNOWN = Limits(spread=2.0, slack=0.5, threshold=10.0, tolerance=0.0, learn=0.0)
LEARNT = Limits(spread=1.0, slack=0.5, threshold=10.0, tolerance=5.0, learn=20.0)


def after(values, p, test=NEW):
    for z in values:
        test = sequential_test.tested(test, z, p)
    return test


def test_the_sum_is_pages():
    test = after([3.0, 1.0, -1.0], KNOWN)  # 1.5 - 0.5, + 0.5 - 0.5, - 0.5 - 0.5
    assert (test.high, test.low) == (0.0, 0.0)
    assert after([3.0, 5.0], KNOWN).high == pytest.approx(1.0 + 2.0)
    assert after([-3.0, -5.0], KNOWN).low == pytest.approx(3.0)


def test_noise_of_a_healthy_machine_raises_no_alarm_and_a_shift_does():
    noise = np.random.default_rng(1).normal(3.0, 1.0, 3000)  # off the file by 3, which is allowed
    healthy = after(noise, LEARNT)
    assert abs(score(healthy, LEARNT)) < 1.0
    shifted = after(noise[:40] - 2.0, LEARNT, healthy)
    assert score(shifted, LEARNT) < -1.0


def test_one_wild_value_raises_no_alarm():
    assert score(after([1e9], KNOWN), KNOWN) < 1.0
    assert score(after([1e9] * 3, KNOWN), KNOWN) >= 1.0


def test_what_is_further_off_than_a_healthy_machine_may_be_is_seen_from_the_start():
    assert after([4.9] * 100, LEARNT).high == 0.0
    assert score(after([7.0] * 12, LEARNT), LEARNT) > 1.0  # before it is learnt
    assert score(after([7.0] * 60, LEARNT), LEARNT) > 1.0  # and after


def test_a_missing_residual_changes_nothing():
    before = after([1.0, 2.0], LEARNT)
    assert sequential_test.tested(before, math.nan, LEARNT) == before


def test_what_has_healed_is_forgotten_however_long_it_lasted():
    ill = after([1000.0] * 10_000, KNOWN)
    healthy = after([0.0] * 80, KNOWN, ill)
    assert healthy.high == 0.0
