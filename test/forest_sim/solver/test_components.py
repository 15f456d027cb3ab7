"""Claims about the time step with every component: it integrates the coded law, with its order, safely."""

import dataclasses

import numpy as np
import pytest
from full_machine import (
    C180,
    CUSHION,
    FRICTION,
    PUMPS,
    START,
    advance,
    full_machine,
    pack,
    reference,
    unpack,
    with_pump,
)

from forest_description.hydraulics.valve_parameters import BackwardValve
from forest_sim.equations.plant import state_derivative
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.hydraulics.command_history import held
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import GAMMA, spools_after, step
from forest_sim.stage.implicit_stage import solve_stage

MODERATE, WIDE = (3.0, 2.5, -3.5), (9.0, 9.0, 9.0)
CASES = {
    **{f"full, {name}": (full_machine(name), MODERATE) for name in PUMPS},
    "full, saturated": (full_machine("compensated"), WIDE),
    "c180_hoses, saturated": (with_pump("compensated"), WIDE),
    "weak engine": (with_pump("compensated", engine_power=2e4), WIDE),
}
each_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES)


def in_motion(machine, voltages, seconds=0.25):
    """A machine under way, its spools where the voltages hold them."""
    p = plant_parameters(machine)
    now = advance(equilibrium(START, p), voltages, 1e-3, round(1000 * seconds), p)
    return p, now._replace(spools=spools_after(now.spools, held(voltages), 100.0, p))


@each_case
def test_steps_agree_with_an_independent_integrator_and_converge_with_order_two(case):
    machine, voltages = case
    p, begin = in_motion(machine, voltages)
    truth = reference(begin, p, 0.2)
    errors = [pack(advance(begin, voltages, 0.2 / n, n, p).plant) - truth for n in (200, 400, 800)]
    assert np.max(np.abs(errors[0][0:18:6])) < 1e-6  # rad
    assert np.max(np.abs(errors[0][[2, 3, 8, 9, 14, 15, 18]])) < 2e-5  # of 20 MPa
    sizes = [np.linalg.norm(error) for error in errors]
    assert np.log2(sizes[0] / sizes[1]) == pytest.approx(2.0, abs=0.3)
    assert np.log2(sizes[1] / sizes[2]) == pytest.approx(2.0, abs=0.3)


@each_case
def test_every_stage_solves_the_law_of_the_machine(case):
    machine, voltages = case
    p, y = in_motion(machine, voltages)
    ports, h = ports_at(y.spools, p), 1e-3
    first, _, failed = solve_stage(y.plant, y.plant, tuple(a.rate for a in y.plant[:3]), ports, GAMMA * h, p)
    assert not failed
    k_1 = pack(state_derivative(first, ports, p))
    np.testing.assert_allclose(pack(first), pack(y.plant) + GAMMA * h * k_1, rtol=0.0, atol=5e-7)
    end = pack(step(y, voltages, h, p).plant)
    k_2 = pack(state_derivative(unpack(end), ports, p))
    np.testing.assert_allclose(
        end, pack(y.plant) + h * ((1.0 - GAMMA) * k_1 + GAMMA * k_2), rtol=0.0, atol=5e-7
    )


def test_packing_a_state_and_unpacking_it_are_inverse():
    y = np.arange(1.0, 36.0)
    np.testing.assert_allclose(pack(unpack(y)), y, rtol=1e-15)


def violent(machine, seconds=20.0, h=1e-3):
    """Full steps on all axes every 0.3 s, watched millisecond by millisecond."""
    p, rng = plant_parameters(machine), np.random.default_rng(1)
    now = equilibrium(START, p)
    for _ in range(round(seconds / 0.3)):
        volts = tuple(rng.choice([-10.0, 0.0, 10.0], 3).tolist())
        for _ in range(round(0.3 / h)):
            before, now = now, compiled_advance()(now, volts, h, 1, p)
            yield before, now


@pytest.mark.parametrize("name", PUMPS)
def test_every_stage_of_a_violent_session_converges(name):
    p, rng = plant_parameters(full_machine(name)), np.random.default_rng(1)
    now = equilibrium(START, p)
    for _ in range(67):
        now = advance(now, tuple(rng.choice([-10.0, 0.0, 10.0], 3).tolist()), 1e-3, 300, p)
    assert np.all(np.isfinite(pack(now.plant)))
    assert now.events.unconverged_stages == 0
    assert now.events.relief_openings > 0
    assert now.events.anticavitation_openings > 0


def test_a_pump_with_a_narrow_band_converges_too():
    """Across its kinks Newton alone jumped to and fro, in a fifth of all stages of such a session."""
    stiff = {"compensator_band": 1.6e4, "manifold_capacitance": 1e-12, "engine_power": 3.3e4}
    machine = with_pump("load sensing", full_machine(), **stiff, response_time=0.025)
    p, rng = plant_parameters(machine), np.random.default_rng(2)
    now = equilibrium(START, p)
    for _ in range(34):
        now = advance(now, tuple(rng.choice([-10.0, -2.0, 0.0, 2.0, 10.0], 3).tolist()), 1e-3, 300, p)
    assert now.events.unconverged_stages == 0


def test_events_count_every_opening_of_a_port_valve():
    machine, relieved, checked = full_machine("compensated"), 0, 0
    valves = machine.port_valves
    for before, now in violent(machine, 6.0):
        for a, b in zip(before.plant[:3], now.plant[:3], strict=True):
            for p_a, p_b in ((a.pressure_1, b.pressure_1), (a.pressure_2, b.pressure_2)):
                relieved += p_a <= valves.relief_pressure < p_b
                checked += p_a >= valves.anticavitation_pressure > p_b
    assert (now.events.relief_openings, now.events.anticavitation_openings) == (relieved, checked)
    assert relieved > 5
    assert checked > 5


def test_a_machine_without_port_valves_counts_no_openings():
    machine = dataclasses.replace(C180, port_valves=None)
    p = plant_parameters(machine)
    now = advance(equilibrium(START, p), (10.0,) * 3, 1e-3, 1000, p)
    now = advance(now, (0.0,) * 3, 1e-3, 1000, p)
    assert now.events == (0, 0, 0)
    assert max(axis.pressure_1 for axis in now.plant[:3]) > 2.5e7


def test_interpreted_and_compiled_steps_are_the_same_law_with_every_component():
    p, compiled = plant_parameters(full_machine()), compiled_advance()
    a = b = equilibrium(START, p)
    for k in range(150):
        volts = (6.0 * np.sin(0.05 * k), 5.0 * np.cos(0.03 * k), -8.0 * np.sin(0.04 * k))
        a, b = step(a, volts, 1e-3, p), compiled(b, volts, 1e-3, 1, p)
    np.testing.assert_allclose(pack(a.plant), pack(b.plant), rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("name", PUMPS)
def test_left_and_right_mirror_each_other_with_every_pump(name):
    unequal = dataclasses.replace(C180.valve, deadband_voltage=-0.1, leakage_conductance=1e-13)
    swing = dataclasses.replace(C180.swing, valve=unequal, flow_regime="turbulent")
    p = plant_parameters(dataclasses.replace(with_pump(name), swing=swing))
    begin = equilibrium(START, p)
    left, right = (advance(begin, (v, 0.0, 0.0), 1e-3, 1000, p).plant for v in (5.0, -5.0))
    assert left.swing.angle == pytest.approx(-right.swing.angle, rel=1e-9)
    assert left.swing.pressure_1 == pytest.approx(right.swing.pressure_2, rel=1e-6)
    assert left.supply == pytest.approx(right.supply, rel=1e-9)


def test_a_direction_of_its_own_is_its_directions_alone():
    """A valve whose negative side is narrower moves as fast as ever to the positive side."""
    narrow = dataclasses.replace(C180.valve, backward=BackwardValve(1.0, 4.0 * C180.valve.minimum_resistance))
    own = dataclasses.replace(with_pump("ideal"), swing=dataclasses.replace(C180.swing, valve=narrow))

    def rate(machine, voltage):
        p = plant_parameters(machine)
        return advance(equilibrium(START, p), (voltage, 0.0, 0.0), 1e-3, 2000, p).plant.swing.rate

    rates = [rate(machine, v) for machine in (with_pump("ideal"), own) for v in (4.0, -4.0)]
    assert rates[2] == rates[0] == pytest.approx(-rates[1], rel=1e-9)
    assert 0.45 < rates[3] / rates[1] < 0.6


def test_a_component_that_does_nothing_changes_nothing():
    """Friction without force, a cushion without resistance, the shared valve as an axis' own."""
    still = dataclasses.replace(FRICTION, coulomb_force=0.0, breakaway_force=0.0)
    open_cushion = dataclasses.replace(CUSHION, resistance=0.0)
    boom = dataclasses.replace(C180.boom, friction=still, cushion=open_cushion, valve=C180.valve)
    machines = (C180, dataclasses.replace(C180, boom=boom))
    ends = [in_motion(machine, WIDE, 0.5)[1].plant for machine in machines]
    assert ends[0] == ends[1]
