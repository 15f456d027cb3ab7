"""Claims about flow forces: a spool's balance against its jets, at rest and under way."""

import dataclasses
import math

import numpy as np
import pytest
from full_machine import C180, advance, pack, unpack
from scipy.integrate import solve_ivp

from forest_description.hydraulics.pump import IdealPump
from forest_description.hydraulics.valve_characteristic import edges
from forest_sim.equations.plant import state_derivative
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.hydraulics.spool_dynamics import CENTRED, Spool
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import step

SPRING, BANDWIDTH, DAMPING = 90.0, 12.0, 0.6  # N/V, Hz, 1
DENSITY, SUPPLY = C180.oil.density, 2e7
POSE = (0.0, 0.3, -1.4)


def crane(**changes):
    """c180_hoses on a supply that stands still, with springs that jets push against."""
    valve = {"spool_bandwidth": BANDWIDTH, "spool_damping": DAMPING, "centring_force": SPRING} | changes
    return dataclasses.replace(
        C180, pump=IdealPump(SUPPLY), port_valves=None, valve=dataclasses.replace(C180.valve, **valve)
    )


def jet(flow, drop):
    """Momentum that a jet carries along the spool's axis [N]."""
    return DENSITY * abs(flow) * math.sqrt(2.0 * abs(drop) / DENSITY) * math.cos(math.radians(69.0))


@pytest.mark.parametrize("damping", [None, DAMPING], ids=["first order", "second order"])
@pytest.mark.parametrize("volts", [6.0, -6.0, 9.5])
def test_in_steady_motion_spring_and_jets_hold_the_spool_back_together(volts, damping):
    p = plant_parameters(crane(spool_damping=damping))
    now = advance(equilibrium(POSE, p), (0.0, volts, 0.0), 1e-3, 700, p)
    boom = now.plant.boom
    one, two = boom.pressure_1, boom.pressure_2
    drops = (SUPPLY - one, two) if volts > 0.0 else (one, SUPPLY - two)
    force = jet(boom.flow_1, drops[0]) + jet(boom.flow_2, drops[1])
    held_back = (abs(volts) - abs(now.spools[1].position)) * SPRING
    assert held_back == pytest.approx(force, rel=0.02)
    assert held_back > 0.1 * abs(volts) * SPRING
    assert now.spools[0].position == now.spools[2].position == 0.0


def under_way():
    """The boom going up at 4 V, and the machine without jets whose plant and spool a test integrates."""
    p = plant_parameters(crane())
    return p, advance(equilibrium(POSE, p), (0.0, 4.0, 0.0), 1e-3, 500, p)


def integrated(begin, volts, seconds, p):
    """Plant and spool [N, 29] every 5 ms as scipy has them, the spool's law written here."""
    law, w = p.valves[1].law, 2.0 * math.pi * BANDWIDTH

    def rates(_, y):
        plant, x, v = unpack(y[:-2]), y[-2], y[-1]
        still = {"flow_1": 0.0, "flow_2": 0.0}  # through the shut valves
        plant = plant._replace(swing=plant.swing._replace(**still), stick=plant.stick._replace(**still))
        ports = ports_at((CENTRED, Spool(x, v), CENTRED), p)
        opened = edges(x, law)
        q_1, q_2 = plant.boom.flow_1, plant.boom.flow_2
        force = jet(q_1, opened.supply_1 * q_1 * q_1) + jet(q_2, opened.tank_2 * q_2 * q_2)
        pushed = w * w * (x - volts + force / SPRING)
        return np.array([*pack(state_derivative(plant, ports, p)), v, -2.0 * DAMPING * w * v - pushed])

    spool = begin.spools[1]
    y = np.array([*pack(begin.plant), spool.position, spool.rate])
    times = np.arange(1, round(seconds / 5e-3) + 1) * 5e-3
    found = solve_ivp(rates, (0.0, seconds), y, method="Radau", t_eval=times, rtol=1e-8, atol=1e-10)
    assert found.success, found.message
    return found.y.T


def test_spool_and_crane_move_as_one_system_written_apart_and_the_error_falls_with_the_square():
    p, begin = under_way()
    volts, seconds = 7.0, 0.2
    expected = integrated(begin, volts, seconds, p)
    errors = []
    for n in (5, 10, 20):
        now, rows = begin, []
        for _ in range(round(seconds / 5e-3)):
            now = advance(now, (0.0, volts, 0.0), 5e-3 / n, n, p)
            rows.append([now.spools[1].position, *pack(now.plant)[6:10]])
        errors.append(np.abs(np.array(rows) - expected[:, [-2, 6, 7, 8, 9]]).max(axis=0))
    held_back = volts - expected[-1, -2]
    assert held_back > 1.0
    assert errors[0][0] < 0.02 * held_back
    assert errors[0][1] < 1e-5  # rad
    for coarse, fine in ((0, 1), (1, 2)):
        assert np.log2(errors[coarse][0] / errors[fine][0]) == pytest.approx(2.0, abs=0.5)


def test_a_shut_valve_has_no_jets_and_a_spool_without_flow_goes_all_the_way():
    p = plant_parameters(crane())
    rest = advance(equilibrium(POSE, p), (0.0, 0.0, 0.0), 1e-3, 50, p)
    assert rest.spools == (CENTRED, CENTRED, CENTRED)
    inside = advance(equilibrium(POSE, p), (0.0, 0.5, 0.0), 1e-3, 500, p)
    assert inside.spools[1].position == pytest.approx(0.5, abs=1e-9)


def test_play_and_slew_limit_act_on_a_pushed_spool_as_on_any():
    p = plant_parameters(crane(hysteresis=0.4, spool_slew_limit=100.0))
    now = advance(equilibrium(POSE, p), (0.0, 6.0, 0.0), 1e-3, 30, p)
    assert now.spools[1].position <= 3.0 + 1e-9
    now = advance(now, (0.0, 6.0, 0.0), 1e-3, 700, p)
    assert now.spools[1].target == pytest.approx(5.8)
    assert now.spools[1].position == pytest.approx(5.8 - now.midpoint.jets[1].force, abs=2e-3)


def test_a_fast_spool_on_the_softest_spring_allowed_comes_to_rest():
    valve = C180.valve
    softest = 2.001 * valve.jet_stiffness(SUPPLY, DENSITY)
    p = plant_parameters(crane(spool_bandwidth=500.0, spool_damping=None, centring_force=softest))
    now, positions = advance(equilibrium(POSE, p), (0.0, 8.0, 0.0), 1e-3, 700, p), []
    for _ in range(50):
        now = advance(now, (0.0, 8.0, 0.0), 1e-3, 1, p)
        positions.append(now.spools[1].position)
    assert np.ptp(positions) < 0.02
    assert 3.0 < positions[-1] < 7.0


def test_compiled_and_interpreted_steps_agree_to_the_last_bit():
    p = plant_parameters(crane(hysteresis=0.3))
    now = equilibrium(POSE, p)
    interpreted = now
    for volts in ((0.0, 5.0, -4.0), (3.0, -5.0, 2.0)):
        now = advance(now, volts, 1e-3, 20, p)
        for _ in range(20):
            interpreted = step(interpreted, volts, 1e-3, p)
    assert now == interpreted
