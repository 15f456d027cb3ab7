"""Dependent storages become part of others where only constants lie between, and are refused elsewhere."""

import numpy as np
import pytest
import sympy
from sympy import Abs, Symbol

from forest_sim.linear_graph.actuation_graphs import cylinder, cylinder_with_joint, swing
from forest_sim.linear_graph.graph_run import run
from forest_sim.linear_graph.linear_graph import Branch, Domain, GraphError, Kind, LinearGraph
from forest_sim.linear_graph.state_equations import state_equations

TURNING = Domain.ROTATION
PUMP = Branch("P_s", Kind.ACROSS_SOURCE, "supply", "tank", "P_s")


def element(name, kind, start, end, domain=Domain.HYDRAULIC):
    return Branch(name, kind, start, end, name, domain)


def derive(*branches):
    return state_equations(LinearGraph("test", branches))


def var(name):
    return Symbol(name, real=True)


def par(name):
    return Symbol(name, positive=True)


def rates(equations):
    return dict(zip((s.name for s in equations.states), equations.derivatives, strict=True))


def gear(**changes):
    return (
        Branch("3", Kind.TRANSFORMER, "motor", "frame", "N", TURNING, "4", **changes),
        Branch("4", Kind.TRANSFORMER, "joint", "frame", "N", TURNING, "3", **changes),
    )


TORQUE = Branch("t_s", Kind.THROUGH_SOURCE, "frame", "motor", "t_s", TURNING)
ROTOR = element("J_a", Kind.A_TYPE, "motor", "frame", TURNING)
LINK = element("J_b", Kind.A_TYPE, "joint", "frame", TURNING)
DAMPER = element("B", Kind.D_TYPE, "joint", "frame", TURNING)
GEARED = derive(TORQUE, ROTOR, *gear(), LINK, DAMPER)


def test_inertias_across_a_gear_are_one():
    (state,), n, w = GEARED.states, par("N"), var("W_J_b")
    assert state == w
    total = par("J_b") + n**2 * par("J_a")
    assert sympy.simplify(GEARED.derivatives[0] - (n * var("t_s") - par("B") * w) / total) == 0
    assert GEARED.across["J_a"] == n * w
    assert sympy.simplify(GEARED.through["J_a"] - par("J_a") * n * GEARED.derivatives[0]) == 0
    powers = [GEARED.across[b.name] * GEARED.through[b.name] for b in GEARED.tree.graph.branches]
    assert sympy.simplify(sympy.Add(*powers)) == 0


def test_a_geared_wheel_runs_up_as_its_closed_form():
    times, values = np.linspace(0.0, 3.0, 31), {"J_a": 0.2, "J_b": 5.0, "N": 4.0, "B": 6.0}
    done = run(GEARED, {"t_s": 3.0}, values, {}, times)
    final, time_constant = 4.0 * 3.0 / 6.0, (5.0 + 16.0 * 0.2) / 6.0
    np.testing.assert_allclose(done["W_J_b"], final * (1.0 - np.exp(-times / time_constant)), atol=1e-6)


@pytest.mark.parametrize("turned", [False, True])
def test_teed_capacitances_are_one(turned):
    ends = ("tank", "a") if turned else ("a", "tank")
    e = derive(
        PUMP,
        element("R", Kind.D_TYPE, "supply", "a"),
        element("C_a", Kind.A_TYPE, "a", "tank"),
        element("C_b", Kind.A_TYPE, *ends),
    )
    p = var("P_C_a")
    assert e.states == (p,)
    total = par("R") * (par("C_a") + par("C_b"))
    assert sympy.simplify(e.derivatives[0] - (var("P_s") - p) / total) == 0


def test_inertances_in_series_are_one_and_a_quadratic_drop_stays():
    e = derive(
        PUMP,
        element("I_a", Kind.T_TYPE, "supply", "a"),
        element("I_b", Kind.T_TYPE, "a", "b"),
        element("R", Kind.QUADRATIC, "b", "tank"),
    )
    (q,) = e.states
    drop = par("R") * q * Abs(q)
    assert sympy.simplify(e.derivatives[0] - (var("P_s") - drop) / (par("I_a") + par("I_b"))) == 0


def test_the_swings_motor_adds_its_inertia_by_the_square_of_the_gear_ratio():
    link = element("J", Kind.A_TYPE, "joint", "frame", TURNING)
    rotor = element("J_m", Kind.A_TYPE, "shaft", "frame", TURNING)
    light = state_equations(swing().changed("link", remove=["qdot_sw"], add=[link]))
    heavy = state_equations(swing().changed("link and rotor", remove=["qdot_sw"], add=[link, rotor]))
    assert heavy.states == light.states
    rng = np.random.default_rng(6)
    values = {symbol.name: rng.uniform(0.5, 2.0) for symbol in heavy.parameters}
    states = rng.normal(size=len(heavy.states))
    share = np.where(
        [s.name == "W_J" for s in heavy.states],
        values["J"] / (values["J"] + values["N"] ** 2 * values["J_m"]),
        1.0,
    )
    expected = share * light.function()(states, [3.0], values)
    np.testing.assert_allclose(heavy.function()(states, [3.0], values), expected, rtol=1e-12)


def test_the_oil_of_a_stiff_hose_is_mass_at_the_piston():
    """Without capacitance the inertance moves with the piston: m + gy_1^2 I_1."""
    mass = element("m", Kind.A_TYPE, "piston", "frame", Domain.TRANSLATION)
    e = state_equations(cylinder().changed("stiff hose", remove=["C_1", "xdot"], add=[mass]))
    v, p_2, p_s, b, m, gy_1, gy_2 = (
        *map(var, ("V_m", "P_C_2", "P_s")),
        *map(par, ("B", "m", "gy_1", "gy_2")),
    )
    r_1 = (par("R_1") + par("C_R")) * gy_1**2
    force = gy_1 * (p_s - r_1 * v * Abs(v)) - gy_2 * (p_2 + par("R_2") * gy_2**2 * v * Abs(v)) - b * v
    assert sympy.simplify(rates(e)["V_m"] - force / (m + gy_1**2 * par("I_1"))) == 0


@pytest.mark.parametrize(
    ("graph", "told"),
    [
        (
            LinearGraph("test", (PUMP, element("C", Kind.A_TYPE, "supply", "tank"))),
            r"C \(bound by P_s\).*P_s;",
        ),
        (cylinder().changed("stiff hose", remove=["C_1"]), r"I_1 \(bound by 1\).*derivative of xdot;"),
        (
            cylinder_with_joint().changed("stiff hose", remove=["C_1"]),
            r"I_1 \(bound by 1\).*derivative of arm;",
        ),
        (
            LinearGraph("lever", (TORQUE, ROTOR, *gear(modulated=True), LINK)),
            r"lever: dependent energy storage J_a \(bound by 3\) would need the derivative of N; put",
        ),
    ],
)
def test_what_would_need_another_derivative_is_refused_by_name(graph, told):
    with pytest.raises(GraphError, match=told):
        state_equations(graph)
