"""Claims about oil with air in it: density, modulus, enthalpy, and the floor under its pressure."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from forest_description.hydraulics.oil import EntrainedAir
from forest_description.machine import load_machine
from forest_sim.hydraulics.oil_law import density, enthalpy, held_above_vapour, is_near, oil_law
from forest_sim.hydraulics.oil_volume import OilVolume, content, filled_share, settled_pressure

OIL = load_machine("c180").oil
LAW, AIRLESS = oil_law(OIL), oil_law(dataclasses.replace(OIL, air=None))
BETA, TANK, VAPOUR, SHARE, DISSOLVED = 1.6e9, 101325.0, 100.0, 0.005, 3e6
PRESSURES = [-101220.0, -90e3, -30e3, -1.0, 0.0, 1.0, 5e4, 4e5, 1.5e6, 2.9e6, 3e6, 1e7, 2.4e7]


def room_by_hand(pressure):
    """Room of 1 m^3 of oil and 5 L of isothermal bubbles at tank pressure, a cubic share of them free."""
    s = min(1.0, max(0.0, pressure / DISSOLVED))
    free = 1.0 - 3.0 * s**2 + 2.0 * s**3
    air = SHARE * free * (TANK - VAPOUR) / (TANK + pressure - VAPOUR)
    return BETA / (BETA + pressure) + air


@pytest.mark.parametrize("pressure", PRESSURES)
def test_density_is_mass_over_the_room_of_oil_and_bubbles(pressure):
    assert density(pressure, LAW).ratio == pytest.approx((1.0 + SHARE) / room_by_hand(pressure), rel=1e-12)


@pytest.mark.parametrize("pressure", PRESSURES)
def test_the_slope_is_the_densitys(pressure):
    d = min(1.0, 1e-3 * (pressure + TANK - VAPOUR))
    differences = (density(pressure + d, LAW).ratio - density(pressure - d, LAW).ratio) / (2.0 * d)
    assert density(pressure, LAW).slope == pytest.approx(differences, rel=1e-3)


def test_half_a_percent_of_air_makes_the_oil_eighty_times_as_soft_at_tank_pressure():
    """1/beta_eff = 1/beta + alpha/p of Merritt's eq. 2-24 at tank pressure; all is dissolved at 3 MPa."""
    at_tank = density(0.0, LAW)
    assert at_tank.ratio / at_tank.slope == pytest.approx(1.0 / (1.0 / BETA + SHARE / TANK), rel=0.02)
    pressed = density(1e7, LAW)
    assert pressed.ratio / pressed.slope == pytest.approx(BETA + 1e7, rel=1e-9)
    for pressure in (0.0, 1e7):
        clean = density(pressure, AIRLESS)
        assert clean.ratio / clean.slope == pytest.approx(BETA + pressure, rel=1e-12)


@pytest.mark.parametrize("pressure", PRESSURES)
def test_the_enthalpy_is_the_integral_of_the_room(pressure):
    by_hand, _ = quad(lambda p: room_by_hand(p) / (1.0 + SHARE), 0.0, pressure, points=(0.0,), limit=200)
    assert enthalpy(pressure, LAW) == pytest.approx(by_hand, rel=1e-8, abs=1e-6)
    assert enthalpy(1e7, AIRLESS) == pytest.approx(BETA * math.log(1.0 + 1e7 / BETA), rel=1e-9)


def test_oil_grows_denser_with_pressure_and_to_nothing_as_it_boils():
    pressures = np.concatenate([VAPOUR - TANK + np.logspace(-6, 5, 200), np.linspace(0.0, 5e7, 500)])
    ratios = [density(p, LAW).ratio for p in sorted(pressures.tolist())]
    assert np.all(np.diff(ratios) > 0.0)
    assert 0.0 < ratios[0] < 1e-8


VOLUME = OilVolume(1, -0.0229, 0.01824, 3.5e-13, 0.0, 1e11, LAW)


@pytest.mark.parametrize("near", [-1e5, 0.0, 1e6, 1e8])
def test_the_pressure_of_a_content_is_found_from_afar(near):
    for wanted in (*PRESSURES, 1e8):
        held = content(wanted, 1.6, VOLUME).oil
        assert content(settled_pressure(near, held, 1.6, VOLUME), 1.6, VOLUME).oil == pytest.approx(
            held, rel=1e-13
        )


@pytest.mark.parametrize("owed", [1e-9, 1e-5, 0.01, 0.1])
@pytest.mark.parametrize("near", [-1e5, 0.0, 1e7])
def test_a_volume_that_owes_oil_has_a_pressure_a_few_pascals_below_the_vapours(owed, near):
    """What ran on out of an emptied volume comes back into it: none is made, and no vacuum is below."""
    space = content(0.0, 1.6, VOLUME).oil
    pressure = settled_pressure(near, -owed * space, 1.6, VOLUME)
    assert content(pressure, 1.6, VOLUME).oil == pytest.approx(-owed * space, rel=1e-9)
    assert -0.06 * VAPOUR < pressure + TANK - VAPOUR < 0.0
    assert math.isfinite(enthalpy(pressure, LAW))


def test_the_law_goes_through_the_vapours_pressure_without_a_jump():
    above, at = density(VAPOUR - TANK + 1e-9, LAW), density(VAPOUR - TANK, LAW)
    assert above.ratio == pytest.approx(0.0, abs=1e-11)
    assert at.ratio == 0.0
    assert at.slope == pytest.approx(10.0 * above.slope, rel=1e-6)


def test_a_motor_takes_what_oil_is_in_the_room_that_it_opens():
    """Half of the room beside the vapour's pressure, all of it from 10 kPa of absolute pressure on."""
    rotor = OilVolume(1, 2e-3, 0.0, 0.0, 0.0, 0.0, LAW)
    half = brentq(lambda p: (1.0 + SHARE) / room_by_hand(p) - 0.475, VAPOUR - TANK + 1e-3, 0.0)
    assert filled_share(1.0, half, 1e7, rotor) == pytest.approx(0.5, rel=1e-6)
    assert filled_share(-1.0, 1e7, half, rotor) == pytest.approx(0.5, rel=1e-6)
    assert filled_share(-1.0, half, 1e7, rotor) == 1.0
    assert filled_share(1.0, 1.1e4 - TANK, 1e7, rotor) == 1.0
    assert filled_share(1.0, -TANK, 1e7, rotor) == 0.0
    assert filled_share(1.0, half, 1e7, VOLUME) == 1.0  # a piston takes no oil from its chamber


def test_a_chamber_pulled_open_fills_with_its_bubbles():
    """Oil that fills a chamber at tank pressure, pulled to twice the room: an ideal gas and a vapour."""
    held = content(0.0, 1.6, VOLUME).oil
    wider = 1.6 + (held / 0.01824)
    pressure = settled_pressure(0.0, held, wider, VOLUME)
    by_hand = brentq(lambda p: room_by_hand(p) / (1.0 + SHARE) - 2.0, VAPOUR - TANK + 1e-3, 0.0)
    assert pressure == pytest.approx(by_hand, abs=0.02 * (by_hand + TANK))
    assert VAPOUR < pressure + TANK < 0.01 * TANK


def test_a_pressure_that_would_be_below_the_vapours_stays_above_it():
    assert held_above_vapour(-5e6, 0.0, LAW) == pytest.approx(0.1 * (TANK - VAPOUR) - (TANK - VAPOUR))
    assert held_above_vapour(-5e6, 0.0, AIRLESS) == -5e6
    assert not is_near(-5e6, 0.0, LAW)
    assert is_near(-5e6, 0.0, AIRLESS)


@pytest.mark.parametrize("pressure", [1.1e5, 1e6, 2.9e6, 1e7])
def test_a_tangent_that_counts_as_near_is_within_a_hundred_pascals(pressure):
    for off in (-1.0, 1.0):
        near = pressure + off * math.sqrt(0.99 * 100.0 * (pressure + TANK))
        if not is_near(pressure, near, LAW):
            continue
        there = density(near, LAW)
        along = there.ratio + there.slope * (pressure - near)
        assert abs(along - density(pressure, LAW).ratio) / there.slope < 150.0


def test_a_machine_says_where_its_oil_boils_and_what_it_holds():
    assert OIL.air == EntrainedAir(SHARE, DISSOLVED, TANK, VAPOUR)
    assert (LAW.air, LAW.above_vapour, LAW.dissolving) == (SHARE, TANK - VAPOUR, DISSOLVED)
