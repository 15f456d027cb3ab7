"""The thesis' circuits give the thesis' equations, misprints corrected, and the simulator's numbers."""

import functools

import numpy as np
import pytest
import sympy
from sympy import Abs, Symbol, sign, sqrt

from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_sim.equations.appendix_b import thesis_state_derivative
from forest_sim.linear_graph.actuation_graphs import (
    cylinder,
    cylinder_with_joint,
    cylinder_with_pi_hoses,
    cylinder_with_relief,
    cylinder_with_two_lumps,
    swing,
)
from forest_sim.linear_graph.actuation_parameters import actuation_parameters
from forest_sim.linear_graph.linear_graph import Branch, Domain, Kind
from forest_sim.linear_graph.state_equations import state_equations
from forest_sim.mechanics.manipulator import dynamics, fold_head

THESIS = load_machine("c180_thesis")
P_1, P_2, Q_1, Q_2 = (Symbol(name, real=True) for name in ("P_C_1", "P_C_2", "Q_I_1", "Q_I_2"))
P_S, V, W = (Symbol(name, real=True) for name in ("P_s", "xdot", "qdot_sw"))


@functools.cache  # when a test asks: a second, which whoever only collects the tests need not wait
def swing_equations():
    return state_equations(swing())


@functools.cache
def cylinder_equations():
    return state_equations(cylinder())


def par(names):
    return [Symbol(name, positive=True) for name in names.split()]


C_R, C_R_RETURN, I_1, I_2, C_1, C_2, R_1, R_2 = par("C_R C_R' I_1 I_2 C_1 C_2 R_1 R_2")
GY_1, GY_2, B = par("gy_1 gy_2 B")


def same(derived, written):
    return sympy.cancel(sympy.together(derived - written)) == 0


def line_rates(p_1, p_2):
    """The last two lines of 3.7 and 3.13, corrected: P_s for P_i, C_R' on the return line."""
    return (P_S - C_R * Q_1 * Abs(Q_1) - p_1) / I_1, (p_2 - C_R_RETURN * Q_2 * Abs(Q_2)) / I_2


def test_states_are_those_that_the_thesis_chooses():
    assert swing_equations().states == cylinder_equations().states == (P_1, P_2, Q_1, Q_2)
    assert swing_equations().inputs == (P_S, W)
    assert cylinder_equations().inputs == (P_S, V)


def test_the_cylinders_state_equations_are_3_13_corrected():
    written = ((Q_1 - GY_1 * V) / C_1, (GY_2 * V - Q_2) / C_2, *line_rates(P_1, P_2))
    for derived, line in zip(cylinder_equations().derivatives, written, strict=True):
        assert sympy.simplify(derived - line) == 0


def test_the_cylinders_ports_and_force_are_3_14_and_3_17_corrected():
    """3.14 with a minus at the inlet, and flows that run with the piston; 3.17 less friction."""
    p_in = P_1 - R_1 * (GY_1 * V) ** 2 * sign(V)
    p_out = R_2 * (GY_2 * V) ** 2 * sign(V) + P_2
    q_in, q_out = cylinder_equations().through["1"], cylinder_equations().through["R_2"]
    square = {V * Abs(V): V**2 * sign(V)}
    assert sympy.simplify(cylinder_equations().across["1"].subs(square) - p_in) == 0
    assert sympy.simplify(cylinder_equations().across["4"].subs(square) - p_out) == 0
    assert (q_in, q_out) == (GY_1 * V, GY_2 * V)
    force = sympy.expand(GY_1 * p_in - GY_2 * p_out - B * V)
    assert sympy.simplify(sympy.expand(cylinder_equations().through["xdot"]).subs(square) - force) == 0


def swing_of_3_8():
    """P_Rm and P_R2 of 3.8, and the four lines of 3.7, corrected."""
    r_in, r_e1, r_e2, d_m, n = par("R_in R_e1 R_e2 D_m N")
    r_eq1 = 1 / (1 / R_1 + 1 / R_2 + 1 / r_e1 + 1 / r_e2)
    r_eq2 = 1 / (1 / r_in + 1 / R_1 + 1 / r_e1)
    r_eq3 = (P_1 - P_2) / R_1 - P_2 / r_e1 - d_m * n * W
    r_eq4 = 1 / (1 / r_eq2 - r_eq1 * (1 / R_1 + 1 / r_e1) ** 2)
    p_rm = r_eq4 * (r_eq3 - r_eq1 * (1 / R_1 + 1 / r_e1) * ((P_1 - P_2) / R_1 - P_2 / r_e1 - P_2 / r_e2))
    p_r2 = r_eq1 * ((P_1 - p_rm - P_2) / R_1 - (p_rm + P_2) / r_e1 - P_2 / r_e2)
    through = (P_1 - p_rm - p_r2 - P_2) / R_1
    outlet = through - (p_rm + p_r2 + P_2) / r_e1 - (P_2 + p_r2) / r_e2
    return p_rm, p_r2, ((Q_1 - through) / C_1, (outlet - Q_2) / C_2, *line_rates(P_1, P_2))


def test_the_swings_state_equations_are_3_7_corrected():
    for derived, line in zip(swing_equations().derivatives, swing_of_3_8()[2], strict=True):
        assert same(derived, line)


def test_the_swings_drops_flow_and_torque_are_3_8_and_3_9():
    d_m, n, b_sw = par("D_m N B_sw")
    p_rm, p_r2, _ = swing_of_3_8()
    assert same(swing_equations().across["R_in"], p_rm)
    assert same(swing_equations().across["R_2"], p_r2)
    assert same(swing_equations().across["1"], p_rm)
    assert swing_equations().through["1"] == d_m * n * W
    assert same(swing_equations().through["qdot_sw"], n * d_m * p_rm - b_sw * W)


def random_state(rng, supply):
    """Return 18 states in Appendix B's order, angles within the strokes."""
    x = np.zeros(18)
    x[0::6] = rng.uniform((-3.0, -0.6, -2.1), (3.0, 1.2, -0.9))
    x[1::6] = rng.normal(0.0, 0.5, 3)
    for axis in range(3):
        x[6 * axis + 2 : 6 * axis + 4] = rng.uniform(0.0, supply, 2)
        x[6 * axis + 4 : 6 * axis + 6] = rng.normal(0.0, 2e-3, 2)
    return x


def samples():
    """Yield state, orifice resistances and supply pressure."""
    rng = np.random.default_rng(38)
    for _ in range(120):
        supply = rng.uniform(1e7, 3e7)
        yield random_state(rng, supply), 10.0 ** rng.uniform(10.0, 16.0, 6), supply


def parameters(axis, c_r):
    return actuation_parameters(THESIS, AXES[axis], c_r[2 * axis], c_r[2 * axis + 1])


def arm(axis, x):
    return 1.0 if axis == 0 else lever_arm(x[6 * axis], THESIS.linkages[axis - 1])


def deviation(graph, axis):
    """Return the largest relative deviation of the derived hydraulic rates from the coded ones."""
    rates, worst = state_equations(graph).function(), 0.0
    for x, c_r, p_s in samples():
        coded = thesis_state_derivative(x, c_r, p_s, THESIS)[6 * axis + 2 : 6 * axis + 6]
        speed = arm(axis, x) * x[6 * axis + 1]
        derived = rates(x[6 * axis + 2 : 6 * axis + 6], (p_s, speed), parameters(axis, c_r))
        worst = max(worst, np.max(np.abs(derived / coded - 1.0)))
    return worst


@pytest.mark.parametrize(("axis", "graph"), [(0, swing()), (1, cylinder("boom")), (2, cylinder("stick"))])
def test_the_coded_hydraulics_are_those_of_the_graph(axis, graph):
    assert deviation(graph, axis) < 1e-9


@pytest.mark.parametrize("name", ["1", "2", "3", "4"])
def test_a_port_turned_round_would_be_noticed(name):
    """The comparison above can fail: one port of the motor or of a piston backwards, and it does."""
    for axis, graph in ((0, swing()), (1, cylinder())):
        b = graph.branch(name)
        turned = Branch(b.name, b.kind, b.end, b.start, b.parameter, b.domain, b.partner)
        assert deviation(graph.changed("turned", remove=[name], add=[turned]), axis) > 1e-3


def test_the_coded_torques_are_those_of_the_graph():
    """M q'' + V + G of the coded accelerations against arm times the through variable of the load."""
    body = fold_head(THESIS.manipulator)
    graphs = (swing_equations(), cylinder_equations(), cylinder_equations())
    loads = [e.function(e.through["qdot_sw" if e is swing_equations() else "xdot"]) for e in graphs]
    for x, c_r, p_s in samples():
        d = dynamics(tuple(x[0::6]), tuple(x[1::6]), body)
        mass = np.array([[d.m_11, 0.0, 0.0], [0.0, d.m_22, d.m_23], [0.0, d.m_23, d.m_33]])
        coded = mass @ thesis_state_derivative(x, c_r, p_s, THESIS)[1::6] + d.bias
        for axis, load in enumerate(loads):
            r = arm(axis, x)
            states = x[6 * axis + 2 : 6 * axis + 6]
            (force,) = load(states, (p_s, r * x[6 * axis + 1]), parameters(axis, c_r))
            scale = np.max(np.abs(coded))  # M couples the joints, so rounding does, too
            assert r * force == pytest.approx(coded[axis], rel=1e-9, abs=1e-12 * scale)


def test_pi_hoses_put_the_orifices_between_two_pressures():
    e = state_equations(cylinder_with_pi_hoses())
    rates = dict(zip((s.name for s in e.states), e.derivatives, strict=True))
    p_v, p_a, p_r = (Symbol(name, real=True) for name in ("P_C_1v", "P_C_1a", "P_C_2v"))
    c_v, c_a, c_r = par("C_1v C_1a C_2v")
    inflow = sign(P_S - p_v) * sqrt(Abs(P_S - p_v) / C_R)
    outflow = sign(p_r) * sqrt(Abs(p_r) / C_R_RETURN)
    assert len(rates) == 6
    assert sympy.simplify(rates["P_C_1v"] - (inflow - Q_1) / c_v) == 0
    assert sympy.simplify(rates["Q_I_1"] - (p_v - R_1 * Q_1 * Abs(Q_1) - p_a) / I_1) == 0
    assert sympy.simplify(rates["P_C_1a"] - (Q_1 - GY_1 * V) / c_a) == 0
    assert sympy.simplify(rates["P_C_2v"] - (Q_2 - outflow) / c_r) == 0
    assert e.across["1"] == p_a


def test_two_lumps_are_two_states_more_and_leave_the_other_hose_alone():
    e = state_equations(cylinder_with_two_lumps())
    rates = dict(zip((s.name for s in e.states), e.derivatives, strict=True))
    q_11, q_12, p_11, p_12 = (Symbol(name, real=True) for name in ("Q_I_11", "Q_I_12", "P_C_11", "P_C_12"))
    c_11, i_12, r_11, r_12 = par("C_11 I_12 R_11 R_12")
    assert len(rates) == 6
    assert rates["P_C_2"] == cylinder_equations().derivatives[1]
    assert rates["Q_I_2"] == cylinder_equations().derivatives[3]
    assert sympy.simplify(rates["P_C_11"] - (q_11 - q_12) / c_11) == 0
    assert sympy.simplify(rates["Q_I_12"] - (p_11 - r_11 * q_12 * Abs(q_12) - p_12) / i_12) == 0
    assert sympy.simplify(e.across["1"] - (p_12 - r_12 * GY_1**2 * V * Abs(V))) == 0


def test_a_relief_branch_adds_its_flow_to_one_equation():
    e = state_equations(cylinder_with_relief())
    (r_v,) = par("R_v1")
    added = [
        sympy.simplify(new - old)
        for new, old in zip(e.derivatives, cylinder_equations().derivatives, strict=True)
    ]
    assert added == [-P_1 / (r_v * C_1), 0, 0, 0]
    assert e.through["xdot"] == cylinder_equations().through["xdot"]


def test_one_orifice_parameter_for_both_ways_is_a_change_of_data():
    """C_R' is a parameter of its own; who prints C_R on both lines, as 3.13 does, says so in the branch."""
    back = Branch("C_R'", Kind.QUADRATIC, "valve_2", "tank", "C_R")
    e = state_equations(cylinder().changed("one orifice", remove=["C_R'"], add=[back]))
    assert C_R in e.derivatives[3].free_symbols
    assert C_R_RETURN not in set(e.parameters)
    assert C_R_RETURN in cylinder_equations().derivatives[3].free_symbols


def test_a_swinging_link_instead_of_the_velocity_source_becomes_a_state():
    """The thesis' remark on fig. 3.8: the manipulator gives the velocity like dW/dt = t/J."""
    link = Branch("J", Kind.A_TYPE, "joint", "frame", "J", Domain.ROTATION)
    e = state_equations(swing().changed("with a link", remove=["qdot_sw"], add=[link]))
    (j,) = par("J")
    rate = dict(zip((s.name for s in e.states), e.derivatives, strict=True))["W_J"]
    driven = swing_equations().through["qdot_sw"].xreplace({W: Symbol("W_J", real=True)})
    assert same(rate * j, driven)
    assert len(e.states) == 5


def test_a_lever_arm_is_an_input_that_speed_and_force_share():
    """J dW/dt = arm F(arm W) + t_load, with the force that the circuit without a joint has."""
    e = state_equations(cylinder_with_joint())
    arm_, w, load = (Symbol(name, real=True) for name in ("arm", "W_J", "t_load"))
    assert e.inputs == (P_S, load, arm_)
    (j,) = par("J")
    force = cylinder_equations().through["xdot"].xreplace({V: arm_ * w})
    assert e.states[:2] == (P_1, w)
    assert sympy.simplify(e.derivatives[1] * j - (arm_ * force + load)) == 0
    assert sympy.simplify(e.derivatives[0] - cylinder_equations().derivatives[0].xreplace({V: arm_ * w})) == 0
