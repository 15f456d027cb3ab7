"""Storages that depend on others: capacitances at one node, inertias across a gear, inertances in series.

The variable of such a storage is a sum of states with constant coefficients, so its law is one more
linear equation: C d(sum of c_k x_k)/dt = f. The rates dx_k/dt are those of the storages that have a
state, in which f stands too; solved for f, it adds to their constants: J_1 + N^2 J_2 for an inertia
J_2 that turns N times as fast.

An input or a changing ratio in the sum would have to be differentiated; that is refused.
"""

from collections.abc import Sequence

import sympy
from sympy import Expr, Symbol

from forest_sim.linear_graph.linear_graph import Branch, GraphError, Kind
from forest_sim.linear_graph.normal_tree import NormalTree
from forest_sim.linear_graph.symbols import across_symbol, state_symbol, storage_rate, through_symbol


def merged(
    tree: NormalTree, across: dict[str, Expr], through: dict[str, Expr], known: dict[Symbol, Expr]
) -> dict[Symbol, Expr]:
    """Return what is known, and with it what the dependent storages take from the others.

    Args:
        tree: with the dependent storages.
        across: every branch's across variable in primary ones.
        through: every branch's through variable in primary ones.
        known: solution of the linear laws, in states, inputs, and what dependent storages take.

    Raises:
        GraphError: a storage depends on more than states; the message names it and what binds it.
    """
    if not tree.dependent:
        return known
    rates = {
        state_symbol(b): storage_rate(b, across[b.name].xreplace(known), through[b.name].xreplace(known))
        for b in tree.storages
    }
    laws, taken = [], []
    for branch in tree.dependent:
        stored = (across if branch.kind is Kind.A_TYPE else through)[branch.name]
        shares = _shares(tree, branch, sympy.expand(stored.xreplace(known)), list(rates))
        own = storage_rate(branch, across_symbol(branch), through_symbol(branch))
        laws.append(own - sympy.Add(*(share * rates[state] for state, share in shares.items())))
        taken.append(through_symbol(branch) if branch.kind is Kind.A_TYPE else across_symbol(branch))
    values = dict(zip(taken, next(iter(sympy.linsolve(laws, taken))), strict=True))
    return {symbol: expression.xreplace(values) for symbol, expression in known.items()} | values


def _shares(tree: NormalTree, branch: Branch, stored: Expr, states: Sequence[Symbol]) -> dict[Symbol, Expr]:
    """Return the constant coefficients of the states in a dependent storage's variable."""
    shares = {state: stored.coeff(state) for state in states if stored.has(state)}
    rest = sympy.expand(stored - sympy.Add(*(share * state for state, share in shares.items())))
    changing = {s for share in (rest, *shares.values()) for s in share.free_symbols if not s.is_positive}
    if changing:
        bound = (tree.loops if branch.kind is Kind.A_TYPE else tree.continuity())[branch.name]
        named = ", ".join(sorted(symbol.name for symbol in changing))
        raise GraphError(
            f"{tree.graph.name}: dependent energy storage {branch.name} (bound by {', '.join(bound)}) would "
            f"need the derivative of {named}; put a D-type between"
        )
    return shares
