"""The variables and constants of a linear graph as symbols.

| symbol | name |
|---|---|
| P_C_1, Q_I_1, W_2, F_xdot ... | across, through variable of branch C_1, I_1, 2, xdot |
| C_1, P_s, D_m, xdot ... | parameter of an element, input of a source |

Parameters are positive symbols, all others are real. The ratio of a modulated two-port is an input.
"""

from sympy import Expr, Symbol

from forest_sim.linear_graph.linear_graph import Branch, Domain, Kind

SOURCES = (Kind.ACROSS_SOURCE, Kind.THROUGH_SOURCE)


def across_symbol(branch: Branch) -> Symbol:
    """Return the symbol of a branch's across variable; of an across source, its input."""
    if branch.kind is Kind.ACROSS_SOURCE:
        return Symbol(branch.parameter, real=True)
    return Symbol(f"{branch.domain.across}_{branch.name}", real=True)


def through_symbol(branch: Branch) -> Symbol:
    """Return the symbol of a branch's through variable; of a through source, its input."""
    if branch.kind is Kind.THROUGH_SOURCE:
        return Symbol(branch.parameter, real=True)
    return Symbol(f"{branch.domain.through}_{branch.name}", real=True)


def parameter_symbol(branch: Branch) -> Symbol:
    """Return the symbol of an element's constant; of a modulated two-port, its input."""
    return (
        Symbol(branch.parameter, real=True) if branch.modulated else Symbol(branch.parameter, positive=True)
    )


def input_symbol(branch: Branch) -> Symbol:
    """Return the symbol of a source's input."""
    return across_symbol(branch) if branch.kind is Kind.ACROSS_SOURCE else through_symbol(branch)


def state_symbol(storage: Branch) -> Symbol:
    """Return the symbol of a storage's state: across variable of an A-type, through variable of a T-type."""
    return across_symbol(storage) if storage.kind is Kind.A_TYPE else through_symbol(storage)


def storage_rate(branch: Branch, across: Expr, through: Expr) -> Expr:
    """Return the rate of a storage's state: f/C, a/I, or k a of a spring. Thesis eq. 3.4, 3.10."""
    if branch.kind is Kind.A_TYPE:
        return through / parameter_symbol(branch)
    if branch.domain is Domain.HYDRAULIC:
        return across / parameter_symbol(branch)
    return across * parameter_symbol(branch)
