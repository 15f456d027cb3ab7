"""Claims about a hose: its laws, its port valves, and that a stage is solved exactly at every opening."""

import math

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import NO_GUARD
from forest_sim.hydraulics.hydraulic_line import (
    PortGuard,
    flow_rate,
    guard_flow,
    pressure_rate,
    solve_line,
    with_outflow,
)
from forest_sim.hydraulics.port import Port

MACHINE = load_machine("c180_hoses")
LINE = MACHINE.line(2, 1)
GUARD = PortGuard(24e6, 1e-8, 0.0, 1e-7)
SPRUNG = PortGuard(22e6, 3e-8, -4e5, 2e-7)  # whose checks open below the tank's pressure only
GUARDS = pytest.mark.parametrize("guard", [GUARD, SPRUNG, NO_GUARD], ids=["port valves", "sprung", "none"])
SUPPLY = 2e7
STEP = 3e-4
SHUT = Port(math.inf, math.inf, 0.0)


def cases(seed, count=300):
    """Known parts of a stage (pressure, flow, actuator flow, leakage, port): any opening, to either side."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        pressure, flow, drawn = rng.uniform(-2e6, 3e7), rng.normal(0.0, 2e-3), rng.normal(0.0, 2e-3)
        port = one_edge(10.0 ** rng.uniform(11.0, 18.0), float(rng.choice([0.0, SUPPLY])))
        yield pressure, flow, drawn, float(rng.choice([0.0, 1e-12])), port


def one_edge(resistance, source):
    """A port that is open to the supply or, at a source of zero, to the tank."""
    return Port(resistance, math.inf, 0.0) if source else Port(math.inf, resistance, 0.0)


def test_port_valves_are_shut_between_their_settings_and_meet_them_without_a_step():
    for pressure in (0.0, 1.0, 1e7, 24e6):
        assert guard_flow(pressure, GUARD) == 0.0
    assert guard_flow(24e6 + 1.0, GUARD) == pytest.approx(-1e-8)
    assert guard_flow(-1.0, GUARD) == pytest.approx(1e-7)


def test_relief_lets_oil_out_and_anticavitation_lets_it_in():
    assert guard_flow(25e6, GUARD) == pytest.approx(-1e-8 * 1e6)
    assert guard_flow(-1e4, GUARD) == pytest.approx(1e-7 * 1e4)
    assert guard_flow(-3e5, SPRUNG) == 0.0
    assert guard_flow(-5e5, SPRUNG) == pytest.approx(2e-7 * 1e5)
    assert guard_flow(23e6, SPRUNG) == pytest.approx(-3e-8 * 1e6)


def test_a_hose_without_port_valves_holds_any_pressure():
    for pressure in (-1e9, -1.0, 0.0, 1e9):
        assert guard_flow(pressure, NO_GUARD) == 0.0


def test_pressure_rises_with_what_comes_in_and_falls_with_what_goes_out():
    assert pressure_rate(1e7, 2e-3, 0.5e-3, LINE, GUARD) == pytest.approx(1.5e-3 / LINE.capacitance)
    assert pressure_rate(25e6, 0.0, 0.0, LINE, GUARD) < 0.0 < pressure_rate(-1e5, 0.0, 0.0, LINE, GUARD)


@pytest.mark.parametrize("source", [0.0, SUPPLY])
def test_flow_settles_where_the_edge_takes_the_whole_pressure_drop(source):
    port, pressure = one_edge(1.04e12, source), 8e6
    settled = math.copysign(math.sqrt(abs(source - pressure) / 1.04e12), source - pressure)
    assert flow_rate(pressure, settled, port, SUPPLY, LINE) == pytest.approx(0.0, abs=1e-9)
    assert flow_rate(pressure, 0.0, port, SUPPLY, LINE) == pytest.approx((source - pressure) / LINE.inertance)
    assert flow_rate(pressure, settled + 1e-4, port, SUPPLY, LINE) < 0.0
    assert flow_rate(pressure, settled - 1e-4, port, SUPPLY, LINE) > 0.0


@GUARDS
def test_a_solved_stage_fulfils_both_laws_of_the_hose(guard):
    opened = set()
    for pressure, flow, drawn, leakage, port in cases(1):
        end = solve_line(pressure, flow, drawn, leakage, port, SUPPLY, LINE, guard, STEP)
        opened.add(np.sign(guard_flow(end.pressure, guard)))
        rate = pressure_rate(end.pressure, end.flow, drawn + leakage * end.pressure, LINE, guard)
        assert end.pressure == pytest.approx(pressure + STEP * rate, rel=1e-9, abs=1.0)
        turn = flow_rate(end.pressure, end.flow, port, SUPPLY, LINE)
        assert end.flow == pytest.approx(flow + STEP * turn, rel=1e-6, abs=1e-12 * (1.0 + abs(STEP * turn)))
    assert opened == ({0.0} if guard is NO_GUARD else {-1.0, 0.0, 1.0})


@GUARDS
def test_stiffness_is_how_the_pressure_answers_the_actuators_flow(guard):
    h = 1e-9
    for pressure, flow, drawn, leakage, port in cases(2, 100):
        low, here, high = (
            solve_line(pressure, flow, drawn + d, leakage, port, SUPPLY, LINE, guard, STEP)
            for d in (-h, 0.0, h)
        )
        assert here.stiffness == pytest.approx((low.pressure - high.pressure) / (2.0 * h), rel=1e-4)


@GUARDS
def test_a_hose_that_gives_a_little_more_is_the_solved_one_to_first_order(guard):
    """Pressure, flow and the port's pressure; the cases cover both edges, and shut ones."""
    h = 1e-8
    for pressure, flow, drawn, leakage, port in [*cases(3, 100), (5e6, 2e-3, 1e-4, 1e-12, SHUT)]:
        here, more = (
            solve_line(pressure, flow, drawn + d, leakage, port, SUPPLY, LINE, guard, STEP) for d in (0.0, h)
        )
        if np.sign(guard_flow(here.pressure, guard)) != np.sign(guard_flow(more.pressure, guard)):
            continue
        told = with_outflow(here, h)
        assert told.pressure - here.pressure == pytest.approx(more.pressure - here.pressure, rel=1e-2)
        assert told.flow - here.flow == pytest.approx(more.flow - here.flow, rel=1e-2, abs=1e-3 * h)
        moved = more.port_pressure - here.port_pressure
        assert told.port_pressure - here.port_pressure == pytest.approx(moved, rel=1e-2, abs=1e-5)


def test_a_shut_port_stops_the_flow_and_traps_the_oil():
    end = solve_line(5e6, 2e-3, 1e-4, 0.0, SHUT, SUPPLY, LINE, NO_GUARD, STEP)
    assert end.flow == 0.0
    assert end.pressure == pytest.approx(5e6 - STEP * 1e-4 / LINE.capacitance)


def test_behind_a_shut_port_no_flow_begins_and_none_can_go_on():
    assert flow_rate(5e6, 0.0, SHUT, SUPPLY, LINE) == 0.0
    assert flow_rate(5e6, 1e-4, SHUT, SUPPLY, LINE) == -math.inf
    assert flow_rate(5e6, -1e-4, SHUT, SUPPLY, LINE) == math.inf


def test_a_closing_port_approaches_the_shut_one():
    shut = solve_line(5e6, 2e-3, 1e-4, 0.0, SHUT, SUPPLY, LINE, GUARD, STEP)
    nearly = solve_line(5e6, 2e-3, 1e-4, 0.0, Port(1e30, math.inf, 0.0), SUPPLY, LINE, GUARD, STEP)
    assert nearly.pressure == pytest.approx(shut.pressure, rel=1e-6)
    assert nearly.stiffness == pytest.approx(shut.stiffness, rel=1e-3)


@pytest.mark.parametrize("resistance", [1e11, 1e18, math.inf])
def test_a_hose_at_rest_at_its_sources_pressure_stays_so(resistance):
    end = solve_line(SUPPLY, 0.0, 0.0, 0.0, Port(resistance, math.inf, 0.0), SUPPLY, LINE, GUARD, STEP)
    assert end.pressure == pytest.approx(SUPPLY, rel=1e-15)
    assert end.flow == 0.0
