"""Claims about load checks: oil goes from the supply to the load, never back, and nothing else changes."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import load_machine
from forest_sim.equations.plant import axis_draw
from forest_sim.equations.plant_parameters import NO_GUARD, plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.hydraulics.hydraulic_line import flow_rate, pressure_rate, solve_line, supply_coupling
from forest_sim.hydraulics.port import Port, edge_flows, port_pressure
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium

C180 = load_machine("c180_hoses")
LINE = C180.line(2, 1)
STEP = 3e-4
OUTSTRETCHED = inverse_kinematics((6.5, 0.0, 0.5), C180.manipulator.links)
WEAK = dataclasses.replace(C180, pump=dataclasses.replace(C180.pump, displacement=C180.pump.displacement / 6))


def with_checks(machine):
    return dataclasses.replace(machine, valve=dataclasses.replace(machine.valve, load_check="ideal"))


def solutions(check):
    """Random hoses behind ports that are open to the supply, and what solves a stage of theirs."""
    rng = np.random.default_rng(11)
    for _ in range(600):
        to_tank = 10.0 ** rng.uniform(11.0, 16.0) if rng.random() < 0.4 else math.inf
        port = Port(10.0 ** rng.uniform(11.0, 16.0), to_tank, float(rng.choice([0.0, 1e-13])), check)
        pressure, supply = rng.uniform(0.0, 2e7, 2).tolist()
        flow, drawn = rng.uniform(0.0, 3e-5), rng.normal(0.0, 1e-3)
        solved = solve_line(pressure, flow, drawn, 1e-12, port, supply, LINE, NO_GUARD, STEP)
        yield port, (pressure, flow, drawn), supply, solved


def from_supply(port, supply, solved):
    """What comes through the edge itself; the lands leak either way."""
    p = solved.port_pressure
    return edge_flows(solved.flow, p, port, supply)[0] - port.leakage * (supply - p)


def test_no_oil_goes_back_to_the_supply():
    back = [from_supply(port, supply, solved) for port, _, supply, solved in solutions(check=0)]
    kept = [from_supply(port, supply, solved) for port, _, supply, solved in solutions(check=1)]
    assert sum(flow < -1e-6 for flow in back) > 100
    assert min(kept) > -1e-15


def test_forward_nothing_is_different():
    same = 0
    for (port, _, supply, free), (_, _, _, checked) in zip(solutions(0), solutions(1), strict=True):
        if from_supply(port, supply, free) > 0.0:
            assert checked == free
            same += 1
    assert same > 100


def test_the_supply_feels_a_checked_port_as_any_other_forward_and_only_its_leakage_backward():
    forward = backward = 0
    for (open_, _, supply, free), (port, _, _, solved) in zip(solutions(0), solutions(1), strict=True):
        felt = supply_coupling(solved, port, supply, LINE, STEP)
        if from_supply(open_, supply, free) > 0.0:
            assert felt == supply_coupling(free, open_, supply, LINE, STEP)
            assert felt.draw > 0.0
            forward += 1
        elif solved.port_pressure > supply:
            assert felt.draw == pytest.approx(port.leakage * (supply - solved.port_pressure), abs=1e-15)
            assert felt.conductance <= port.leakage
            backward += 1
    assert min(forward, backward) > 100


def test_a_resting_hose_behind_a_check_still_sees_the_tank_through_an_open_edge():
    assert port_pressure(1.5e7, 0.0, Port(1e12, 1e12, 0.0, 1), 1e7) == pytest.approx(0.5e7)
    assert port_pressure(1.5e7, 0.0, Port(1e12, math.inf, 0.0, 1), 1e7) == 1.5e7


def test_a_stage_behind_a_check_obeys_the_laws_of_hose_and_port():
    for port, (pressure, flow, drawn), supply, end in solutions(check=1):
        outflow = drawn + 1e-12 * end.pressure
        assert end.pressure == pytest.approx(
            pressure + STEP * pressure_rate(end.pressure, end.flow, outflow, LINE, NO_GUARD),
            rel=1e-9,
            abs=1.0,
        )
        if end.flow != 0.0:
            rate = flow_rate(end.pressure, end.flow, port, supply, LINE)
            assert end.flow == pytest.approx(flow + STEP * rate, rel=1e-6, abs=1e-9)
        elif port.to_tank == math.inf and port.leakage == 0.0:
            assert flow_rate(end.pressure, 0.0, port, supply, LINE) <= 0.0 or end.pressure < supply


def test_behind_a_shut_check_the_port_shows_the_load_and_takes_nothing():
    port = Port(1e12, math.inf, 0.0, 1)
    end = solve_line(1.5e7, 0.0, 0.0, 0.0, port, 1e7, LINE, NO_GUARD, STEP)
    assert (end.pressure, end.flow, end.port_pressure) == (1.5e7, 0.0, 1.5e7)
    assert supply_coupling(end, port, 1e7, LINE, STEP) == (0.0, 0.0, 0.0, 0.0, 0.0)
    assert port_pressure(1.5e7, 0.0, port, 1e7) == 1.5e7
    assert flow_rate(1.5e7, 0.0, port, 1e7, LINE) == 0.0
    assert flow_rate(0.9e7, 0.0, port, 1e7, LINE) > 0.0


def session(machine, step=1e-3):
    """Lift the outstretched boom while the swing takes all that a weak pump gives.

    Returns the boom's angles [rad] every 20 ms, and the least that it drew from the supply [m^3/s].
    """
    p, advance = plant_parameters(machine), compiled_advance()
    simulation = equilibrium(OUTSTRETCHED, p)
    angles, least = [], math.inf
    for _ in range(150):
        simulation = advance(simulation, (9.0, 4.0, 0.0), step, round(0.02 / step), p)
        ports, plant = ports_at(simulation.spools, p), simulation.plant
        angles.append(plant.boom.angle)
        least = min(least, axis_draw(plant.boom, ports[1], plant.supply.pressure).flow)
    return np.array(angles), least


def sunk(angles):
    """How far the boom came down from where it had been [deg]."""
    return math.degrees((np.maximum.accumulate(angles) - angles).max())


def test_a_heavy_boom_does_not_sink_while_the_swing_takes_the_pump():
    (free, back), (held, least) = session(WEAK), session(with_checks(WEAK))
    assert sunk(free) > 0.5
    assert back < -1e-5
    assert sunk(held) < 0.01
    assert least >= 0.0


def test_the_step_does_not_matter():
    coarse, fine = session(with_checks(WEAK))[0], session(with_checks(WEAK), 2.5e-4)[0]
    assert np.abs(coarse - fine).max() < 1e-5
