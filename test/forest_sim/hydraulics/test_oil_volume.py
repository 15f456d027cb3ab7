"""Claims about the oil in a hose and its chamber: what it holds, how it yields, what energy it takes."""

import numpy as np
import pytest
from scipy.integrate import quad

from forest_description.components.hose import Line
from forest_sim.hydraulics.hydraulic_line import guard_flow, solve_line
from forest_sim.hydraulics.oil_volume import (
    OilVolume,
    capacitance,
    content,
    density_ratio,
    enthalpy,
    hose_drop,
    space,
    stage_hose,
    stored_energy,
)
from forest_sim.hydraulics.port import Port
from forest_sim.hydraulics.side import Side, side_rates, storage
from forest_sim.solver.plant_parameters import NO_GUARD

BETA = 1.6e9
HEAD = OilVolume(1, -0.0229, 0.01824, 3.5e-13, 1.0 / BETA, 0.0, 1e11)
LINE = Line(1e11, 1.2e7, 6.3e-13)
OPEN = Port(1e12, np.inf, 0.0)
SUPPLY = 2e7
RNG = np.random.default_rng(15)
STATES = RNG.uniform((0.0, 1.31, -0.3, -2e-3), (2.4e7, 2.2, 0.3, 2e-3), (20, 4)).tolist()


@pytest.mark.parametrize(("pressure", "position", "speed", "flow"), STATES)
def test_pressure_rises_as_the_textbook_has_it(pressure, position, speed, flow):
    """dP/dt = (Q - A v)/(V/beta + C_w), Merritt eq. 3-15, which counts flows at the pressure inside."""
    side = Side(pressure, flow, HEAD.area * speed, position, speed, OPEN, LINE, HEAD)
    volume = -0.0229 + 0.01824 * position
    textbook = (flow - 0.01824 * speed) / (volume / BETA + 3.5e-13)
    rate = side_rates(side, SUPPLY, NO_GUARD).pressure
    passing = (abs(flow) + abs(0.01824 * speed)) / (volume / BETA + 3.5e-13)
    assert rate == pytest.approx(textbook, abs=0.02 * passing)


def test_flows_count_the_same_oil_whatever_its_pressure():
    """Oil that a flow brings in and the piston's way make one content: dn/dt = Q, along any motion."""
    for pressure, position, speed, flow in STATES:
        side = Side(pressure, flow, HEAD.area * speed, position, speed, OPEN, LINE, HEAD)
        rate, h = side_rates(side, SUPPLY, NO_GUARD).pressure, 1e-6
        before, after = (
            content(pressure + s * h * rate, position + s * h * speed, HEAD) for s in (-1.0, 1.0)
        )
        assert (after - before) / (2.0 * h) == pytest.approx(flow, abs=1e-3 * abs(flow) + 1e-9)


@pytest.mark.parametrize("pressure", [1e5, 5e6, 2e7])
def test_the_enthalpy_and_the_energy_are_the_integrals_that_define_them(pressure):
    h, _ = quad(lambda p: 1.0 / density_ratio(p, HEAD), 0.0, pressure)
    assert enthalpy(pressure, HEAD) == pytest.approx(h, rel=1e-9)
    # The work of pressing oil into a fixed volume, h dn.
    work, _ = quad(lambda p: enthalpy(p, HEAD) * (space(1.5, HEAD) / BETA + HEAD.wall), 0.0, pressure)
    assert stored_energy(pressure, 1.5, HEAD) == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize(("pressure", "position", "speed", "flow"), STATES[:8])
def test_what_flows_in_is_stored_or_handed_to_the_piston(pressure, position, speed, flow):
    """P Q = d(stored)/dt + compression + P A v + the hose's loss, the stored energy by differences."""
    side = Side(pressure, flow, HEAD.area * speed, position, speed, OPEN, LINE, HEAD)
    rates, taken_up, h = side_rates(side, SUPPLY, NO_GUARD), storage(side, SUPPLY, NO_GUARD), 1e-5

    def energy(s):
        oil = stored_energy(pressure + s * h * rates.pressure, position + s * h * speed, HEAD)
        return oil + 0.5 * LINE.inertance * (flow + s * h * rates.flow) ** 2

    differences = (energy(1.0) - energy(-1.0)) / (2.0 * h)
    assert taken_up.stored == pytest.approx(differences, rel=1e-4, abs=1.0)
    at_valve = LINE.inertance * rates.flow + pressure + hose_drop(flow, HEAD)
    handed = pressure * HEAD.area * speed + hose_drop(flow, HEAD) * flow
    assert at_valve * flow == pytest.approx(taken_up.stored + taken_up.compression + handed, rel=1e-9)


def test_an_implicit_stage_keeps_the_oil_to_the_last_drop():
    for pressure, position, speed, flow in STATES:
        h, known = 3e-4, content(pressure, position, HEAD)
        hose = stage_hose(known, flow, position + h * speed, LINE, HEAD, h)
        s = solve_line(hose.pressure, hose.flow, 0.0, 0.0, OPEN, SUPPLY, hose.line, NO_GUARD, h)
        after = content(s.pressure, position + h * speed, HEAD)
        assert after - known == pytest.approx(h * (s.flow + guard_flow(s.pressure, NO_GUARD)), abs=1e-15)
        assert hose.line.capacitance == capacitance(position + h * speed, HEAD)


def test_a_stages_hose_meets_the_momentum_of_oil_against_its_resistance():
    h, pressure, flow = 3e-4, 1e7, 1.2e-3
    hose = stage_hose(content(pressure, 1.5, HEAD), flow, 1.5, LINE, HEAD, h)
    s = solve_line(hose.pressure, hose.flow, 0.0, 0.0, OPEN, SUPPLY, hose.line, NO_GUARD, h)
    pushed = s.port_pressure - s.pressure - hose_drop(s.flow, HEAD)
    assert LINE.inertance * (s.flow - flow) / h == pytest.approx(pushed, rel=2e-3)
