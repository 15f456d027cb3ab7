"""The simulator's laws are the textbooks', within 2 %, at random states and constants."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from textbook_laws import (
    Spring,
    counterbalance_flow,
    effective_modulus,
    lugre,
    metered_flow,
    oil_spring,
    shared_flows,
)

from forest_description.hydraulics.load_holding_parameters import CounterbalanceValve
from forest_description.hydraulics.oil import EntrainedAir
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.compensator import AFTER, BEFORE, Compensator, balance, in_series
from forest_sim.hydraulics.load_holding import holding_drop, holding_valve, lift_after, restriction
from forest_sim.hydraulics.oil_law import OilLaw, density
from forest_sim.hydraulics.oil_volume import content
from forest_sim.mechanics.bristles import Bristles, rubbing

WITHIN = 0.02
C180 = load_machine("c180")
OIL = C180.oil
assert OIL is not None
assert OIL.air == EntrainedAir(0.005, 3e6, 101325.0, 100.0)


def test_the_bulk_modulus_of_oil_with_air_is_merritts():
    rng = np.random.default_rng(1)
    for _ in range(400):
        liquid, air = rng.uniform(1.2e9, 1.8e9), rng.uniform(0.0, 0.03)
        tank, dissolved = rng.uniform(0.8e5, 1.2e5), rng.uniform(1e6, 6e6)
        pressure = rng.choice([rng.uniform(-0.5 * tank, 0.0), rng.uniform(0.0, 6e6), rng.uniform(0.0, 2.4e7)])
        found = density(pressure, OilLaw(1.0 / liquid, air, tank, dissolved))
        wanted = effective_modulus(pressure, liquid, air, dissolved, tank)
        assert found.ratio / found.slope == pytest.approx(wanted, rel=WITHIN)


@pytest.mark.parametrize(("axis", "index"), [("boom", 1), ("stick", 2)])
def test_a_shut_cylinder_stands_on_the_springs_of_its_oil(axis, index):
    """Each chamber with its dead volume and its hose, whose wall yields by what is not its oil's."""
    drive, laws = getattr(C180, axis), getattr(plant_parameters(C180), axis)
    bore = 0.25 * math.pi * C180.hose_of(index).bore ** 2
    rng = np.random.default_rng(2)
    for _ in range(200):
        stroke, pressure = rng.uniform(0.0, drive.stroke), rng.uniform(0.0, 2.4e7)
        modulus = effective_modulus(pressure, OIL.bulk_modulus, 0.005, 3e6, 101325.0)
        chambers = (
            (1, laws.oil_1, drive.head_area, drive.chambers.head_dead_volume, stroke),
            (2, laws.oil_2, drive.rod_area, drive.chambers.rod_dead_volume, drive.stroke - stroke),
        )
        for port, oil, area, dead, filled in chambers:
            hose = bore * (drive.line_1_length, drive.line_2_length)[port - 1]
            wall = C180.line(index, port).capacitance - hose / OIL.bulk_modulus
            held = content(pressure, drive.retracted_length + stroke, oil)
            found = oil.area**2 * held.density / held.capacitance
            assert found == pytest.approx(
                oil_spring(area, dead + area * filled + hose, modulus, wall), rel=WITHIN
            )


def test_what_a_counterbalance_valve_lets_down_follows_load_and_pilot_by_its_ratio():
    rng, partly = np.random.default_rng(3), 0
    for _ in range(400):
        ratio, setting, opening_range = rng.uniform(0.5, 8.0), rng.uniform(1e7, 3e7), rng.uniform(1e6, 1e7)
        resistance, load = 10.0 ** rng.uniform(10.0, 12.0), rng.uniform(1e6, 1e7)
        pilot = (setting + rng.uniform(-0.5, 1.5) * opening_range - load) / ratio
        v = holding_valve(CounterbalanceValve(setting, ratio, 1e6, opening_range, resistance, 5e10, 0.01))
        wanted = counterbalance_flow(load, pilot, setting, ratio, opening_range, resistance)
        outward = restriction(lift_after(0.0, load, pilot, 0.0, 1.0, v), v)
        if wanted == 0.0:
            assert outward.outward == math.inf
        else:
            partly += wanted < math.sqrt(load / resistance)
            assert -holding_drop(-wanted, outward) == pytest.approx(load, rel=2.0 * WITHIN)  # as Q^2
    assert partly > 100


def test_bristles_that_only_slide_are_lugres():
    """Without an elastic share both laws are one; here the damping does not fall with the speed, either."""
    rng = np.random.default_rng(4)
    for _ in range(400):
        coulomb, stiffness = rng.uniform(200.0, 2000.0), 10.0 ** rng.uniform(6.0, 8.0)
        breakaway, stribeck = coulomb * rng.uniform(1.0, 2.0), 10.0 ** rng.uniform(-3.0, -1.0)
        v = rng.choice([-1.0, 1.0]) * stribeck * 10.0 ** rng.uniform(-2.0, 1.0)
        damping = rng.uniform(0.0, 0.1) * coulomb / abs(v)
        sliding = coulomb + (breakaway - coulomb) / (1.0 + (v / stribeck) ** 2)
        z = math.copysign(rng.uniform(0.0, 1.2), v) * sliding / stiffness
        found = rubbing(z, v, Bristles(coulomb, breakaway, stribeck, stiffness, damping, 0.0))
        rate, force = lugre(z, v, sliding, stiffness, damping)
        assert found.rate == pytest.approx(rate, rel=WITHIN, abs=1e-9 * abs(v))
        assert found.force == pytest.approx(force, rel=WITHIN)


def flow_through(drop, edge, supply, greatest, c):
    if drop <= 0.0:
        return 0.0
    return math.sqrt(drop / (edge + in_series(balance(drop, edge, supply, greatest, c), c)))


def test_before_the_spool_an_edge_passes_what_its_spring_leaves_it():
    rng, throttling = np.random.default_rng(5), 0
    for _ in range(400):
        spring = Spring(rng.uniform(4e5, 2e6), rng.uniform(5e4, 8e5), 10.0 ** rng.uniform(9.5, 11.0))
        edge, drop = 10.0 ** rng.uniform(10.5, 14.0), 10.0 ** rng.uniform(4.5, 7.4)
        found = flow_through(drop, edge, 0.0, 0.0, Compensator(BEFORE, *spring, 0.01))
        wanted = metered_flow(drop, edge, spring.setting, spring)
        throttling += edge * wanted**2 > spring.setting - spring.control_range
        assert found == pytest.approx(wanted, rel=WITHIN)
    assert throttling > 100


def shared_through(pump, loads, edges, c):
    """Flows at the supply's pressure that leaves the pump nothing to give."""

    def taken(supply):
        pairs = zip(loads, edges, strict=True)
        return [flow_through(supply - p, edge, supply, max(loads), c) for p, edge in pairs]

    return taken(brentq(lambda p: sum(taken(p)) - pump, max(loads), max(loads) + 1e8))


def test_behind_the_spools_a_pump_too_small_is_shared_by_the_openings():
    """Beside the balance of all three; with a narrow control range, exactly as the openings are."""
    rng = np.random.default_rng(6)
    for _ in range(40):
        loads, edges = rng.uniform(5e5, 2e7, 3).tolist(), (10.0 ** rng.uniform(11.0, 13.0, 3)).tolist()
        setting, openings = rng.uniform(3e5, 1e6), [1.0 / math.sqrt(edge) for edge in edges]
        pump = rng.uniform(0.2, 0.8) * math.sqrt(1e6) * sum(openings)
        for control_range in (6e5, 1e3):
            spring = Spring(setting, control_range, 1e9)
            found = shared_through(pump, loads, edges, Compensator(AFTER, *spring, 0.01))
            assert found == pytest.approx(shared_flows(pump, loads, edges, spring), rel=WITHIN)
        assert found == pytest.approx([pump * a / sum(openings) for a in openings], rel=WITHIN)
