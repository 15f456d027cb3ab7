"""Claims about a valve's port: its flow and its hose's meet, whatever is open, and the supply feels it."""

import math

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import NO_GUARD
from forest_sim.hydraulics.hydraulic_line import (
    PortGuard,
    flow_rate,
    pressure_rate,
    solve_line,
    supply_coupling,
)
from forest_sim.hydraulics.port import Port, edge_flow, edge_flows, port_flow, solve_port

LINE = load_machine("c180_hoses").line(2, 1)
GUARD = PortGuard(24e6, 1e-8, 0.0, 1e-7)
STEP = 3e-4
SUPPLY = 2e7
OPEN = {"supply": (True, False), "tank": (False, True), "both": (True, True), "none": (False, False)}
each_connection = pytest.mark.parametrize("opened", OPEN.values(), ids=OPEN)


def ports(opened, seed, count=300, leaks=(0.0, 1e-13, 1e-10)):
    """Ports with these edges open, anything from a hair to wide, with and without leakage."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        c_r = [10.0 ** rng.uniform(11.0, 18.0) if is_open else math.inf for is_open in opened]
        leakage = float(rng.choice(leaks))
        if any(opened) or leakage:
            yield Port(*c_r, leakage, skew=leakage * rng.choice([0.0, -0.9, 0.6])), rng


@each_connection
@pytest.mark.parametrize("admittance", [0.0, 1e-11, 1e-9])
@pytest.mark.parametrize("supply", [SUPPLY, 3e6, 0.0])
def test_where_port_and_hose_meet_the_same_flows_through_both(opened, admittance, supply):
    """The flow left over is nothing to what a millionth of the pressures at play would drive."""
    for port, rng in ports(opened, 1, 150):
        intercept = rng.normal(0.0, 2e-3) * rng.choice([1.0, 1e-3, 1e-8, 0.0])
        p, flow_gain = solve_port(intercept, admittance, port, supply)
        at_play = abs(p) + supply + 1.0
        low, high = (
            port_flow(p + s * 1e-12 * at_play, port, supply)
            - intercept
            - admittance * (p + s * 1e-12 * at_play)
            for s in (1.0, -1.0)
        )
        assert low <= 1e-18
        assert high >= -1e-18
        assert 0.0 <= flow_gain <= 1.0


@each_connection
@pytest.mark.parametrize("admittance", [0.0, 1e-11, 1e-9])
def test_follows_is_the_flows_slope_by_the_intercept(opened, admittance):
    for port, rng in ports(opened, 2, 100):
        intercept, h = rng.normal(0.0, 2e-3), 1e-8
        low, high = (solve_port(intercept + d, admittance, port, SUPPLY).pressure for d in (-h, h))
        slope = 1.0 + admittance * (high - low) / (2.0 * h)
        assert solve_port(intercept, admittance, port, SUPPLY).flow_gain == pytest.approx(
            slope, rel=1e-3, abs=1e-5
        )


def test_a_root_beside_an_edge_without_drop_is_found_to_the_last_digits():
    """There Newton's slope is infinite on one side; the port of a nearly unloaded actuator stands there."""
    rng = np.random.default_rng(3)
    for _ in range(500):
        port = Port(10.0 ** rng.uniform(11.0, 18.0), 10.0 ** rng.uniform(11.0, 18.0), 0.0)
        admittance, gap = 10.0 ** rng.uniform(-13.0, -10.0), 10.0 ** rng.uniform(-3.0, 5.0)
        wall = float(rng.choice([0.0, SUPPLY]))
        wished = wall + gap * rng.choice([-1.0, 1.0])
        intercept = port_flow(wished, port, SUPPLY) - admittance * wished
        p = solve_port(intercept, admittance, port, SUPPLY).pressure
        assert p == pytest.approx(wished, abs=3e-6 + 1e-4 * gap * 1e-3)


def test_no_drop_and_no_flow_give_neither_nan_nor_a_step():
    for port in (Port(1e12, math.inf, 0.0), Port(math.inf, 1e12, 0.0), Port(1e12, 1e12, 0.0)):
        for supply in (0.0, SUPPLY):
            source = supply if port.to_supply < math.inf else 0.0
            intercept = -1e-10 * source if port.to_supply == math.inf or port.to_tank == math.inf else 0.0
            p, flow_gain = solve_port(intercept, 1e-10, port, supply)
            assert math.isfinite(p)
            assert 0.0 <= flow_gain <= 1.0
    assert solve_port(0.0, 1e-10, Port(math.inf, 1e12, 0.0), SUPPLY) == (0.0, 1.0)


def test_an_underlapped_port_without_flow_stands_between_supply_and_tank():
    assert solve_port(0.0, 0.0, Port(1e13, 1e13, 0.0), SUPPLY).pressure == pytest.approx(
        0.5 * SUPPLY, rel=1e-12
    )
    assert solve_port(0.0, 0.0, Port(1e13, 3e13, 0.0), SUPPLY).pressure == pytest.approx(
        0.75 * SUPPLY, rel=1e-12
    )
    leaking = Port(math.inf, math.inf, 1e-13)
    assert solve_port(0.0, 0.0, leaking, SUPPLY).pressure == pytest.approx(0.5 * SUPPLY, rel=1e-12)


@each_connection
def test_what_comes_from_the_supply_less_what_goes_to_the_tank_is_the_flow(opened):
    for port, rng in ports(opened, 4, 100):
        intercept, admittance = rng.normal(0.0, 2e-3), 1e-11
        p = solve_port(intercept, admittance, port, SUPPLY).pressure
        flow = intercept + admittance * p
        from_supply, to_tank = edge_flows(flow, p, port, SUPPLY)
        assert from_supply - to_tank == pytest.approx(flow, rel=1e-9, abs=1e-12)
        through_edge = edge_flow(SUPPLY - p, port.to_supply) + (port.leakage + port.skew) * (SUPPLY - p)
        assert from_supply == pytest.approx(through_edge, rel=1e-3, abs=1e-9)


def stages(opened, seed, count=120):
    """Known parts of a stage behind such ports: pressure, flow, actuator flow, its leakage, port."""
    for port, rng in ports(opened, seed, count):
        pressure, flow, drawn = rng.uniform(-2e6, 3e7), rng.normal(0.0, 2e-3), rng.normal(0.0, 2e-3)
        yield pressure, flow, drawn, float(rng.choice([0.0, 1e-12])), port


@each_connection
@pytest.mark.parametrize("guard", [GUARD, NO_GUARD], ids=["port valves", "none"])
def test_a_solved_stage_fulfils_both_laws_behind_any_port(opened, guard):
    for pressure, flow, drawn, leakage, port in stages(opened, 5):
        end = solve_line(pressure, flow, drawn, leakage, port, SUPPLY, LINE, guard, STEP)
        rate = pressure_rate(end.pressure, end.flow, drawn + leakage * end.pressure, LINE, guard)
        assert end.pressure == pytest.approx(pressure + STEP * rate, rel=1e-9, abs=1.0)
        turn = (end.port_pressure - end.pressure) / LINE.inertance
        assert end.flow == pytest.approx(flow + STEP * turn, rel=1e-9, abs=1e-12)
        through = port_flow(end.port_pressure, port, SUPPLY)
        low, high = (port_flow(end.port_pressure + d, port, SUPPLY) for d in (1e-2, -1e-2))
        assert low <= end.flow <= high or end.flow == pytest.approx(through, rel=1e-9, abs=1e-13)


@each_connection
@pytest.mark.parametrize("guard", [GUARD, NO_GUARD], ids=["port valves", "none"])
def test_coupling_is_how_flow_and_pressure_answer_the_supply_and_the_actuator(opened, guard):
    """Finite differences; by reciprocity dP/dP_s and dS/dq are one number."""
    told = 0
    for pressure, flow, drawn, leakage, port in stages(opened, 6):

        def at(supply, q, known=(pressure, flow, leakage, port)):
            pressure, flow, leakage, port = known
            end = solve_line(pressure, flow, q, leakage, port, supply, LINE, guard, STEP)
            return end, supply_coupling(end, port, supply, LINE, STEP)

        (end, here), d_p, d_q = at(SUPPLY, drawn), 50.0, 2e-8
        if abs(SUPPLY - end.port_pressure) < 1e3 or abs(end.port_pressure) < 1e3:
            continue  # at a kink a finite difference says nothing
        if min(abs(end.pressure - guard.relief_pressure), abs(end.pressure)) < 1e3:
            continue
        (down, draw_down), (up, draw_up) = at(SUPPLY - d_p, drawn), at(SUPPLY + d_p, drawn)
        (_, less), (_, more) = at(SUPPLY, drawn - d_q), at(SUPPLY, drawn + d_q)
        conductance = (draw_up.draw - draw_down.draw) / (2.0 * d_p)
        assert here.conductance == pytest.approx(conductance, rel=1e-3, abs=1e-15)
        assert here.gain == pytest.approx((up.pressure - down.pressure) / (2.0 * d_p), rel=1e-3, abs=1e-7)
        assert here.gain == pytest.approx((more.draw - less.draw) / (2.0 * d_q), rel=1e-3, abs=1e-6)
        told += 1
    assert told > (60 if any(opened) else 30)


def test_behind_a_port_that_only_leaks_the_flow_is_laminar():
    port = Port(math.inf, math.inf, 1e-12)
    pressure = 7e6
    settled = 1e-12 * (SUPPLY - 2.0 * pressure)
    assert flow_rate(pressure, settled, port, SUPPLY, LINE) == pytest.approx(0.0, abs=1e-6)
    assert flow_rate(pressure, 2.0 * settled, port, SUPPLY, LINE) < 0.0
