"""State equations derived from small circuits whose equations everyone knows, and those that have none."""

import numpy as np
import pytest
import sympy
from sympy import Abs, Symbol, sign, sqrt

from forest_sim.linear_graph.actuation_graphs import cylinder_with_underlap
from forest_sim.linear_graph.layouts import CIRCUITS
from forest_sim.linear_graph.linear_graph import Branch, Domain, GraphError, Kind, LinearGraph
from forest_sim.linear_graph.state_equations import state_equations, tidy

PUMP = Branch("P_s", Kind.ACROSS_SOURCE, "supply", "tank", "P_s")
TURNING = Domain.ROTATION

GRAPHS = [*(c.graph() for c in CIRCUITS), cylinder_with_underlap()]


def element(name, kind, start, end, domain=Domain.HYDRAULIC):
    return Branch(name, kind, start, end, name, domain)


def derive(*branches):
    return state_equations(LinearGraph("test", branches))


def var(name):
    return Symbol(name, real=True)


def par(name):
    return Symbol(name, positive=True)


def test_a_series_resonator():
    e = derive(
        PUMP,
        element("R", Kind.D_TYPE, "supply", "a"),
        element("I", Kind.T_TYPE, "a", "b"),
        element("C", Kind.A_TYPE, "b", "tank"),
    )
    p, q, p_s = var("P_C"), var("Q_I"), var("P_s")
    assert e.states == (p, q)
    assert e.inputs == (p_s,)
    assert e.parameters == (par("R"), par("I"), par("C"))
    assert e.derivatives[0] == q / par("C")
    assert sympy.expand(e.derivatives[1] - (p_s - par("R") * q - p) / par("I")) == 0


def test_mechanical_elements_have_damping_and_stiffness():
    """A torque turns a wheel on a spring with a damper: J dW/dt = t_s - B W - t_k, dt_k/dt = k W."""
    e = derive(
        Branch("t_s", Kind.THROUGH_SOURCE, "frame", "wheel", "t_s", TURNING),
        element("J", Kind.A_TYPE, "wheel", "frame", TURNING),
        element("B", Kind.D_TYPE, "wheel", "frame", TURNING),
        element("k", Kind.T_TYPE, "wheel", "frame", TURNING),
    )
    w, t = var("W_J"), var("t_k")
    assert e.states == (w, t)
    assert sympy.expand(e.derivatives[0] - (var("t_s") - par("B") * w - t) / par("J")) == 0
    assert e.derivatives[1] == par("k") * w


def test_a_mechanical_quadratic_resistance_gives_force_from_speed():
    e = derive(
        Branch("v", Kind.ACROSS_SOURCE, "piston", "frame", "v", TURNING),
        element("c", Kind.QUADRATIC, "piston", "frame", TURNING),
    )
    assert e.through["c"] == par("c") * var("v") * Abs(var("v"))
    assert not e.states


def test_a_gear_multiplies_torque_and_divides_speed():
    gear = (
        Branch("3", Kind.TRANSFORMER, "motor", "frame", "N", TURNING, "4"),
        Branch("4", Kind.TRANSFORMER, "joint", "frame", "N", TURNING, "3"),
    )
    torque = Branch("t_s", Kind.THROUGH_SOURCE, "frame", "motor", "t_s", TURNING)
    e = derive(torque, *gear, element("J", Kind.A_TYPE, "joint", "frame", TURNING))
    assert e.derivatives == (par("N") * var("t_s") / par("J"),)
    assert e.across["3"] == par("N") * var("W_J")


def test_two_gyrators_in_series_are_a_transformer():
    """A pump driven at W makes D_1 W of flow, which turns a motor of D_2 at W D_1/D_2."""
    turn = Branch("w", Kind.ACROSS_SOURCE, "shaft", "frame", "w", TURNING)
    e = derive(
        turn,
        Branch("1", Kind.GYRATOR, "port", "tank", "D_1", partner="2"),
        Branch("2", Kind.GYRATOR, "shaft", "frame", "D_1", TURNING, "1"),
        Branch("3", Kind.GYRATOR, "port", "tank", "D_2", partner="4"),
        Branch("4", Kind.GYRATOR, "load", "frame", "D_2", TURNING, "3"),
        element("B", Kind.D_TYPE, "load", "frame", TURNING),
    )
    assert e.across["4"] == -par("D_1") * var("w") / par("D_2")
    assert e.through["w"] == -par("B") * par("D_1") ** 2 * var("w") / par("D_2") ** 2


def test_an_orifice_between_two_known_pressures_gives_flow_from_their_difference():
    e = derive(PUMP, element("C_R", Kind.QUADRATIC, "supply", "a"), element("C", Kind.A_TYPE, "a", "tank"))
    drop = var("P_s") - var("P_C")
    assert sympy.simplify(e.through["C_R"] - sign(drop) * sqrt(Abs(drop) / par("C_R"))) == 0


def test_a_quadratic_element_may_wait_for_another():
    """The shunt's drop is the drop of the resistance in series with the inertance, both quadratic."""
    e = derive(
        PUMP,
        element("I", Kind.T_TYPE, "supply", "a"),
        element("R_a", Kind.QUADRATIC, "a", "b"),
        Branch("Q_x", Kind.THROUGH_SOURCE, "b", "tank", "Q_x"),
        element("R_b", Kind.QUADRATIC, "b", "tank"),
    )
    q, x = var("Q_I"), var("Q_x")
    expected = var("P_s") - par("R_a") * q * Abs(q) - par("R_b") * (q - x) * Abs(q - x)
    assert sympy.expand(e.derivatives[0] * par("I") - expected) == 0


@pytest.mark.parametrize(
    "shunts",
    [
        [element("R_l", Kind.D_TYPE, "a", "tank")],
        [element(name, Kind.QUADRATIC, "a", "tank") for name in ("R_l", "R_m")],
    ],
)
def test_a_quadratic_element_in_a_loop_of_resistances_is_named(shunts):
    with pytest.raises(GraphError, match=r"cannot eliminate the quadratic element .*R_q \(parameter R_q\)"):
        derive(
            PUMP,
            element("I", Kind.T_TYPE, "supply", "a"),
            element("R_q", Kind.QUADRATIC, "a", "tank"),
            *shunts,
        )


def test_laws_that_leave_a_variable_open_are_named():
    """Two equal motors back to back on one shaft: any pressure between them gives no torque."""
    e = (
        Branch("t_s", Kind.THROUGH_SOURCE, "frame", "shaft", "t_s", TURNING),
        element("B", Kind.D_TYPE, "shaft", "frame", TURNING),
        Branch("1", Kind.GYRATOR, "port", "tank", "D", partner="2"),
        Branch("2", Kind.GYRATOR, "shaft", "frame", "D", TURNING, "1"),
        Branch("3", Kind.GYRATOR, "port", "tank", "D", partner="4"),
        Branch("4", Kind.GYRATOR, "frame", "shaft", "D", TURNING, "3"),
    )
    with pytest.raises(GraphError, match=r"do not determine element [1-4]"):
        derive(*e)


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda g: g.name)
def test_no_circuit_makes_or_loses_power(graph):
    """Tellegen: the products of all across and through variables add up to zero."""
    e = state_equations(graph)
    rng = np.random.default_rng(1)
    power = e.function(*(e.across[b.name] * e.through[b.name] for b in e.tree.graph.branches))
    for _ in range(20):
        states, inputs = rng.normal(size=len(e.states)), rng.normal(size=len(e.inputs))
        parameters = {symbol.name: rng.uniform(0.5, 2.0) for symbol in e.parameters}
        powers = power(states, inputs, parameters)
        assert abs(powers.sum()) < 1e-12 * np.abs(powers).sum()


@pytest.mark.parametrize("graph", [g for g in GRAPHS if not g.of(Kind.THROUGH_SOURCE)], ids=lambda g: g.name)
def test_an_elements_arrow_changes_signs_only(graph):
    """Turned round, D-types and storages leave the machine as it is: same pump flow, same load."""
    branches = graph.of(Kind.D_TYPE, Kind.QUADRATIC, Kind.A_TYPE, Kind.T_TYPE)
    names = [branch.name for branch in branches]
    turned = [Branch(b.name, b.kind, b.end, b.start, b.parameter, b.domain) for b in branches]
    e, other = state_equations(graph), state_equations(graph.changed("turned", remove=names, add=turned))
    assert [symbol.name for symbol in other.states] == [symbol.name for symbol in e.states]
    rng = np.random.default_rng(2)
    states, inputs = rng.normal(size=len(e.states)), rng.normal(size=2)
    parameters = {symbol.name: rng.uniform(0.5, 2.0) for symbol in e.parameters}
    sources = [source.name for source in graph.of(Kind.ACROSS_SOURCE)]
    assert [symbol.name for symbol in e.inputs] == [symbol.name for symbol in other.inputs] == sources
    straight = e.function(*(e.through[name] for name in sources), *e.derivatives)
    round_ = other.function(*(other.through[name] for name in sources), *other.derivatives)
    signs = [1.0, 1.0] + [-1.0] * len(states)
    there, back = straight(states, inputs, parameters), round_(-states, inputs, parameters)
    np.testing.assert_allclose(back, signs * there, rtol=1e-12)


def test_tidy_changes_nothing_but_the_form():
    a, b, x, y = par("a"), par("b"), var("x"), var("y")
    expression = (x + 2 * y) / (a + b) + a * x / (a + b) + (b + a) * x * Abs(x)
    assert sympy.simplify(tidy(expression) - expression) == 0
    assert tidy(expression).coeff(y) == 2 / (a + b)
