"""Claims about the valve law."""

import math

import numpy as np
import pytest

from forest_description.hydraulics.valve_characteristic import (
    edges,
    opening_at,
    stroke,
    symmetric_valve,
    voltage_for_opening,
)
from forest_description.machine import load_machine

LAW = symmetric_valve(1.0, 10.0, 1.04e12)


def resistance(voltage, law=LAW):
    """C_R of the edge to port 1 that this voltage opens, the supply's forwards and the tank's backwards."""
    e = edges(voltage, law)
    assert math.inf in (e.supply_1, e.tank_1)
    return min(e.supply_1, e.tank_1)


def opening(voltage, law=LAW):
    return math.sqrt(1.04e12 / resistance(voltage, law))


def test_law_has_the_constants_of_the_machine():
    assert load_machine("c180_hoses").valve.law == LAW


@pytest.mark.parametrize("voltage", [0.0, 0.5, -0.99, 1.0, -1.0, math.nan])
def test_nothing_flows_inside_the_overlap(voltage):
    assert edges(voltage, LAW) == (math.inf,) * 4


@pytest.mark.parametrize("voltage", [1e-7, 1e-30, 1e-170, -1e-170])
def test_a_spool_that_comes_ever_nearer_to_a_critical_centre_shuts(voltage):
    critical = symmetric_valve(0.0, 10.0, 1.04e12)
    assert edges(voltage, critical) == (math.inf,) * 4
    assert edges(math.copysign(1e-5, voltage), critical) != (math.inf,) * 4


@pytest.mark.parametrize(
    ("voltage", "times_minimum"), [(10.0, 1.0), (5.5, 4.0), (4.0, 9.0), (1.9, 100.0), (2.0, 81.0)]
)
def test_resistance_falls_with_the_square_of_the_voltage_beyond_the_overlap(voltage, times_minimum):
    assert resistance(voltage) == pytest.approx(1.04e12 * times_minimum, rel=1e-12)


def test_resistance_is_the_same_in_both_directions():
    for voltage in np.random.default_rng(2).uniform(1.0, 10.0, 100).tolist():
        there, back = edges(voltage, LAW), edges(-voltage, LAW)
        assert there.supply_1 == there.tank_2 == back.supply_2 == back.tank_1 < math.inf
        assert there.tank_1 == there.supply_2 == back.tank_2 == back.supply_1 == math.inf


@pytest.mark.parametrize("voltage", [10.0, 11.0, -40.0, math.inf])
def test_valve_opens_no_further_than_at_the_rated_voltage(voltage):
    assert resistance(voltage) == 1.04e12


def test_opening_is_the_square_root_of_the_resistance_ratio():
    for voltage in np.random.default_rng(3).uniform(1.001, 10.0, 100).tolist():
        u = opening_at(stroke(voltage, LAW.forward), LAW.curve)
        assert u == pytest.approx(math.sqrt(LAW.forward.resistance_1 / resistance(voltage)), rel=1e-12)


def test_voltage_for_opening_inverts_the_opening_in_both_directions():
    for wished in np.random.default_rng(4).uniform(-1.0, 1.0, 100).tolist():
        voltage = voltage_for_opening(wished, LAW)
        assert math.copysign(opening(voltage), voltage) == pytest.approx(wished, abs=1e-14)


def test_no_opening_is_the_middle_of_the_overlap_and_too_much_is_the_rated_voltage():
    assert voltage_for_opening(0.0, LAW) == 0.0
    assert voltage_for_opening(math.nan, LAW) == 0.0
    assert voltage_for_opening(1.5, LAW) == 10.0
    assert voltage_for_opening(-1.5, LAW) == -10.0
