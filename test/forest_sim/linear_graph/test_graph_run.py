"""Circuits run: closed forms, and the thesis' circuits against the simulator's own plant."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from forest_description.geometry.linkage import lever_arm
from forest_description.hydraulics.valve_characteristic import edges
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.linear_graph.actuation_graphs import (
    cylinder,
    cylinder_with_joint,
    cylinder_with_underlap,
    swing,
)
from forest_sim.linear_graph.actuation_parameters import actuation_parameters
from forest_sim.linear_graph.graph_run import run
from forest_sim.linear_graph.linear_graph import Branch, Domain, GraphError, Kind, LinearGraph
from forest_sim.linear_graph.state_equations import state_equations
from forest_sim.mechanics.manipulator import dynamics, fold_head
from forest_sim.solver.compiled_plant import fastest_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import STATE, store

THESIS = load_machine("c180_thesis")
STEP = 1e-4  # [s], of the simulator
VOLTAGE = 4.0


@pytest.fixture(scope="module")
def swinging():
    return simulated("swing")


@pytest.fixture(scope="module")
def lifting():
    return simulated("boom")


def simulated(axis, machine=THESIS):
    """Return a second of the simulator with one axis' valve open and the others at 0 V: time, states."""
    p, count = plant_parameters(machine), round(1.0 / STEP)
    start = equilibrium((0.3, 0.2, -1.4), p)
    voltages = np.zeros((count, 3))
    voltages[:, AXES.index(axis)] = VOLTAGE
    states = np.zeros((count + 1, len(STATE)))
    store(start, states[0])
    fastest_record()(start, voltages, STEP, p, states[1:], None)
    return STEP * np.arange(count + 1), states


def column(states, name):
    return states[:, STATE.index(name)]


def piston_speed(axis, states):
    """Return the speed of the swing [rad/s] or of a piston [m/s]."""
    rate = column(states, f"{axis}_rate")
    if axis == "swing":
        return rate
    linkage = THESIS.linkages[AXES.index(axis) - 1]
    return rate * [lever_arm(angle, linkage) for angle in column(states, f"{axis}_angle")]


def open_valve(axis):
    e = edges(VOLTAGE, THESIS.valve_of(AXES.index(axis)).law)
    return actuation_parameters(THESIS, axis, e.supply_1, e.tank_2)


def hoses(axis, states, row=0):
    """Return the circuit's states as the simulator has them."""
    fields = {"P_C_1": "pressure_1", "P_C_2": "pressure_2", "Q_I_1": "flow_1", "Q_I_2": "flow_2"}
    return {name: column(states, f"{axis}_{field}")[row] for name, field in fields.items()}


def assert_alike(done, axis, states):
    for name, value in hoses(axis, states, slice(None, None, 50)).items():
        assert np.max(np.abs(done[name] - value)) < 2e-4 * np.ptp(value), name


@pytest.mark.parametrize(
    ("axis", "graph", "source", "run_of"),
    [("swing", swing(), "qdot_sw", "swinging"), ("boom", cylinder(), "xdot", "lifting")],
)
def test_a_derived_circuit_runs_as_the_simulator_does(axis, graph, source, run_of, request):
    time, states = request.getfixturevalue(run_of)
    speed = CubicSpline(time, piston_speed(axis, states))
    done = run(
        state_equations(graph),
        {"P_s": THESIS.pump.supply_pressure, source: lambda t, _: float(speed(t))},
        open_valve(axis),
        hoses(axis, states),
        time[::50],
    )
    assert np.ptp(speed(time)) > 0.03
    assert_alike(done, axis, states)


def load_torque(time, states, inertia):
    """Return the torque on the boom's joint [N m] over time: gravity, the stick, what M_22 has beyond J."""
    body = fold_head(THESIS.manipulator)
    angles, rates = (np.column_stack([column(states, f"{a}_{f}") for a in AXES]) for f in ("angle", "rate"))
    moved = [dynamics(tuple(q), tuple(w), body) for q, w in zip(angles.tolist(), rates.tolist(), strict=True)]
    acceleration = CubicSpline(time, rates).derivative()(time)
    others = np.array([(d.m_22 - inertia, d.m_23, d.bias[1]) for d in moved])
    return -(others[:, 0] * acceleration[:, 1] + others[:, 1] * acceleration[:, 2] + others[:, 2])


def test_the_booms_circuit_with_its_joint_moves_as_the_simulator_does(lifting):
    """The speed is a state here, the lever arm follows the angle; of the simulator is the load alone."""
    time, states = lifting
    angle, rate = column(states, "boom_angle"), column(states, "boom_rate")
    inertia = dynamics((0.3, angle[0], -1.4), (0.0, 0.0, 0.0), fold_head(THESIS.manipulator)).m_22
    load = CubicSpline(time, load_torque(time, states, inertia))
    done = run(
        state_equations(cylinder_with_joint()),
        {
            "P_s": THESIS.pump.supply_pressure,
            "t_load": lambda t, _: float(load(t)),
            "arm": lambda _, x: lever_arm(x["q"], THESIS.linkages[0]),
        },
        open_valve("boom") | {"J": inertia},
        hoses("boom", states) | {"q": angle[0]},
        time[::50],
        {"q": "J"},
    )
    assert np.ptp(angle) > 0.05
    assert np.max(np.abs(done["q"] - angle[::50])) < 2e-4 * np.ptp(angle)
    assert np.max(np.abs(done["W_J"] - rate[::50])) < 2e-4 * np.ptp(rate)
    assert_alike(done, "boom", states)


def test_an_underlapped_valve_runs_as_the_simulators_does():
    """The boom's four edges are open at once; both ports pass oil from the supply to the tank."""
    machine = replace(THESIS, valve=replace(THESIS.valve, deadband_voltage=-5.0))
    time, states = simulated("boom", machine)
    e, speed = edges(VOLTAGE, machine.valve_of(1).law), CubicSpline(time, piston_speed("boom", states))
    done = run(
        state_equations(cylinder_with_underlap()),
        {"P_s": machine.pump.supply_pressure, "xdot": lambda t, _: float(speed(t))},
        actuation_parameters(machine, "boom", e.supply_1, e.tank_2) | {"C_T1": e.tank_1, "C_S2": e.supply_2},
        hoses("boom", states),
        time[::50],
    )
    assert min(np.max(done["Q_C_T1"]), np.max(done["Q_C_S2"])) > 1e-5
    assert_alike(done, "boom", states)


RESONATOR = state_equations(
    LinearGraph(
        "resonator",
        (
            Branch("P_s", Kind.ACROSS_SOURCE, "supply", "tank", "P_s"),
            Branch("R", Kind.D_TYPE, "supply", "a", "R"),
            Branch("I", Kind.T_TYPE, "a", "b", "I"),
            Branch("C", Kind.A_TYPE, "b", "tank", "C"),
        ),
    )
)
HOSE = {"R": 2e8, "I": 1e7, "C": 1e-12}


def test_a_resonator_rings_as_its_closed_form():
    times = np.linspace(0.0, 0.05, 101)
    done = run(RESONATOR, {"P_s": 1e7}, HOSE, {}, times)
    decay = HOSE["R"] / (2.0 * HOSE["I"])
    angular = math.sqrt(1.0 / (HOSE["I"] * HOSE["C"]) - decay**2)
    ringing = np.cos(angular * times) + decay / angular * np.sin(angular * times)
    np.testing.assert_allclose(done["P_C"], 1e7 * (1.0 - np.exp(-decay * times) * ringing), atol=1e3)
    np.testing.assert_allclose(done["P_R"] + done["P_I"] + done["P_C"], 1e7, rtol=1e-9)


def test_an_input_may_follow_a_displacement():
    """A wheel pulled back by a torque in proportion to its angle is an oscillator."""
    wheel = LinearGraph(
        "wheel",
        (
            Branch("t_s", Kind.THROUGH_SOURCE, "frame", "wheel", "t_s", Domain.ROTATION),
            Branch("J", Kind.A_TYPE, "wheel", "frame", "J", Domain.ROTATION),
        ),
    )
    times = np.linspace(0.0, 2.0, 41)
    pull = {"t_s": lambda _, x: -18.0 * x["q"]}
    done = run(state_equations(wheel), pull, {"J": 2.0}, {"q": 0.1}, times, {"q": "J"})
    np.testing.assert_allclose(done["q"], 0.1 * np.cos(3.0 * times), atol=1e-6)
    np.testing.assert_allclose(done["W_J"], -0.3 * np.sin(3.0 * times), atol=1e-6)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"inputs": {}}, "input: missing P_s, unknown none; allowed: P_s"),
        ({"parameters": HOSE | {"L": 1.0}}, "parameter: missing none, unknown L; allowed: C, I, R"),
        ({"start": {"P": 1.0}}, "state at the start: missing none, unknown P; allowed: P_C, Q_I"),
        ({"displacements": {"q": "J"}}, "displaced branch: missing none, unknown J; allowed: C, I, P_s, R"),
    ],
)
def test_names_that_are_missing_or_unknown_are_told(changed, told):
    given = {"inputs": {"P_s": 1e7}, "parameters": HOSE, "start": {}, "times": (0.0, 0.01)} | changed
    with pytest.raises(GraphError, match=told):
        run(RESONATOR, **given)
