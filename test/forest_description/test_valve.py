"""Claims about the valve law."""

import math

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_description.valve import ValveLaw, orifice_opening, orifice_resistance, voltage_for_opening

LAW = ValveLaw(1.0, 10.0, 1.04e12)


def test_law_has_the_constants_of_the_machine():
    assert load_machine("c180").valve.law == LAW


@pytest.mark.parametrize("voltage", [0.0, 0.5, -0.99, 1.0, -1.0, math.nan])
def test_nothing_flows_inside_the_overlap(voltage):
    assert orifice_resistance(voltage, LAW) == math.inf
    assert orifice_opening(voltage, LAW) == 0.0


@pytest.mark.parametrize(
    ("voltage", "times_minimum"), [(10.0, 1.0), (5.5, 4.0), (4.0, 9.0), (1.9, 100.0), (2.0, 81.0)]
)
def test_resistance_falls_with_the_square_of_the_voltage_beyond_the_overlap(voltage, times_minimum):
    assert orifice_resistance(voltage, LAW) == pytest.approx(1.04e12 * times_minimum, rel=1e-12)


def test_resistance_is_the_same_in_both_directions():
    for voltage in np.random.default_rng(2).uniform(1.0, 10.0, 100).tolist():
        assert orifice_resistance(-voltage, LAW) == orifice_resistance(voltage, LAW)


@pytest.mark.parametrize("voltage", [10.0, 11.0, -40.0, math.inf])
def test_valve_opens_no_further_than_at_the_rated_voltage(voltage):
    assert orifice_resistance(voltage, LAW) == 1.04e12
    assert orifice_opening(voltage, LAW) == 1.0


def test_opening_is_the_square_root_of_the_resistance_ratio():
    for voltage in np.random.default_rng(3).uniform(1.001, 10.0, 100).tolist():
        ratio = LAW.minimum_resistance / orifice_resistance(voltage, LAW)
        assert orifice_opening(voltage, LAW) == pytest.approx(math.sqrt(ratio), rel=1e-12)


def test_voltage_for_opening_inverts_the_opening_in_both_directions():
    for opening in np.random.default_rng(4).uniform(-1.0, 1.0, 100).tolist():
        voltage = voltage_for_opening(opening, LAW)
        assert math.copysign(orifice_opening(voltage, LAW), voltage) == pytest.approx(opening, abs=1e-15)


def test_no_opening_is_the_middle_of_the_overlap_and_too_much_is_the_rated_voltage():
    assert voltage_for_opening(0.0, LAW) == 0.0
    assert voltage_for_opening(math.nan, LAW) == 0.0
    assert voltage_for_opening(1.5, LAW) == 10.0
    assert voltage_for_opening(-1.5, LAW) == -10.0
