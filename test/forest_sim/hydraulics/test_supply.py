"""Claims about the pumps' laws: fig. 3.4's characteristic, its limits, and where a pump rests."""

import math

import numpy as np
import pytest
from full_machine import BAND, PRESSURE, PUMPS, RELIEF, SHARED, with_pump

from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.supply import (
    SupplyState,
    available_flow,
    pump_flow,
    reference_after,
    reference_rate,
    saturation,
    supply,
)
from forest_sim.solver.equilibrium import idle_supply

COMPENSATED, CONSTANT, SENSING = (supply(PUMPS[n]) for n in ("compensated", "constant flow", "load sensing"))
FULL = 2 * 45e-6 * 2500 / 60.0  # two pumps, 45 cm3/rev, 2500 rpm
LEAK = 1.0 / SHARED["leakage_resistance"]
RELIEF_CONDUCTANCE = SHARED["relief_conductance"]
WEAK = supply(with_pump("compensated", engine_power=4e4).pump)
each_pump = pytest.mark.parametrize(
    "s", [COMPENSATED, CONSTANT, SENSING, WEAK], ids=["pc", "cf", "ls", "weak"]
)


def test_under_its_pressure_a_pump_gives_all_it_displaces_less_its_leakage():
    for s in (COMPENSATED, CONSTANT, SENSING):
        for pressure in (0.0, 1e5, 1e7):
            flow = pump_flow(pressure, PRESSURE, s)
            assert flow.displaced == pytest.approx(FULL)
            assert flow.delivered == pytest.approx(FULL - LEAK * pressure)


def test_a_compensator_takes_the_flow_back_within_its_band():
    for share in (0.0, 0.25, 0.5, 1.0):
        flow = pump_flow(PRESSURE - share * BAND, PRESSURE, COMPENSATED)
        assert flow.displaced == pytest.approx(share * FULL, abs=1e-12)
    assert pump_flow(PRESSURE - 1.5 * BAND, PRESSURE, COMPENSATED).displaced == pytest.approx(FULL)
    assert pump_flow(PRESSURE + BAND, PRESSURE, COMPENSATED).displaced == 0.0


def test_the_engine_cuts_the_corner_of_the_characteristic():
    """Thesis fig. 3.4: full flow up to the corner, constant power from there."""
    power = 4e4 * SHARED["mechanical_efficiency"]
    corner = power / FULL
    assert 0.3 * PRESSURE < corner < 0.9 * PRESSURE
    for pressure in np.linspace(0.1, 0.99, 20) * corner:
        assert pump_flow(pressure, PRESSURE, WEAK).displaced == pytest.approx(FULL)
    for pressure in np.linspace(corner * 1.01, PRESSURE - BAND, 20):
        assert pump_flow(pressure, PRESSURE, WEAK).displaced * pressure == pytest.approx(power, rel=1e-12)


def test_the_relief_valve_takes_what_nobody_wants_of_a_constant_flow():
    idle = idle_supply(CONSTANT)
    assert idle.pressure > PRESSURE  # this pump's nominal pressure is its relief valve's
    over = RELIEF_CONDUCTANCE * (idle.pressure - PRESSURE)
    assert over == pytest.approx(FULL - LEAK * idle.pressure, rel=1e-9)
    assert pump_flow(idle.pressure, PRESSURE, CONSTANT).displaced == pytest.approx(FULL)


def test_the_main_relief_valve_guards_a_compensated_pump_too():
    above, at = (pump_flow(RELIEF + d, PRESSURE, COMPENSATED).delivered for d in (1e5, 0.0))
    assert above - at == pytest.approx(-1e5 * (RELIEF_CONDUCTANCE + LEAK))


@each_pump
def test_slope_is_the_delivered_flows_and_never_rises(s):
    for pressure in np.random.default_rng(1).uniform(1e5, 2.5e7, 300):
        h = 1.0
        low, high = (pump_flow(pressure + d, PRESSURE, s).delivered for d in (-h, h))
        assert pump_flow(pressure, PRESSURE, s).slope == pytest.approx(
            (high - low) / (2 * h), rel=1e-4, abs=1e-15
        )
        assert high <= low


@each_pump
def test_delivered_power_is_never_more_than_the_engine_gives(s):
    for pressure in np.linspace(0.0, 2.5e7, 200):
        assert pump_flow(pressure, PRESSURE, s).displaced * pressure <= s.power_limit * (1.0 + 1e-12)


@each_pump
def test_at_rest_a_pump_delivers_nothing(s):
    idle = idle_supply(s)
    delivered = [pump_flow(idle.pressure + d, idle.reference, s).delivered for d in (-1e-3, 1e-3)]
    assert delivered[0] > 0.0 > delivered[1]
    assert idle.reference == (2e6 if s is SENSING else PRESSURE)


def test_an_ideal_pump_rests_at_its_pressure_and_never_saturates():
    s = supply(PUMPS["ideal"])
    assert idle_supply(s) == SupplyState(PRESSURE, PRESSURE)
    assert saturation(1.0, PRESSURE, s) == 0.0


def test_saturation_is_the_share_of_what_the_pump_can_give():
    for s in (COMPENSATED, CONSTANT, WEAK):
        most = available_flow(1.5e7, s) - LEAK * 1.5e7
        for share in (0.0, 0.3, 1.0):
            assert saturation(share * most, 1.5e7, s) == pytest.approx(share)
        assert saturation(2.0 * most, 1.5e7, s) == 1.0
        assert saturation(-most, 1.5e7, s) == 0.0
    assert available_flow(1.5e7, WEAK) < available_flow(1.5e7, COMPENSATED)


def test_load_sensing_aims_a_margin_above_the_load_and_no_higher_than_the_pump_may():
    assert reference_rate(7e6 + 2e6, 7e6, SENSING) == 0.0
    assert reference_rate(5e6, 7e6, SENSING) == pytest.approx((9e6 - 5e6) / 0.05)
    assert reference_rate(PRESSURE, 3e7, SENSING) == 0.0
    assert reference_rate(2e6, -5e6, SENSING) == 0.0
    assert reference_rate(5e6, 7e6, COMPENSATED) == 0.0


def test_the_implicit_reference_fulfils_its_law():
    for load in (0.0, 7e6, 3e7):
        for step in (1e-4, 1e-2, 1.0):
            after = reference_after(6e6, load, SENSING, step)
            assert after == pytest.approx(6e6 + step * reference_rate(after, load, SENSING), rel=1e-12)
    assert reference_after(PRESSURE, 7e6, COMPENSATED, 1.0) == PRESSURE


def test_absent_limits_are_neutral_numbers():
    for name in PUMPS:
        s = plant_parameters(with_pump(name)).supply
        assert not any(math.isnan(value) for value in (*s[:-2], *s.oil, *s.drive))
        assert s.set_pressure == PRESSURE
        assert (s.compensation > 0.0) == (name in ("compensated", "load sensing"))
        assert (s.rate > 0.0) == (name == "load sensing")
