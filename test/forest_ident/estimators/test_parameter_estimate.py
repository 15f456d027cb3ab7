"""An estimate's interval, its digits, and what it says of data that cannot tell it."""

import math

import pytest

from forest_ident.estimators.calibration import Offset
from forest_ident.estimators.parameter_estimate import Estimate, is_loose, is_positive, unit_of


def estimate(value, error, positive=True, condition=1.0, key="swing.damping"):
    return Estimate(key, value, error, "N m s/rad", condition, "by hand", positive)


def test_an_interval_is_of_the_logarithm_where_the_value_is_positive():
    low, high = estimate(2.0, 0.1).interval
    assert low * high == pytest.approx(4.0)
    assert math.log(high / 2.0) == pytest.approx(1.96 * 0.05, rel=1e-4)
    assert estimate(2.0, 0.1, positive=False).interval == pytest.approx((1.804, 2.196), abs=1e-5)
    assert estimate(-2.0, 0.1).interval == pytest.approx((-2.196, -1.804), abs=1e-5)
    assert estimate(0.0, 0.1).interval == pytest.approx((-0.196, 0.196), abs=1e-5)
    assert estimate(1.0, 1e3).interval == pytest.approx((math.exp(-50.0), math.exp(50.0)))
    wide = estimate(1.0, 0.1, positive=False)
    assert [wide.contains(truth) for truth in (0.80, 0.81, 1.19, 1.20)] == [False, True, True, False]
    assert [estimate(value, 0.1).usable for value in (0.1, 0.0, -1.0, math.inf, math.nan)] == [
        *(True, False, False, False, False)
    ]


def test_ends_are_told_in_digits_that_tell_them_apart():
    narrow = estimate(1.23456789, 1e-7, positive=False)
    assert narrow.formatted() == ("1.23456789", "1.23456769", "1.23456809")
    assert estimate(1.23456789, 1e-2, positive=False).formatted() == ("1.2346", "1.215", "1.2542")
    assert estimate(1.23456789, 0.0, positive=False).formatted() == ("1.2346",) * 3
    assert len(estimate(1.0 / 3.0, 1e-15, positive=False).formatted()[0]) == len("0.333333333333")


def test_what_cannot_be_told_says_which_motion_would():
    assert estimate(1.0, 0.2).checked().warning == ""
    assert "interval too wide" in estimate(1.0, 0.21).checked().warning
    assert "hold nothing of swing.damping" in estimate(math.nan, 0.1).checked().warning
    assert "hold nothing of swing.damping" in estimate(1.0, math.inf).checked().warning
    assert estimate(1.0, 0.1, condition=1e6).checked().warning == ""
    assert "condition number 2e+06" in estimate(1.0, 0.1, condition=2e6).checked().warning
    assert estimate(1.0, 0.3).checked().warning.endswith("both ways through the same angles")
    assert (
        estimate(1.0, 0.3, key="a.new_one")
        .checked()
        .warning.endswith("it takes a motion in which it matters")
    )


def test_a_voltage_is_loose_by_volts_and_all_else_by_its_share():
    assert [is_loose(10.0, 1.9, positive) for positive in (True, False)] == [False, True]
    assert [is_loose(-0.1, error, positive=True) for error in (0.019, 0.021)] == [False, True]
    assert [is_loose(10.0, error, positive=False) for error in (0.19, 0.21)] == [False, True]
    assert is_loose(math.nan, 0.0, positive=False)
    assert is_loose(1.0, math.nan, positive=True)
    assert [is_positive(key) for key in ("valve.deadband_voltage", "swing.damping")] == [False, True]
    assert unit_of("swing.gear_ratio") == "1"


def test_an_offset_or_a_gain_that_was_not_estimated_is_not_told():
    assert Offset("a", 1234.5, 10.0, "Pa").formatted() == ("1234 ± 20 Pa", "")
    assert Offset("a", 0.0, 0.0, "m3/s", 1.0125, 0.001).formatted() == ("", "1.012500 ± 0.002")
