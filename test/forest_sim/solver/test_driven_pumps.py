"""Claims about pumps on a droopy engine, with plates that take time, and about the tank line of a crane."""

import dataclasses

import numpy as np
import pytest
from driven_pump import DOWN, ENGINE, SWASHED, TANK_LINE, UP, driven, everything
from full_machine import BAND, PRESSURE, SHARED, START, advance, pack, unpack
from scipy.integrate import solve_ivp

from forest_description.machine import load_machine
from forest_sim.equations.plant import state_derivative
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.hydraulics.pump_drive import PumpState
from forest_sim.hydraulics.supply import SupplyState, flow_at
from forest_sim.hydraulics.tank_line import TankState
from forest_sim.sensors.sensor_readings import at_rest, measure
from forest_sim.simulation.energy_account import account, unaccounted, with_stored_energy
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver.compiled_plant import compiled_advance, compiled_record
from forest_sim.solver.equilibrium import equilibrium, idle_pump
from forest_sim.solver.integrator import step
from forest_sim.solver.power_flows import power_flows
from forest_sim.solver.state_recording import ENERGY, STATE

SHUT, FULL = (0.0, 0.0, 0.0), (10.0, 10.0, 10.0)
D = 2 * 45e-6 / (2.0 * np.pi)  # two pumps, 45 cm3/rev
N_0, EFFICIENCY = 2500.0 * 2.0 * np.pi / 60.0, SHARED["mechanical_efficiency"]
SOFT = 1e-9  # [m^3/Pa] of a manifold whose pressure takes its time


def at(machine, pressure, stroke=None, speed=N_0):
    """A machine at rest, its manifold at a pressure."""
    p = plant_parameters(machine)
    rest = equilibrium(START, p)
    supply = SupplyState(pressure, rest.plant.supply.reference)
    pump = idle_pump(supply, p.supply) if stroke is None else PumpState(stroke, speed)
    return rest._replace(plant=rest.plant._replace(supply=supply, pump=pump)), p


@pytest.mark.parametrize(
    ("pressure", "before", "asked", "time"),
    [(1e6, 0.1, 1.0, UP), (PRESSURE + 1e6, 0.9, 0.0, DOWN)],
    ids=["up", "down"],
)
def test_a_plate_that_is_asked_to_the_end_goes_there_as_a_first_order_lag(pressure, before, asked, time):
    now, p = at(driven("compensated", manifold_capacitance=SOFT, **SWASHED), pressure, before)
    for _ in range(3):
        now = advance(now, SHUT, 1e-3, 20, p)
    expected = asked + (before - asked) * np.exp(-0.06 / time)
    assert now.plant.pump.stroke == pytest.approx(expected, abs=2e-4)
    assert now.plant.pump.speed == N_0


def test_at_rest_nothing_moves():
    machine = everything("load sensing")
    p = plant_parameters(machine)
    rest = equilibrium(START, p)
    later = advance(rest, SHUT, 1e-3, 1000, p).plant
    assert later.supply.pressure == pytest.approx(rest.plant.supply.pressure, rel=1e-9)
    assert later.pump == pytest.approx(rest.plant.pump, rel=1e-9)
    assert 0.0 < rest.plant.pump.stroke < 0.1
    assert 0.95 * N_0 < rest.plant.pump.speed < N_0


@pytest.mark.parametrize("engine", [None, ENGINE], ids=["constant speed", "engine"])
def test_displacement_times_pressure_is_the_torque_limit(engine):
    machine = driven("compensated", **SWASHED, torque_limit=120.0, engine=engine)
    p = plant_parameters(machine)
    now = advance(equilibrium(START, p), FULL, 1e-3, 1000, p).plant
    assert now.supply.pressure < PRESSURE - BAND
    assert now.pump.stroke < 0.95
    assert D * now.pump.stroke * now.supply.pressure == pytest.approx(120.0, rel=5e-3)


def test_a_static_plate_has_the_torque_limit_too():
    p = plant_parameters(driven("compensated", torque_limit=120.0))
    now = advance(equilibrium(START, p), FULL, 1e-3, 1000, p).plant
    flow = flow_at(now.supply, now.pump, p.supply).displaced
    assert flow * now.supply.pressure == pytest.approx(120.0 * N_0, rel=1e-9)


def test_under_a_steady_load_the_speed_droops_by_its_share_of_the_greatest_torque():
    """n = n_0 (1 - droop T/T_max), with T from pressure and flow; the tachometer tells it."""
    machine = everything("compensated")
    p = plant_parameters(machine)
    now = advance(equilibrium(START, p), (8.0, 0.0, 0.0), 1e-3, 2000, p)
    plant = now.plant
    torque = plant.supply.pressure * D * plant.pump.stroke / EFFICIENCY
    assert torque > 60.0
    assert N_0 - plant.pump.speed == pytest.approx(N_0 * ENGINE.droop * torque / ENGINE.torque, rel=0.02)
    told = measure(now, at_rest(now, p), p, 5e-3)[1]
    assert told.of_kind("tachometer")[0] == pytest.approx(plant.pump.speed, rel=2e-3)
    flow = flow_at(plant.supply, plant.pump, p.supply).displaced
    assert flow == pytest.approx(D * plant.pump.stroke * plant.pump.speed, rel=1e-12)


def independent(leak, limit, duration, pressure, stroke, speed):
    """Manifold, plate and engine behind shut valves, all laws written out here."""

    def rates(_, y):
        p, s, n = y
        asked = min(1.0, limit / (D * p), max(0.0, (PRESSURE - p) / BAND))
        torque = max(0.0, min((N_0 - n) * ENGINE.torque / (ENGINE.droop * N_0), ENGINE.torque))
        load = D * s * p / EFFICIENCY
        over = max(0.0, p - 3300 * 6894.7) * SHARED["relief_conductance"]
        flow = D * s * n - p / leak - over
        lag = UP if asked > s else DOWN
        return [flow / SHARED["manifold_capacitance"], (asked - s) / lag, (torque - load) / ENGINE.inertia]

    return solve_ivp(rates, (0.0, duration), [pressure, stroke, speed], "Radau", rtol=1e-8, atol=1e-8).y[
        :, -1
    ]


@pytest.mark.parametrize("duration", [0.05, 0.2, 1.0])
def test_manifold_plate_and_engine_move_as_an_independent_integration(duration):
    """The pump starts against a leak that takes most of its flow: everything moves at once."""
    leak = 6.5e9
    machine = driven("compensated", leakage_resistance=leak, **SWASHED, engine=ENGINE, torque_limit=260.0)
    now, p = at(machine, 1e6, 0.05, 0.99 * N_0)
    now = advance(now, SHUT, 1e-3, round(duration / 1e-3), p).plant
    expected = independent(leak, 260.0, duration, 1e6, 0.05, 0.99 * N_0)
    assert (now.supply.pressure, *now.pump) == pytest.approx(expected, rel=2e-3)


def test_an_engine_whose_load_exceeds_its_torque_stalls_and_delivers_nothing():
    weak = dataclasses.replace(ENGINE, inertia=0.5, torque=80.0)
    machine = driven("compensated", **SWASHED, engine=weak, tank_line=TANK_LINE)
    p = plant_parameters(machine)
    now = advance(equilibrium(START, p), FULL, 1e-3, 6000, p)
    assert now.plant.pump.speed == 0.0
    assert flow_at(now.plant.supply, now.plant.pump, p.supply).displaced == 0.0
    flows = power_flows(now, p).pump
    assert flows.engine == flows.pump_friction == flows.flywheel == 0.0
    later = advance(now, SHUT, 1e-3, 20000, p)
    assert later.plant.supply.pressure == pytest.approx(0.0, abs=0.1 * PRESSURE)
    assert later.plant.pump.speed == 0.0
    assert later.events.unconverged_stages == 0
    assert all(np.isfinite(later.plant.supply))
    assert measure(later, at_rest(later, p), p, 5e-3)[1].supply_saturation == 1.0


def coupled(simulation, p, seconds):
    """Integrate the crane with the tank line as one of its states; its laws are written out here."""

    def rates(_, y):
        state, tank = unpack(y[:-1]), y[-1] * 1e6
        state = state._replace(stick=state.stick._replace(flow_1=0.0, flow_2=0.0))  # its valve is shut
        ports = ports_at(simulation.spools, p, tank=tank)
        returned = state.swing.flow_2 + state.boom.flow_2  # both are driven forwards: port 2 returns
        passed = np.sqrt(max(0.0, tank - TANK_LINE.preload) / TANK_LINE.resistance)
        rate = (returned - passed) / TANK_LINE.capacitance
        return [*pack(state_derivative(state, ports, p)), rate / 1e6]

    start = [*pack(simulation.plant), simulation.midpoint.tank.pressure / 1e6]
    found = solve_ivp(rates, (0.0, seconds), start, "Radau", rtol=1e-7, atol=1e-9)
    return unpack(found.y[:-1, -1]), found.y[-1, -1] * 1e6


def test_two_axes_at_once_press_the_tank_line_as_an_independent_integration():
    """Swing and boom at speed, and the spools moved on: half a step apart is as good as together."""
    machine = driven("compensated", tank_line=TANK_LINE)
    p = plant_parameters(machine)
    now = advance(equilibrium(START, p), (4.0, 4.0, 0.0), 1e-3, 400, p)
    spools = tuple(s._replace(position=v, target=v) for s, v in zip(now.spools, (7.0, 6.0, 0.0), strict=True))
    now = now._replace(spools=spools)
    expected, tank = coupled(now, p, 0.15)
    end = advance(now, (7.0, 6.0, 0.0), 1e-3, 150, p)
    assert tank > TANK_LINE.preload + 1e5
    assert end.midpoint.tank.pressure == pytest.approx(tank, rel=5e-3)
    assert end.plant.swing.angle == pytest.approx(expected.swing.angle, abs=1e-5)
    assert end.plant.boom.pressure_2 == pytest.approx(expected.boom.pressure_2, rel=5e-3)


def test_a_return_edge_stands_on_the_tank_lines_pressure():
    """p = P_t + C_R Q^2 at the port that returns, and P_t = P_0 + R Q^2 of both flows in steady motion."""
    p = plant_parameters(driven("compensated", tank_line=TANK_LINE))
    now, tanks, flows = advance(equilibrium(START, p), (7.0, 4.0, 0.0), 1e-3, 800, p), [], []
    for _ in range(300):
        now = advance(now, (7.0, 4.0, 0.0), 1e-3, 1, p)
        tanks.append(now.midpoint.tank.pressure)
        flows.append(now.plant.swing.flow_2 + now.plant.boom.flow_2)
    assert np.mean(tanks) > 3e5
    assert np.mean(tanks) - 2e5 == pytest.approx(4.5e10 * np.mean(np.square(flows)), rel=0.02)
    swing = now.plant.swing
    told = measure(now, at_rest(now, p), p, 5e-3)[1]
    port = ports_at(now.spools, p, tank=now.midpoint.tank.seen)[0].port_2
    assert told.pressures[2] == pytest.approx(
        now.midpoint.tank.seen + port.to_tank * swing.flow_2**2, rel=2e-2
    )


def test_port_valves_feed_from_the_tank_line_and_relieve_into_it():
    """Behind shut valves the swing's empty hoses are fed up to P_t, by oil that leaves the tank line."""
    machine = driven("compensated", tank_line=TANK_LINE)
    p = plant_parameters(machine)
    rest = equilibrium(START, p)
    swing = rest.plant.swing._replace(pressure_1=1e5, pressure_2=1e5)
    midpoint = rest.midpoint._replace(tank=TankState(1.8e5, 1.8e5))
    now = rest._replace(plant=rest.plant._replace(swing=swing), midpoint=midpoint)
    after = advance(now, SHUT, 1e-3, 2, p)
    assert after.midpoint.tank.pressure < 1.77e5
    assert min(after.plant.swing[2:4]) > after.midpoint.tank.pressure


@pytest.mark.parametrize("name", ["c180_hoses", "c180"])
@pytest.mark.parametrize("pump", ["compensated", "load sensing"])
@pytest.mark.parametrize("slams", [False, True], ids=["random", "slams"])
def test_energy_closes_with_everything_on(name, pump, slams):
    """20 s: the engine's torque times speed against losses, and what the states store at both ends."""
    machine = everything(pump, load_machine(name))
    p, rng, count = plant_parameters(machine), np.random.default_rng(7), 20000
    levels = rng.choice([-10.0, 0.0, 10.0], (50, 3)) if slams else rng.uniform(-8.0, 8.0, (100, 3))
    volts = np.repeat(levels, count // len(levels), axis=0)
    states, energies = np.zeros((2000, len(STATE))), np.zeros((2000, len(ENERGY)))
    first = equilibrium(start_angles(machine), p)
    last = compiled_record()(first, volts, 1e-3, p, states, energies)
    total = with_stored_energy(account(energies.sum(axis=0)), first, last, p)
    assert abs(unaccounted(total)) < 1e-3 * total.engine
    assert total.return_line > 0.01 * total.engine
    assert last.events.unconverged_stages == 0
    places = {key: states[:, STATE.index(key)] for key in ("pump_stroke", "pump_speed", "tank_pressure")}
    assert 0.0 <= places["pump_stroke"].min() < 0.05 < 0.5 < places["pump_stroke"].max() <= 1.0
    assert 0.85 * N_0 < places["pump_speed"].min() < places["pump_speed"].max() < N_0
    assert places["tank_pressure"].min() == 0.0
    assert places["tank_pressure"].max() > 3e5


def test_losses_are_none_of_them_negative_and_every_part_closes_at_each_state():
    machine = everything("load sensing", load_machine("c180"))
    p, rng = plant_parameters(machine), np.random.default_rng(3)
    now = equilibrium(start_angles(machine), p)
    for _ in range(100):
        now = advance(now, tuple(rng.uniform(-9.0, 9.0, 3).tolist()), 1e-3, 37, p)
        flows = power_flows(now, p)
        pump, axes = flows.pump, (flows.swing, flows.boom, flows.stick)
        lost = pump.pump_friction + pump.pump_leakage + pump.main_relief
        scale = 1e-9 * (abs(pump.engine) + abs(pump.supply) + abs(pump.manifold) + abs(pump.flywheel) + 1.0)
        gap = pump.engine - lost - pump.manifold - pump.flywheel - pump.supply
        assert abs(gap) < scale
        assert min(pump.pump_friction, pump.return_line, pump.main_relief) >= 0.0
        returned = sum(axis.returned + axis.relieved for axis in axes)
        assert pump.return_line + pump.tank_line == pytest.approx(returned, abs=1e-6)
        for axis in axes:
            gap = axis.supply - axis.throttling - axis.inlets - axis.returned
            assert abs(gap) < 1e-9 * (abs(axis.supply) + abs(axis.inlets) + 1.0)
            assert axis.throttling >= -1e-9
            assert axis.port_valves >= 0.0


def test_halving_the_step_quarters_the_error():
    p = plant_parameters(everything("compensated"))

    def run(h):
        now = equilibrium(START, p)
        for k in range(8):
            t = (k + 0.5) * 0.1
            volts = (3.0 + 2.0 * np.sin(3.0 * t), 4.0 + np.cos(2.0 * t), -3.5 - np.sin(2.5 * t))
            now = advance(now, volts, h, round(0.1 / h), p)
        plant = now.plant
        return np.array([plant.swing.angle, plant.boom.angle, plant.pump.speed / 100.0])

    exact = run(3.125e-5)
    errors = [np.abs(run(h) - exact) for h in (1e-3, 2.5e-4)]
    assert max(errors[0]) < 5e-5
    assert np.all(errors[1] < 0.15 * errors[0] + 2e-8)


def test_interpreted_and_compiled_steps_agree_to_the_last_bit():
    machine = everything("load sensing", load_machine("c180"))
    p = plant_parameters(machine)
    one = two = equilibrium(start_angles(machine), p)
    for volts in ((6.0, -7.0, 8.0), (0.0, 9.0, -9.0)):
        two = compiled_advance()(two, volts, 1e-3, 15, p)
        for _ in range(15):
            one = step(one, volts, 1e-3, p)
        assert one == two
