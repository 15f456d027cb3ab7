"""The time step: it integrates the coded law, survives shut valves, and converges with its order."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import load_machine
from forest_sim.equations.appendix_b import from_array, thesis_state_derivative, to_array
from forest_sim.equations.plant import state_derivative
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import valve_ports
from forest_sim.hydraulics.command_history import held
from forest_sim.hydraulics.port import is_shut
from forest_sim.hydraulics.spool_dynamics import Spool
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import GAMMA, Simulation, spools_after, step
from forest_sim.stage.implicit_stage import solve_stage

C180, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")
SCALE = np.tile([1.0, 1.0, 2e7, 2e7, 3e-3, 3e-3], 3)
START = inverse_kinematics((5.5, 0.0, 1.0), C180.manipulator.links)


def steps(machine, simulation, voltages, count, h=1e-3):
    return compiled_advance()(simulation, voltages, h, count, plant_parameters(machine))


def moving(machine, seconds=0.4):
    return steps(
        machine, equilibrium(START, plant_parameters(machine)), (3.0, 2.5, -2.5), round(seconds * 1000)
    )


def assert_same_state(a, b):
    """Compare 18 states, each against its own natural scale: rad, rad/s, the supply's pressure, full flow."""
    np.testing.assert_allclose(a / SCALE, b / SCALE, rtol=0.0, atol=1e-9)


def rates(simulation):
    """Joint rates from which Newton may start."""
    return tuple(axis.rate for axis in simulation.plant[:3])


@pytest.mark.parametrize("voltages", [(3.0, 2.5, -2.5), (-4.0, -3.0, 2.0), (9.0, -9.0, 9.0)])
def test_a_stage_solves_the_law_that_thesis_state_derivative_gives(voltages):
    """Each stage is Y = y + gamma h f(Y) with the public f; checked on both stages of one step."""
    p, h = plant_parameters(THESIS), 1e-3
    y = steps(THESIS, equilibrium(START, p), voltages, 300)
    ports = tuple(valve_ports(v, p.valves[0].law) for v in voltages)
    first, _, failed = solve_stage(y.plant, y.plant, rates(y), ports, GAMMA * h, p)
    assert not failed
    k_1 = to_array(state_derivative(first, ports, p))
    assert_same_state(to_array(first), to_array(y.plant) + GAMMA * h * k_1)
    end = to_array(step(y, voltages, h, p).plant)
    k_2 = to_array(state_derivative(from_array(end, p.supply.set_pressure), ports, p))
    expected = to_array(y.plant) + h * ((1.0 - GAMMA) * k_1 + GAMMA * k_2)
    assert_same_state(end, expected)
    if min(voltages) > 0:  # Appendix B's only direction
        c_r = [c for axis in ports for c in (axis.port_1.to_supply, axis.port_2.to_tank)]
        np.testing.assert_array_equal(
            k_1, thesis_state_derivative(to_array(first), c_r, p.supply.set_pressure, THESIS)
        )


def test_forward_stages_use_the_very_thesis_derivative():
    p, h = plant_parameters(THESIS), 1e-3
    y = steps(THESIS, equilibrium(START, p), (3.0, 2.5, 2.5), 300)
    ports = tuple(valve_ports(v, p.valves[0].law) for v in (3.0, 2.5, 2.5))
    stage, _, _ = solve_stage(y.plant, y.plant, rates(y), ports, GAMMA * h, p)
    c_r = [c for axis in ports for c in (axis.port_1.to_supply, axis.port_2.to_tank)]
    slope = thesis_state_derivative(to_array(stage), c_r, p.supply.set_pressure, THESIS)
    assert_same_state(to_array(stage), to_array(y.plant) + GAMMA * h * slope)


def test_one_second_agrees_with_an_independent_integrator():
    """scipy's Radau at tight tolerance on the public derivative, valves held open."""
    p = plant_parameters(THESIS)
    begin = moving(THESIS)
    ports = [valve_ports(v, p.valves[0].law) for v in (3.0, 2.5, 2.5)]
    c_r = [c for axis in ports for c in (axis.port_1.to_supply, axis.port_2.to_tank)]
    solution = solve_ivp(
        lambda _, y: thesis_state_derivative(y * SCALE, c_r, p.supply.set_pressure, THESIS) / SCALE,
        (0.0, 1.0),
        to_array(begin.plant) / SCALE,
        method="Radau",
        rtol=1e-8,
        atol=1e-9,
    )
    ours = to_array(steps(THESIS, begin, (3.0, 2.5, 2.5), 1000).plant)
    theirs = solution.y[:, -1] * SCALE
    np.testing.assert_allclose(ours[0::6], theirs[0::6], atol=1e-5)  # rad
    for pressure in (2, 3):
        np.testing.assert_allclose(ours[pressure::6], theirs[pressure::6], atol=4e4)  # Pa


def test_error_falls_with_the_square_of_the_step():
    begin = moving(THESIS)
    fine, half, whole = (
        to_array(steps(THESIS, begin, (3.0, 2.5, -2.5), round(0.2 / h), h).plant)[0::6]
        for h in (6.25e-5, 5e-4, 1e-3)
    )
    order = np.log2(np.linalg.norm(whole - fine) / np.linalg.norm(half - fine))
    assert order == pytest.approx(2.0, abs=0.25)


def test_interpreted_and_compiled_advance_are_the_same_law():
    p, advance = plant_parameters(C180), compiled_advance()
    a = b = equilibrium(START, p)
    for k in range(300):
        volts = (4.0 * math.sin(0.02 * k), 3.0 * math.cos(0.013 * k), -4.0 * math.sin(0.017 * k))
        a, b = step(a, volts, 1e-3, p), advance(b, volts, 1e-3, 1, p)
    np.testing.assert_allclose(to_array(a.plant), to_array(b.plant), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("machine", [THESIS, C180], ids=["thesis", "c180_hoses"])
def test_shut_valves_hold_the_crane_for_an_hour(machine):
    """Ten milliseconds a step, an hour in a hundredth of it: nothing may creep through a shut valve."""
    begin = equilibrium(START, plant_parameters(machine))
    end = steps(machine, begin, (0.9, -0.9, 0.0), 36_000, h=0.1)
    np.testing.assert_allclose(to_array(end.plant)[0::6], to_array(begin.plant)[0::6], atol=1e-9)


def test_flow_stops_within_the_step_in_which_a_valve_shuts():
    before = moving(THESIS)
    after = step(before, (0.0, 0.0, 0.0), 1e-3, plant_parameters(THESIS))
    for axis_before, axis in zip(before.plant[:3], after.plant[:3], strict=True):
        assert abs(axis_before.flow_1) > 1e-4
        assert axis.flow_1 == axis.flow_2 == 0.0


def test_relief_and_anticavitation_bound_what_a_sudden_closure_does():
    """At full swing speed the thesis machine's oil reaches impossible pressures, the default's does not."""
    extremes = {}
    for machine in (THESIS, C180):
        p, advance = plant_parameters(machine), compiled_advance()
        now = steps(machine, equilibrium(START, p), (10.0, 0.0, 0.0), 2000)
        pressures = []
        for _ in range(1000):
            now = advance(now, (0.0, 0.0, 0.0), 1e-3, 1, p)
            pressures += [now.plant.swing.pressure_1, now.plant.swing.pressure_2]
        extremes[machine.name] = min(pressures), max(pressures)
    assert extremes["c180_thesis"][0] < -5e7
    assert extremes["c180_thesis"][1] > 5e7
    assert extremes["c180_hoses"][0] > -1e5
    assert extremes["c180_hoses"][1] < 26e6


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_end_stops_keep_every_joint_in_its_limits(direction):
    p = plant_parameters(C180)
    end = steps(C180, equilibrium(START, p), (direction * 10.0,) * 3, 8000)
    for axis, state in ((p.boom, end.plant.boom), (p.stick, end.plant.stick)):
        linkage = p.boom_linkage if axis is p.boom else p.stick_linkage
        from forest_description.geometry.linkage import cylinder_length

        position = cylinder_length(state.angle, linkage)
        assert axis.stop.lower - 0.005 < position < axis.stop.upper + 0.005
    assert p.swing.stop.lower - 0.01 < end.plant.swing.angle < p.swing.stop.upper + 0.01


def test_left_and_right_swing_mirror_each_other():
    p = plant_parameters(C180)
    begin = equilibrium(START, p)
    left, right = (steps(C180, begin, (v, 0.0, 0.0), 1500) for v in (4.0, -4.0))
    assert left.plant.swing.angle == pytest.approx(-right.plant.swing.angle, rel=1e-9)
    assert left.plant.swing.pressure_1 == pytest.approx(right.plant.swing.pressure_2, rel=1e-6)


def test_positive_voltage_moves_every_joint_in_its_positive_direction():
    p = plant_parameters(C180)
    for sign in (1.0, -1.0):
        end = steps(C180, equilibrium(START, p), (sign * 4.0,) * 3, 800)
        for angle, start in zip(to_array(end.plant)[0::6], START, strict=True):
            assert sign * (angle - start) > 0.02


def test_full_swing_speed_balances_orifices_hoses_and_damping():
    """Steady state by hand: P_s = 2 C_R q^2 + 2 R q + (B u)/d with q = d u (leakage apart); 0.97 rad/s."""
    p, d = plant_parameters(THESIS), THESIS.swing.gear_ratio * THESIS.swing.motor_displacement
    resistance, line = THESIS.valve.minimum_resistance, p.swing.line_1.resistance
    a, b, c = 2 * resistance * d * d, 2 * line * d + THESIS.swing.damping / d, -p.supply.set_pressure
    by_hand = (-b + math.sqrt(b * b - 4 * a * c)) / (2 * a)
    swing = steps(THESIS, equilibrium(START, p), (10.0, 0.0, 0.0), 8000).plant.swing.rate
    assert swing == pytest.approx(by_hand, rel=0.03)
    assert swing == pytest.approx(0.97, abs=0.03)


def test_spool_lag_is_the_exact_first_order_response():
    begin = (Spool(0.0, 0.0), Spool(2.0, 0.0), Spool(-1.0, 0.0))
    spools = spools_after(begin, held((10.0, 0.0, 3.0)), 0.01, plant_parameters(C180))
    keep = math.exp(-2 * math.pi * 12.0 * 0.01)
    expected = (10.0 * (1 - keep), 2.0 * keep, 3.0 - 4.0 * keep)
    np.testing.assert_allclose([spool.position for spool in spools], expected, rtol=1e-12)
    at_once = spools_after(begin, held((10.0, 0.0, 3.0)), 1e-6, plant_parameters(THESIS))
    assert [spool.position for spool in at_once] == [10.0, 0.0, 3.0]


def test_a_spool_does_not_travel_beyond_its_rated_voltage():
    p = plant_parameters(C180)
    far = step(equilibrium(START, p), (50.0, -50.0, 0.0), 1.0, p)
    assert far.spools[0].position == pytest.approx(10.0)
    assert far.spools[1].position == pytest.approx(-10.0)


def test_equilibrium_is_at_rest_with_positive_pressures():
    p = plant_parameters(C180)
    rng = np.random.default_rng(5)
    shut = valve_ports(0.0, p.valves[0].law)
    for boom, stick in rng.uniform((-0.6, -2.1), (1.2, -0.9), (50, 2)):
        rest = equilibrium((0.3, boom, stick), p)
        assert isinstance(rest, Simulation)
        after = step(rest, (0.0, 0.0, 0.0), 1e-3, p)
        assert np.max(np.abs(to_array(after.plant)[1::6])) < 1e-9
        assert min(rest.plant.boom[2:4] + rest.plant.stick[2:4]) >= 0.0
        assert is_shut(shut.port_1)
        assert is_shut(shut.port_2)
