"""Claims about the oil: its laws over temperature, and that its description may move along them."""

import dataclasses
import itertools
import math

import pytest

from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine

OIL = load_machine("c180_hoses").oil
TEMPERATURES = [243.15, 273.15, 313.15, 340.0, 373.15, 393.15]


def test_the_viscosity_goes_through_both_points_of_the_data_sheet():
    assert OIL.kinematic_viscosity(313.15) == pytest.approx(46e-6, rel=1e-12)
    assert OIL.kinematic_viscosity(373.15) == pytest.approx(6.8e-6, rel=1e-12)


def test_the_viscosity_in_between_and_beyond_is_that_of_the_astm_chart():
    """log10 log10(ν + 0.7) = A - B log10 T, solved here by hand from the two points."""

    def ordinate(viscosity):
        return math.log10(math.log10(viscosity + 0.7))

    b = (ordinate(46.0) - ordinate(6.8)) / (math.log10(373.15) - math.log10(313.15))
    a = ordinate(46.0) + b * math.log10(313.15)
    for temperature in TEMPERATURES:
        expected = 10.0**10.0 ** (a - b * math.log10(temperature)) - 0.7
        assert OIL.kinematic_viscosity(temperature) * 1e6 == pytest.approx(expected, rel=1e-10)


def test_oil_thins_expands_and_softens_as_it_warms():
    warmer = [OIL.at(temperature) for temperature in TEMPERATURES]
    for cold, hot in itertools.pairwise(warmer):
        assert hot.kinematic_viscosity(hot.reference_temperature) < cold.kinematic_viscosity(
            cold.reference_temperature
        )
        assert hot.density < cold.density
        assert hot.bulk_modulus < cold.bulk_modulus
        assert hot.volume > cold.volume


def test_density_and_bulk_modulus_have_the_slopes_that_the_file_gives():
    step = 0.01
    warm, cold = OIL.at(313.15 + step), OIL.at(313.15 - step)
    expansion = (cold.density - warm.density) / (2.0 * step * OIL.density)
    assert expansion == pytest.approx(OIL.thermal_expansion, rel=1e-6)
    slope = (warm.bulk_modulus - cold.bulk_modulus) / (2.0 * step)
    assert slope == pytest.approx(-8e6, rel=1e-6)


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_the_same_oil_has_the_same_laws_and_mass_at_any_reference_temperature(temperature):
    moved = OIL.at(temperature)
    assert moved.heat_capacity == pytest.approx(OIL.heat_capacity, rel=1e-12)
    for other in TEMPERATURES:
        assert moved.absolute_viscosity(other) == pytest.approx(OIL.absolute_viscosity(other), rel=1e-12)
        *numbers, air = dataclasses.astuple(moved.at(other))
        assert numbers == pytest.approx(dataclasses.astuple(OIL.at(other))[:-1], rel=1e-12)
        assert air is OIL.air


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hot_temperature": 300.0}, "cold_temperature .* must be smaller than hot_temperature"),
        ({"hot_viscosity": 50e-6}, "hot_viscosity .* must be smaller than cold_viscosity"),
        ({"density": 86.0}, r"Oil\.density: 86 kg/m3 is outside 500 \.\. 2000"),
    ],
)
def test_an_impossible_oil_is_refused(change, message):
    with pytest.raises(MachineError, match=message):
        dataclasses.replace(OIL, **change)


@pytest.mark.parametrize("temperature", [40.0, 500.0, math.nan])
def test_a_temperature_that_no_oil_has_is_refused(temperature):
    with pytest.raises(MachineError, match=r"Oil\.reference_temperature"):
        OIL.at(temperature)


def test_oil_that_would_have_no_stiffness_left_keeps_the_least():
    soft = dataclasses.replace(OIL, bulk_modulus_slope=-3e7)
    assert soft.at(373.15).bulk_modulus == 1e8
