"""Claims about leakage that follows the overlap: laminar through the clearance that the overlap leaves."""

import dataclasses
import math

import numpy as np
import pytest
from full_machine import START, advance

from forest_description.geometry.linkage import cylinder_length
from forest_description.hydraulics.pump import IdealPump
from forest_description.hydraulics.valve_characteristic import edges
from forest_description.machine import load_machine
from forest_ident.measurements.readings import valve_pressures
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import valve_ports
from forest_sim.hydraulics.command_history import held
from forest_sim.hydraulics.port import port_flow, port_pressure
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import spools_after

C180 = load_machine("c180_hoses")
SUPPLY = 2e7
# A spool of 16 mm with a clearance of 6 um; 0.5 mm of overlap are 1 V. Edges rounded by 20 um.
DIAMETER, CLEARANCE, VISCOSITY, OVERLAP, ROUNDING = 0.016, 6e-6, 0.03, 0.5e-3, 2e-5


def clearance_flow(drop, volts):
    """Flow [m^3/s] past an edge so far from the centre, towards its opening [V]. Merritt 1967, 3.2."""
    length = OVERLAP * (1.0 - volts) + ROUNDING
    return math.pi * DIAMETER * CLEARANCE**3 / (12.0 * VISCOSITY * length) * drop


VALVE = dataclasses.replace(
    C180.valve,
    deadband_voltage=1.0,
    leakage_conductance=clearance_flow(1.0, 0.0),
    leakage_edge_ratio=(OVERLAP + ROUNDING) / ROUNDING,
)


@pytest.mark.parametrize("volts", [-0.95, -0.5, 0.0, 0.3, 0.9, 0.999])
def test_each_edge_leaks_through_what_is_left_of_its_overlap(volts):
    ports = valve_ports(volts, VALVE.law)
    for port, sign in ((ports.port_1, 1.0), (ports.port_2, -1.0)):
        for p in (0.0, 4e6, 17e6):
            expected = clearance_flow(SUPPLY - p, sign * volts) - clearance_flow(p, -sign * volts)
            assert port_flow(p, port, SUPPLY) == pytest.approx(expected, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("volts", [-0.9, -0.2, 0.0, 0.6])
def test_a_blocked_port_shows_the_pressure_between_both_clearances(volts):
    to_supply, to_tank = OVERLAP * (1.0 - volts) + ROUNDING, OVERLAP * (1.0 + volts) + ROUNDING
    expected = SUPPLY * to_tank / (to_supply + to_tank)
    assert port_pressure(0.0, 0.0, valve_ports(volts, VALVE.law).port_1, SUPPLY) == pytest.approx(expected)


def test_the_flow_has_no_step_where_the_overlap_ends_and_an_open_edge_keeps_what_leaks():
    inside, outside = (valve_ports(1.0 + d, VALVE.law).port_1 for d in (-1e-9, 1e-9))
    assert outside.to_supply == math.inf  # the orifice opens from nothing
    assert port_flow(1e7, inside, SUPPLY) == pytest.approx(port_flow(1e7, outside, SUPPLY), rel=1e-6)
    wide = valve_ports(9.0, VALVE.law).port_1
    orifice = math.sqrt(1e7 / edges(9.0, VALVE.law).supply_1)
    leaked = clearance_flow(1e7, 1.0) - clearance_flow(1e7, -9.0)
    assert port_flow(1e7, wide, SUPPLY) == pytest.approx(orifice + leaked, rel=1e-9)


def test_both_directions_have_overlaps_of_their_own():
    law = VALVE.law
    law = law._replace(backward=law.backward._replace(deadband_voltage=2.0))
    port = valve_ports(-1.0, law).port_2
    half = VALVE.leakage_edge_ratio / (1.0 + 0.5 * (VALVE.leakage_edge_ratio - 1.0))
    assert port.leakage + port.skew == pytest.approx(half * VALVE.leakage_conductance)


def test_a_boom_creeps_up_on_what_leaks_into_its_head_side_while_its_spool_is_inside_the_overlap():
    machine = dataclasses.replace(C180, pump=IdealPump(SUPPLY), valve=VALVE, port_valves=None)
    p, volts = plant_parameters(machine), (0.0, 0.9, 0.0)
    now = equilibrium(START, p)
    now = now._replace(spools=spools_after(now.spools, held(volts), 10.0, p))
    now = advance(now, volts, 1e-3, 20_000, p)
    later = advance(now, volts, 1e-3, 5000, p)
    begin, end = now.plant.boom, later.plant.boom
    way = cylinder_length(end.angle, p.boom_linkage) - cylinder_length(begin.angle, p.boom_linkage)
    head = 0.5 * (begin.pressure_1 + end.pressure_1)
    rod = 0.5 * (begin.pressure_2 + end.pressure_2)
    filled = clearance_flow(SUPPLY - head, 0.9) - clearance_flow(head, -0.9)
    left = clearance_flow(rod, 0.9) - clearance_flow(SUPPLY - rod, -0.9)
    assert way == pytest.approx(5.0 * filled / C180.boom.head_area, rel=0.02)
    assert way == pytest.approx(5.0 * left / C180.boom.rod_area, rel=0.02)
    assert way > 1e-4


def test_what_an_experiment_reads_in_a_port_is_what_the_simulator_has_there():
    rng = np.random.default_rng(5)
    spool, flow = rng.uniform(-3.0, 3.0, 300), rng.normal(0.0, 1e-5, 300)
    hose, supply = rng.uniform(1e6, 1.9e7, 300), np.full(300, SUPPLY)
    for number in (1, 2):
        read = valve_pressures(hose, flow, spool, supply, VALVE.law, number)
        for k in range(300):
            port = valve_ports(spool[k], VALVE.law)[number - 1]
            expected = port_pressure(hose[k], flow[k], port, SUPPLY)
            assert read[k] == pytest.approx(expected, rel=1e-9, abs=1.0)
