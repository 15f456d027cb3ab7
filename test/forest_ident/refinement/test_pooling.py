"""Two estimates of one number, one for each direction of a valve, become one: when, and which."""

import dataclasses
import math

import pytest

from forest_description.hydraulics.valve_parameters import BackwardValve
from forest_description.machine import load_machine
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.refinement.pooling import pooled
from forest_ident.refinement.result import Result

C180 = load_machine("c180_hoses")
TWICE = dataclasses.replace(C180.valve, backward=BackwardValve(1.3, 1.4e12))
# Unlike errors, in either order: (value, standard error) forward and backward.
VOLTS = (1.00, 0.02), (1.03, 0.01)
RESISTANCES = (1.10e12, 1e10), (1.12e12, 3e10)


def estimate(key, value, error):
    return Estimate(key, value, error, "V", 10.0, "fit", positive=not key.endswith("voltage"))


def found(section="valve", volts=VOLTS, resistances=RESISTANCES, start=C180):
    """A result that tells both directions of a section's valve."""
    axis = section.rpartition(".")[0]
    drive = {axis: dataclasses.replace(getattr(C180, axis), valve=TWICE)} if axis else {"valve": TWICE}
    result = Result(start, dataclasses.replace(C180, **drive))
    for part, pair in (("deadband_voltage", volts), ("minimum_resistance", resistances)):
        for key, numbers in zip((f"{section}.{part}", f"{section}.backward.{part}"), pair, strict=True):
            result.estimates[key] = estimate(key, *numbers)
    return result


@pytest.mark.parametrize("section", ["valve", "swing.valve", "boom.valve", "stick.valve"])
def test_the_pooled_value_weighs_each_direction_with_its_precision(section):
    result = found(section)
    machine = pooled(result)
    axis = section.rpartition(".")[0]
    valve = getattr(machine, axis).valve if axis else machine.valve
    assert valve.backward is None
    # 1/0.02^2 = 2500 against 1/0.01^2 = 10000, and 9 against 1.
    assert valve.deadband_voltage == pytest.approx((2500 * 1.00 + 10000 * 1.03) / 12500, rel=1e-12)
    assert valve.minimum_resistance == pytest.approx((9 * 1.10e12 + 1 * 1.12e12) / 10, rel=1e-12)
    told = {key: e.value for key, e in result.estimates.items()}
    assert told == {
        f"{section}.deadband_voltage": valve.deadband_voltage,
        f"{section}.minimum_resistance": valve.minimum_resistance,
    }


@pytest.mark.parametrize("swapped", [False, True])
def test_the_pooled_error_is_the_better_directions_because_their_errors_may_be_shared(swapped):
    """Between that of independent estimates, which is less, and the worse one's."""
    order = slice(None, None, -1 if swapped else 1)
    result = found(volts=VOLTS[order], resistances=RESISTANCES[order])
    pooled(result)
    assert result.estimates["valve.deadband_voltage"].standard_error == 0.01
    assert result.estimates["valve.minimum_resistance"].standard_error == 1e10


def test_a_pooled_estimate_is_judged_anew():
    result = found(volts=((1.0, 0.5), (1.1, 0.05)))
    result.estimates["valve.deadband_voltage"] = result.estimates["valve.deadband_voltage"]._replace(
        warning="the data cannot tell it"
    )
    pooled(result)
    assert result.estimates["valve.deadband_voltage"].warning == ""


@pytest.mark.parametrize(
    ("volts", "resistances", "once"),
    [
        # Four standard errors of the difference, hypot(0.03, 0.04) = 0.05 V.
        (((1.0, 0.03), (1.199, 0.04)), RESISTANCES, True),
        (((1.0, 0.03), (1.201, 0.04)), RESISTANCES, False),
        (((1.201, 0.03), (1.0, 0.04)), RESISTANCES, False),
        # Or 5 mV, or 0.3 %, where the errors are less.
        (((1.0, 1e-5), (1.0049, 1e-5)), RESISTANCES, True),
        (((1.0, 1e-5), (1.0051, 1e-5)), RESISTANCES, False),
        (VOLTS, ((1e12, 1e7), (1.0029e12, 1e7)), True),
        (VOLTS, ((1e12, 1e7), (1.0031e12, 1e7)), False),
        (VOLTS, ((1e12, 3e10), (1.19e12, 4e10)), True),
        (VOLTS, ((1e12, 3e10), (1.21e12, 4e10)), False),
    ],
)
def test_directions_are_pooled_only_while_both_numbers_agree(volts, resistances, once):
    result = found(volts=volts, resistances=resistances)
    before = dict(result.estimates)
    machine = pooled(result)
    assert (machine.valve.backward is None) is once
    assert once or (result.estimates == before and machine == result.machine)


def test_a_valve_that_the_start_tells_twice_stays_told_twice():
    result = found(start=dataclasses.replace(C180, valve=TWICE))
    assert pooled(result).valve.backward is not None
    stick = dataclasses.replace(C180.stick, valve=TWICE)
    result = found("stick.valve", start=dataclasses.replace(C180, stick=stick))
    assert pooled(result).stick.valve.backward is not None
    assert len(result.estimates) == 4


@pytest.mark.parametrize("missing", ["valve.deadband_voltage", "valve.backward.minimum_resistance"])
def test_a_direction_that_was_not_found_is_not_pooled(missing):
    result = found()
    del result.estimates[missing]
    assert pooled(result).valve.backward is not None


def test_one_section_is_pooled_where_another_is_not():
    result = found("boom.valve")
    result.estimates |= found("stick.valve", volts=((1.0, 0.01), (1.5, 0.01))).estimates
    stick = dataclasses.replace(C180.stick, valve=TWICE)
    result.machine = dataclasses.replace(result.machine, stick=stick)
    machine = pooled(result)
    assert machine.boom.valve.backward is None
    assert machine.stick.valve.backward is not None
    assert math.isclose(machine.boom.valve.deadband_voltage, 1.024)
