"""Claims about the oil in a hose and its chamber: what it holds, how it yields, what energy it takes."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import quad

from forest_description.hydraulics.hose import Line
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import NO_GUARD
from forest_sim.hydraulics.hydraulic_line import solve_line
from forest_sim.hydraulics.oil_law import density, enthalpy, oil_law
from forest_sim.hydraulics.oil_volume import (
    OilVolume,
    content,
    hose_drop,
    settled_pressure,
    stage_hose,
    stored_energy,
)
from forest_sim.hydraulics.port import Port
from forest_sim.hydraulics.side import Side, side_rates, storage

OIL = load_machine("c180").oil
BETA, AREA, WALL = OIL.bulk_modulus, 0.01824, 3.5e-13
CLEAN = OilVolume(1, -0.0229, AREA, WALL, 0.0, 1e11, oil_law(dataclasses.replace(OIL, air=None)))
AIRY = CLEAN._replace(oil=oil_law(OIL))
LINE = Line(1e11, 1.2e7, 6.3e-13)
OPEN = Port(1e12, np.inf, 0.0)
SUPPLY = 2e7
RNG = np.random.default_rng(15)
STATES = RNG.uniform((5e4, 1.31, -0.3, -2e-3), (2.4e7, 2.2, 0.3, 2e-3), (20, 4)).tolist()
BOTH = pytest.mark.parametrize("volume", [CLEAN, AIRY], ids=["clean", "with air"])
ANYWHERE = pytest.mark.parametrize(("pressure", "position", "speed", "flow"), STATES[:8])


def side_of(volume, pressure, position, speed, flow):
    return Side(pressure, flow, AREA * speed, position, speed, OPEN, LINE, volume)


@pytest.mark.parametrize(("pressure", "position", "speed", "flow"), STATES)
def test_pressure_rises_as_the_textbook_has_it(pressure, position, speed, flow):
    """dP/dt = (Q - A v)/(V/beta + C_w), Merritt eq. 3-15, which counts flows at the pressure inside."""
    capacitance = (-0.0229 + AREA * position) / BETA + WALL
    rate = side_rates(side_of(CLEAN, pressure, position, speed, flow), SUPPLY, NO_GUARD).pressure
    passing = abs(flow) + abs(AREA * speed)
    assert capacitance * rate == pytest.approx(flow - AREA * speed, abs=0.02 * passing)


@BOTH
@ANYWHERE
def test_flows_count_the_same_oil_whatever_its_pressure(volume, pressure, position, speed, flow):
    """Oil that a flow brings in and the piston's way make one content: dn/dt = Q, along any motion."""
    rate = side_rates(side_of(volume, pressure, position, speed, flow), SUPPLY, NO_GUARD).pressure
    h = 1e-3 * pressure / max(abs(rate), pressure)
    before, after = (
        content(pressure + s * h * rate, position + s * h * speed, volume).oil for s in (-1.0, 1.0)
    )
    assert (after - before) / (2.0 * h) == pytest.approx(flow, abs=1e-3 * abs(flow) + 1e-6)


@BOTH
@pytest.mark.parametrize("pressure", [-9e4, 1e5, 5e6, 2e7])
def test_the_stored_energy_is_the_work_of_pressing_oil_into_a_fixed_volume(volume, pressure):
    work, _ = quad(
        lambda p: enthalpy(p, volume.oil) * content(p, 1.5, volume).capacitance,
        *(0.0, pressure),
        limit=200,
    )
    assert stored_energy(pressure, 1.5, volume) == pytest.approx(work, rel=1e-5)


@BOTH
@ANYWHERE
def test_what_flows_in_is_stored_or_handed_to_the_piston(volume, pressure, position, speed, flow):
    """P Q = d(stored)/dt + compression + P A v + the hose's loss, the stored energy by differences."""
    side = side_of(volume, pressure, position, speed, flow)
    rates, taken_up = side_rates(side, SUPPLY, NO_GUARD), storage(side, SUPPLY, NO_GUARD)
    h = 1e-3 * pressure / max(abs(rates.pressure), pressure)

    def energy(s):
        oil = stored_energy(pressure + s * h * rates.pressure, position + s * h * speed, volume)
        return oil + 0.5 * LINE.inertance * (flow + s * h * rates.flow) ** 2

    differences = (energy(1.0) - energy(-1.0)) / (2.0 * h)
    assert taken_up.stored == pytest.approx(differences, rel=1e-4, abs=1.0)
    at_valve = LINE.inertance * rates.flow + pressure + hose_drop(flow, volume)
    handed = pressure * AREA * speed + hose_drop(flow, volume) * flow
    assert at_valve * flow == pytest.approx(taken_up.stored + taken_up.compression + handed, rel=1e-9)


@BOTH
@ANYWHERE
def test_an_implicit_stage_keeps_the_oil_to_the_last_drop(volume, pressure, position, speed, flow):
    """Along a tangent anywhere: what the stage's flow has brought is what the settled pressure holds."""
    h, after = 3e-4, position + 3e-4 * speed
    known = content(pressure, position, volume).oil
    for near in (pressure, 0.5 * pressure, pressure + 1e6):
        hose = stage_hose(known, flow, after, near, LINE, volume, h)
        s = solve_line(hose.pressure, hose.flow, 0.0, 0.0, OPEN, SUPPLY, hose.line, NO_GUARD, h)
        brought = hose.line.capacitance * (s.pressure - hose.pressure)
        assert brought == pytest.approx(h * s.flow, rel=1e-9)
        settled = settled_pressure(s.pressure, known + brought, after, volume)
        assert content(settled, after, volume).oil == pytest.approx(known + h * s.flow, rel=1e-13)


def test_a_stages_hose_meets_the_momentum_of_oil_against_its_resistance():
    h, pressure, flow = 3e-4, 1e7, 1.2e-3
    known = content(pressure, 1.5, CLEAN).oil
    hose = stage_hose(known, flow, 1.5, pressure, LINE, CLEAN, h)
    s = solve_line(hose.pressure, hose.flow, 0.0, 0.0, OPEN, SUPPLY, hose.line, NO_GUARD, h)
    pushed = s.port_pressure - s.pressure - hose_drop(s.flow, CLEAN)
    assert LINE.inertance * (s.flow - flow) / h == pytest.approx(pushed, rel=2e-3)


def test_a_piston_takes_oil_at_the_density_that_it_has():
    known = content(1e7, 1.5, AIRY).oil
    hose = stage_hose(known, 0.0, 1.5, 1e7, LINE, AIRY, 3e-4)
    assert hose.density == density(1e7, AIRY.oil).ratio == pytest.approx(1.005 * (1.0 + 1e7 / BETA))
