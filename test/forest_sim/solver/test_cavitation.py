"""Claims about a crane whose oil holds air: nothing goes below its vapour, and no oil is lost over it."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.hydraulics.hose import Line
from forest_description.machine import load_machine
from forest_sim.equations.plant import at_joints, transmissions
from forest_sim.equations.plant_parameters import NO_GUARD, plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.hydraulics.hydraulic_line import solve_line
from forest_sim.hydraulics.oil_volume import content
from forest_sim.hydraulics.port import Port
from forest_sim.sensors.sensor_readings import axis_pressures
from forest_sim.simulation.energy_account import account, unaccounted, with_stored_energy
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver.compiled_plant import compiled_advance, compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.power_flows import power_flows
from forest_sim.solver.state_recording import ENERGY, STATE, restore

REAL, LOADER = load_machine("c180"), load_machine("loader")
BARE = dataclasses.replace(REAL, port_valves=None)  # nothing feeds a port but its own hose
AIRY = dataclasses.replace(LOADER, oil=dataclasses.replace(LOADER.oil, air=REAL.oil.air))
AIRLESS = dataclasses.replace(BARE, oil=dataclasses.replace(REAL.oil, air=None))
VAPOUR = REAL.oil.air.vapour_pressure - REAL.oil.air.tank_pressure
PRESSURES = [STATE.index(f"{axis}_pressure_{n}") for axis in ("swing", "boom", "stick") for n in (1, 2)]
MANIFOLD = STATE.index("supply_pressure")


def slammed(machine, seconds=15, counted=False):
    """States, and energies if counted, of a run whose valves go from end to end at random, and both ends."""
    p, rng = plant_parameters(machine), np.random.default_rng(1)
    table = np.repeat(rng.choice([-10.0, 0.0, 10.0], (5 * seconds, 3)), 200, axis=0)
    states = np.zeros((1000 * seconds, len(STATE)))
    energies = np.zeros((1000 * seconds, len(ENERGY))) if counted else None
    first = equilibrium(start_angles(machine), p)
    last = compiled_record()(first, table, 1e-3, p, states, energies)
    return states, energies, first, last


def test_no_port_comes_below_the_oils_vapour():
    states, energies, first, last = slammed(BARE, counted=True)
    lowest = states[:, PRESSURES].min()
    assert VAPOUR < lowest < -0.09e6
    assert slammed(AIRLESS)[0][:, PRESSURES].min() < -1e7  # the same slams pull oil without air without end
    assert last.events.unconverged_stages == 0
    total = with_stored_energy(account(energies.sum(axis=0)), first, last, plant_parameters(BARE))
    assert abs(unaccounted(total)) < 1e-3 * float(total.engine)


def test_no_reading_at_a_valve_is_below_the_oils_vapour():
    """Behind a closing edge the column of oil tears: the hose takes what the edge passes into a vacuum."""
    lowest = {}
    for machine in (BARE, AIRLESS):
        p, states = plant_parameters(machine), slammed(machine, 6)[0]
        seen = []
        for row in states[::3]:
            now = restore(row)
            plant, ports = now.plant, ports_at(now.spools, p)
            at = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
            for state, axis, t, port in zip(plant.axes, p.axes, at, ports, strict=True):
                seen += axis_pressures(state, axis, t, port, plant.supply.pressure)
        lowest[machine] = min(seen)
    assert VAPOUR <= lowest[BARE] < -0.09e6
    assert lowest[AIRLESS] < -1e7


def test_a_torn_column_takes_what_its_edge_passes_into_a_vacuum():
    """Q = sqrt((p_s - p_v)/C_R) through the edge to the supply, whatever the column's momentum."""
    h, line, edge = 3e-4, Line(0.0, 1.2e7, 1e-11), 1e14
    open_ = Port(edge, math.inf, 0.0, 0, VAPOUR)
    torn = solve_line(2e5, 2e-3, 0.0, 0.0, open_, 1e6, line, NO_GUARD, h)
    assert torn.flow == pytest.approx(math.sqrt((1e6 - VAPOUR) / edge), rel=1e-12)
    assert torn.port_pressure == VAPOUR
    assert torn.pressure - 2e5 == pytest.approx(h * torn.flow / line.capacitance, rel=1e-9)
    whole = solve_line(2e5, 1e-4, 0.0, 0.0, open_, 1e6, line, NO_GUARD, h)
    assert whole == solve_line(2e5, 1e-4, 0.0, 0.0, open_._replace(vapour=-math.inf), 1e6, line, NO_GUARD, h)


def test_a_manifold_that_its_pump_cannot_feed_stays_above_vacuum():
    assert slammed(LOADER, 60)[0][:, MANIFOLD].min() < -0.15e6
    states = slammed(AIRY, 60)[0]
    assert states[:, MANIFOLD].min() > VAPOUR


@pytest.mark.parametrize("pressure", [-0.09e6, 0.0, 1e6])
def test_a_pump_on_an_emptied_manifold_loses_power_to_friction_and_gains_none(pressure):
    p = plant_parameters(AIRY)
    rest = equilibrium(start_angles(AIRY), p)
    supply = rest.plant.supply._replace(pressure=pressure)
    pump = power_flows(rest._replace(plant=rest.plant._replace(supply=supply)), p).pump
    assert pump.pump_friction >= 0.0
    lost = pump.pump_friction + pump.pump_leakage + pump.main_relief
    assert pump.engine == pytest.approx(lost + pump.manifold + pump.supply, abs=1e-9)


def downhill(step, seconds):
    """A crane on a slope of 24 degrees turned out of the fall line, left behind shut valves; per 20 ms."""
    tilted = dataclasses.replace(REAL.manipulator, platform_tilt=math.radians(-24.0))
    p = plant_parameters(dataclasses.replace(BARE, manipulator=tilted))
    per, rows = round(0.02 / step), round(seconds / 0.02)
    table = np.zeros((rows * per, 3))
    table[: 250 * per] = -10.0, 10.0, 10.0
    states, energies = np.zeros((rows, len(STATE))), np.zeros((rows, len(ENERGY)))
    first = equilibrium(start_angles(REAL), p)
    last = compiled_record()(first, table, step, p, states, energies)
    total = with_stored_energy(account(energies.sum(axis=0)), first, last, p)
    return states, last, abs(unaccounted(total)) / float(total.engine)


def test_a_motor_on_an_emptied_port_runs_on_and_no_energy_is_lost_or_made():
    """Vapour collapses in the motor: that is its leakage. A volume that a motor drew on was a nan once."""
    states, last, open_share = downhill(1e-3, 60)
    inlet = states[:, STATE.index("swing_pressure_1")] - VAPOUR
    assert 0.0 < inlet.min() < 10.0 * REAL.oil.air.vapour_pressure
    assert last.events.unconverged_stages == 0
    assert open_share < 1e-4
    finer = downhill(5e-4, 60)[0]
    swing = STATE.index("swing_angle")
    assert np.abs(states[:, swing] - finer[:, swing]).max() < 1e-3


def test_oil_that_cavitates_behind_shut_valves_is_all_there_when_it_is_pressed_again():
    """A boom thrown up pulls its head side empty, falls back and closes the cavity, again and again."""
    p = plant_parameters(BARE)
    rest = equilibrium((0.0, 0.4, -1.4), p)
    boom = rest.plant.boom._replace(rate=0.8)
    now = rest._replace(plant=rest.plant._replace(boom=boom))

    def held(simulation):
        plant = at_joints(simulation.plant, p)
        t = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)[1]
        return [
            content(plant.boom.pressure_1, t.position, p.boom.oil_1).oil,
            content(plant.boom.pressure_2, t.position, p.boom.oil_2).oil,
        ]

    before, lowest = held(now), 0.0
    for _ in range(3000):
        now = compiled_advance()(now, (0.0, 0.0, 0.0), 1e-3, 1, p)
        lowest = min(lowest, now.plant.boom.pressure_1, now.plant.boom.pressure_2)
    assert lowest < -0.05e6
    assert held(now) == pytest.approx(before, rel=1e-9)
    assert now.events.unconverged_stages == 0
