"""One impossible estimate does not cost all others."""

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.output_error.gaussian_estimate import GaussianEstimate
from forest_ident.refinement.possible_numbers import applied
from forest_ident.refinement.result import Result

C180 = load_machine("c180_hoses")


def result_of(**values):
    """Return a result with estimates of some numbers, by key with _ for dots."""
    estimates = {key: Estimate(key, value, 0.01 * value, "1", 1.0, "test") for key, value in values.items()}
    names = tuple(values)
    known = GaussianEstimate(names, np.log(list(values.values())), np.eye(len(names)))
    return Result(C180, C180, estimates=estimates, known=known)


def test_an_estimate_out_of_its_range_is_a_remark_and_the_rest_stays():
    values = {"boom.damping": 1e17, "stick.damping": 8e4}
    result = result_of(**values)
    machine = applied(result, values)
    assert machine.stick.damping == 8e4
    assert machine.boom.damping == C180.boom.damping
    assert list(result.estimates) == ["stick.damping"]
    assert result.known.names == ("stick.damping",)
    assert result.impossible == ["boom.damping"]
    (remark,) = result.remarks
    assert "boom.damping: found 1e+17, which is impossible (outside 0 .. 1e+08 N*s/m)" in remark
    assert "is kept as stated; it takes the axis at several steady speeds" in remark


def test_an_estimate_that_contradicts_the_rest_of_the_machine_is_a_remark_and_the_rest_stays():
    values = {"valve.deadband_voltage": 10.85, "stick.damping": 8e4}
    result = result_of(**values)
    machine = applied(result, values)
    assert machine.valve.deadband_voltage == C180.valve.deadband_voltage
    assert machine.stick.damping == 8e4
    assert "valve.deadband_voltage: found 10.85, which is impossible" in result.remarks[0]


def test_what_is_possible_depends_on_the_sort_of_valve_that_the_machine_has():
    """A pilot check's setting ends at 100 bar; a counterbalance valve's begins about there."""
    crane, key = load_machine("c180"), "boom.holding_1.setting"
    result = result_of(**{key: 2.15e7})
    result.machine = result.start = crane
    assert applied(result, {key: 2.15e7}).boom.holding_1.setting == 2.15e7
    assert not result.remarks


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_no_number_is_impossible(value):
    result = result_of(**{"stick.damping": 1.0})
    assert applied(result, {"stick.damping": value}).stick.damping == C180.stick.damping
    assert "found no number" in result.remarks[0]
