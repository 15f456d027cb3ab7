"""Quadratic elements: which of their variables is given, and two that share a flow.

A quadratic law is explicit where its argument is known: Q of a D-type in the tree (an orifice in
series with an inertance, a hose in series with a piston), P of one in the links (an orifice between
two capacitances).

Two orifices at one port, in front of an inertance, know neither. An underlapped valve has them: one
edge to the supply, in the tree, and one to the tank, a link. Their pair of laws has a closed form
(`shunt_flow`), which stands in the equations as the function `SHUNT_FLOW`.

| symbol | name |
|---|---|
| Q | flow that the storage prescribes |
| z | flow through the link beside it: the tree's orifice passes Q + z |
| D | drop across both orifices |
| R_1, R_2 | constants of the tree's and of the link's orifice |
"""

import math
from collections.abc import Mapping

import sympy
from sympy import Abs, Expr, Symbol, sign, sqrt

from forest_sim.linear_graph.linear_graph import Branch, Domain, GraphError, LinearGraph
from forest_sim.linear_graph.symbols import across_symbol, parameter_symbol

SHUNT_FLOW = sympy.Function("shunt_flow", real=True, nargs=4)
"""`shunt_flow` of (Q, D, R_1, R_2) in the equations."""


def shunt_flow(flow: float, drop: float, series: float, shunt: float) -> float:
    """Return z of R_1 (Q + z)|Q + z| + R_2 z|z| = D.

    The left side rises with z. Its values at z = 0 and z = -Q tell the signs of z and of Q + z; with
    these the equation is quadratic, and each form of its root is the one that divides by no small
    number.

    Args:
        flow: Q [m^3/s].
        drop: D [Pa].
        series: R_1, finite and positive [Pa s^2/m^6].
        shunt: R_2, finite and positive [Pa s^2/m^6].
    """
    along = 1.0 if drop >= -shunt * flow * abs(flow) else -1.0  # sign of Q + z
    beside = 1.0 if drop >= series * flow * abs(flow) else -1.0  # sign of z
    total = series + along * beside * shunt
    square = along * total * drop - along * beside * series * shunt * flow**2
    root = along * math.sqrt(max(0.0, square))
    if along == beside:
        return (root - series * flow) / total
    return (along * drop - series * flow**2) / (series * flow + root)


def solve_quadratic(
    graph: LinearGraph,
    across: Mapping[str, Expr],
    through: Mapping[str, Expr],
    known: dict[Symbol, Expr],
    quadratic: Mapping[Symbol, Branch],
) -> dict[Symbol, Expr]:
    """Return what is known, and with it the primary variables of the quadratic elements.

    Args:
        graph: the circuit.
        across: every branch's across variable in primary ones.
        through: every branch's through variable in primary ones.
        known: solution of the linear laws, in states, inputs and quadratic elements' variables.
        quadratic: the quadratic elements by their primary variables.

    Raises:
        GraphError: a law is neither explicit nor one of such a pair; the message names the elements.
    """
    pending = dict(quadratic)
    while pending:
        given = {
            symbol: sympy.expand(
                (through if _in_tree(symbol, branch) else across)[branch.name].xreplace(known)
            )
            for symbol, branch in pending.items()
        }
        found = {
            symbol: _explicit(branch, given[symbol], _in_tree(symbol, branch))
            for symbol, branch in pending.items()
            if not given[symbol].free_symbols & set(pending)
        }
        found = found or _pair(pending, given)
        if not found:
            raise _implicit(graph, list(pending.values()))
        pending = {symbol: branch for symbol, branch in pending.items() if symbol not in found}
        known = {symbol: expression.xreplace(found) for symbol, expression in known.items()} | found
    return known


def _in_tree(symbol: Symbol, branch: Branch) -> bool:
    """Tell whether a branch is in the tree, by its primary variable."""
    return bool(symbol == across_symbol(branch))


def _explicit(branch: Branch, given: Expr, in_tree: bool) -> Expr:
    """Return a = R f|f| from f, or f = sign(a) sqrt(|a|/R) from a. Thesis eq. 3.1, 3.4, 3.10."""
    constant = parameter_symbol(branch)
    if in_tree == (branch.domain is Domain.HYDRAULIC):
        return constant * given * Abs(given)
    return sign(given) * sqrt(Abs(given) / constant)


def _implicit(graph: LinearGraph, branches: list[Branch]) -> GraphError:
    names = ", ".join(f"{branch.name} (parameter {branch.parameter})" for branch in branches)
    return GraphError(
        f"{graph.name}: cannot eliminate the quadratic element {names}: neither its flow nor its drop "
        "is given by states and inputs alone; put it in series with a storage of flow, or make it linear"
    )


def _pair(pending: Mapping[Symbol, Branch], given: Mapping[Symbol, Expr]) -> dict[Symbol, Expr]:
    """Return both variables of one pair in which each element waits for the other alone."""
    waiting = {symbol: given[symbol].free_symbols & set(pending) for symbol in pending}
    for drop, tree in pending.items():
        for flow, link in pending.items():
            hydraulic = tree.domain is link.domain is Domain.HYDRAULIC
            if (
                not hydraulic
                or (waiting[drop], waiting[flow]) != ({flow}, {drop})
                or not _in_tree(drop, tree)
            ):
                continue
            s = given[drop].coeff(flow)
            alone, both = given[drop] - s * flow, given[flow] + s * drop
            if s not in (1, -1) or (alone.free_symbols | both.free_symbols) & {flow, drop}:
                continue
            beside = SHUNT_FLOW(alone, s * both, parameter_symbol(tree), parameter_symbol(link))
            return {flow: s * beside, drop: _explicit(tree, alone + beside, in_tree=True)}
    return {}
