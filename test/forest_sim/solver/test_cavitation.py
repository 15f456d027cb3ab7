"""Claims about a crane whose oil holds air: nothing goes below its vapour, and no oil is lost over it."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from forest_description.config.source_tree import shipped_machines
from forest_description.hydraulics.hose import Line
from forest_description.machine import load_machine
from forest_sim.equations.plant import at_joints, transmissions
from forest_sim.equations.plant_parameters import NO_GUARD, plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.hydraulics.hydraulic_line import solve_line
from forest_sim.hydraulics.oil_volume import content
from forest_sim.hydraulics.port import Port
from forest_sim.sensors.sensor_readings import axis_pressures
from forest_sim.simulation.changing_plant import ChangingPlant
from forest_sim.simulation.energy_account import account, unaccounted, with_stored_energy
from forest_sim.simulation.load_schedule import Load
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver import state_recording
from forest_sim.solver.compiled_plant import compiled_advance, compiled_record, fastest_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.power_flows import power_flows
from forest_sim.solver.state_recording import ENERGY, STATE, restore

REAL, LOADER = load_machine("c180"), load_machine("loader")
BARE = dataclasses.replace(REAL, port_valves=None)  # nothing feeds a port but its own hose
AIRLESS = dataclasses.replace(BARE, oil=dataclasses.replace(REAL.oil, air=None))
AIRLESS_LOADER = dataclasses.replace(LOADER, oil=dataclasses.replace(LOADER.oil, air=None))
VAPOUR = REAL.oil.air.vapour_pressure - REAL.oil.air.tank_pressure
VACUUM = -101325.0  # [Pa] above the tank's
PRESSURES = [STATE.index(f"{axis}_pressure_{n}") for axis in ("swing", "boom", "stick") for n in (1, 2)]
MANIFOLD, INLET = STATE.index("supply_pressure"), STATE.index("tank_pressure")
WITH_AIR = [n for n in shipped_machines() if (oil := load_machine(n).oil) and oil.air]


def slams(time, draw):
    """Directions of full voltages: for 0.2 s each, then shut for 0.2 s."""
    held = np.floor(time / 0.4).astype(int)
    return draw.choice([-1.0, 1.0], (held[-1] + 1, 3))[held] * (np.mod(time, 0.4) < 0.2)[:, None]


def squares(time, draw):
    """Full to and fro, every valve at a frequency of its own from 1 to 10 Hz."""
    return np.sign(np.sin(2.0 * np.pi * (draw.uniform(1.0, 10.0, 3) * time[:, None] + draw.uniform(0, 1, 3))))


def random(time, draw):
    """Anywhere within the rated voltage, every 0.2 s."""
    held = np.floor(time / 0.2).astype(int)
    return draw.uniform(-1.0, 1.0, (held[-1] + 1, 3))[held]


def valve_pressures(row, p):
    """Pressures of the valves' ports and at the actuators' [Pa]."""
    now = restore(row)
    plant, ports = now.plant, ports_at(now.spools, p)
    at = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
    return [
        pressure
        for state, axis, t, port in zip(plant.axes, p.axes, at, ports, strict=True)
        for pressure in axis_pressures(state, axis, t, port, plant.supply.pressure)
    ]


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
        lowest[machine] = min(min(valve_pressures(row, p)) for row in states[::3])
    assert VAPOUR <= lowest[BARE] < -0.09e6
    assert lowest[AIRLESS] < -1e7


@settings(max_examples=40)
@given(
    st.sampled_from(WITH_AIR),
    st.sampled_from((None, 3, 11)),
    st.sampled_from((slams, squares, random)),
    st.booleans(),
    st.integers(0, 2**16),
)
def test_no_port_manifold_or_pump_inlet_is_under_absolute_vacuum(name, drawn, shape, logs, seed):
    """Shipped machines whose oil has air, and some drawn from them; logs of up to 0.8 t are dropped."""
    assert {"c180", "forwarder", "loader"} <= set(WITH_AIR)
    machine = load_machine(name if drawn is None else f"unknown:{drawn}:{name}")
    plant, draw = ChangingPlant(machine), np.random.default_rng(seed)
    volts = shape(1e-3 * np.arange(6000), draw) * [machine.valve_of(axis).rated_voltage for axis in range(3)]
    end = equilibrium(start_angles(machine), plant.p)
    for turn, table in enumerate(np.split(volts, 6)):
        end = plant.hold(Load(logs * draw.uniform(0.0, 800.0) * (turn % 2)), end).simulation
        states = np.zeros((len(table), len(STATE)))
        end = compiled_record()(end, table, 1e-3, plant.p, states, None)
        assert states[:, [*PRESSURES, MANIFOLD, INLET]].min() > VACUUM
        assert min(min(valve_pressures(row, plant.p)) for row in states[::10]) > VACUUM
    assert end.events.unconverged_stages == 0


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


@pytest.mark.parametrize("record", [state_recording.record, fastest_record()], ids=["interpreted", "fastest"])
def test_what_a_torn_column_loses_is_in_the_account(record):
    """The stick's hoses are long: to and fro at 10 Hz tears their oil behind each edge that closes."""
    seconds, p = (0.6, 10.0)[record is not state_recording.record], plant_parameters(LOADER)
    time = 1e-3 * np.arange(round(1e3 * seconds))
    volts = np.outer(np.sign(np.sin(2.0 * np.pi * 10.0 * time)), [0.0, 0.0, 8.0])
    states, energies = np.zeros((len(volts), len(STATE))), np.zeros((len(volts), len(ENERGY)))
    first = equilibrium(start_angles(LOADER), p)
    last = record(first, volts, 1e-3, p, states, energies)
    total = with_stored_energy(account(energies.sum(axis=0)), first, last, p)
    assert total.stopped > 0.005 * total.engine
    assert abs(unaccounted(total)) < 0.05 * total.stopped


def test_a_manifold_that_its_pump_cannot_feed_stays_above_vacuum():
    assert slammed(AIRLESS_LOADER, 60)[0][:, MANIFOLD].min() < -0.15e6
    assert slammed(LOADER, 60)[0][:, MANIFOLD].min() > VAPOUR


@pytest.mark.parametrize("pressure", [-0.09e6, 0.0, 1e6])
def test_a_pump_on_an_emptied_manifold_loses_power_to_friction_and_gains_none(pressure):
    p = plant_parameters(LOADER)
    rest = equilibrium(start_angles(LOADER), p)
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
