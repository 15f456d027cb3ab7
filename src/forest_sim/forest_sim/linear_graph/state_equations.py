"""State equations of a linear graph, derived: element laws, continuity and compatibility, elimination.

States are the across variables of the A-types in the normal tree and the through variables of the
T-types in the links; a storage that depends on these is merged with them (`merging`). Continuity
and compatibility express every variable by the primary ones, across variables of tree branches and
through variables of links; the element laws then form one equation for each primary variable that
is neither state nor input. All but the quadratic ones (`quadratic`) are linear and are solved
together.

`symbols` tells how variables and parameters are called. The ratio of a modulated two-port is an
input: its laws are algebraic, so they hold, and keep the power, at every instant of a ratio that
changes.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy
from numpy.typing import ArrayLike
from sympy import Expr, Symbol

from forest_description.types import Floats
from forest_sim.linear_graph.linear_graph import TWO_PORTS, Branch, Domain, GraphError, Kind, LinearGraph
from forest_sim.linear_graph.merging import merged
from forest_sim.linear_graph.normal_tree import NormalTree, normal_tree
from forest_sim.linear_graph.quadratic import SHUNT_FLOW, shunt_flow, solve_quadratic
from forest_sim.linear_graph.symbols import (
    SOURCES,
    across_symbol,
    input_symbol,
    parameter_symbol,
    state_symbol,
    storage_rate,
    through_symbol,
)


@dataclass(frozen=True)
class StateEquations:
    """d(states)/dt = derivatives, and every branch's variables, in states, inputs and parameters."""

    tree: NormalTree
    states: tuple[Symbol, ...]
    inputs: tuple[Symbol, ...]
    parameters: tuple[Symbol, ...]
    derivatives: tuple[Expr, ...]
    across: Mapping[str, Expr]
    through: Mapping[str, Expr]

    def function(self, *expressions: Expr) -> Callable[..., Floats]:
        """Return f(states, inputs, parameters) for some expressions, by default the derivatives.

        States and inputs are in the order of the fields, parameters a dict by name.
        """
        arguments = [*self.states, *self.inputs, *self.parameters]
        modules = [{SHUNT_FLOW.__name__: shunt_flow}, "numpy"]
        compiled = sympy.lambdify(arguments, list(expressions or self.derivatives), modules, cse=True)
        names = [symbol.name for symbol in self.parameters]

        def evaluate(states: ArrayLike, inputs: ArrayLike, parameters: dict[str, float]) -> Floats:
            values = [*np.asarray(states), *np.asarray(inputs), *(parameters[name] for name in names)]
            return np.array(compiled(*values), dtype=np.float64)

        return evaluate


class TidyVariables(Mapping[str, Expr]):
    """Variables by their branches' names, each tidied when it is first looked at: that takes longest.

    Args:
        variables: in terms of the primary ones.
        known: the primary ones in states, inputs and parameters.
    """

    def __init__(self, variables: Mapping[str, Expr], known: Mapping[Symbol, Expr]) -> None:
        self._variables, self._known, self._tidied = variables, known, dict[str, Expr]()

    def __getitem__(self, name: str) -> Expr:
        if name not in self._tidied:
            self._tidied[name] = tidy(self._variables[name].xreplace(self._known))
        return self._tidied[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)


def state_equations(graph: LinearGraph) -> StateEquations:
    """Derive the state equations. Thesis eq. 3.7, 3.13 are what it gives for the thesis' circuits.

    Raises:
        GraphError: the circuit has no normal tree, a storage depends on what cannot be
            differentiated, or an element's law cannot be eliminated explicitly.
    """
    tree = normal_tree(graph)
    across, through = primary_variables(tree)
    known = _solved(tree, across, through)
    a, f = TidyVariables(across, known), TidyVariables(through, known)
    sources, modulated = graph.of(*SOURCES), [branch for branch in graph.branches if branch.modulated]
    constant = [b for b in graph.branches if b.kind not in SOURCES and not b.modulated]
    return StateEquations(
        tree=tree,
        states=tuple(state_symbol(branch) for branch in tree.storages),
        inputs=tuple(_unique([*map(input_symbol, sources), *map(parameter_symbol, modulated)])),
        parameters=tuple(_unique([parameter_symbol(branch) for branch in constant])),
        derivatives=tuple(storage_rate(b, a[b.name], f[b.name]) for b in tree.storages),
        across=a,
        through=f,
    )


def primary_variables(tree: NormalTree) -> tuple[dict[str, Expr], dict[str, Expr]]:
    """Return every branch's across and through variable in terms of the primary ones.

    Compatibility gives the links' across variables, continuity the tree branches' through
    variables. Thesis eq. 3.5, 3.6, 3.11, 3.12. Differs: 3.11 prints Q3 for Q4 in its last line.
    """
    across = {branch.name: across_symbol(branch) for branch in tree.tree}
    through = {branch.name: through_symbol(branch) for branch in tree.links}
    for link, signs in tree.compatibility().items():
        across[link] = sympy.Add(*(s * across[name] for name, s in signs.items()))
    for branch, signs in tree.continuity().items():
        through[branch] = sympy.Add(*(s * through[name] for name, s in signs.items()))
    return across, through


def linear_laws(graph: LinearGraph, across: dict[str, Expr], through: dict[str, Expr]) -> list[Expr]:
    """Return the linear element laws without storage, each as an expression that is zero.

    Thesis eq. 3.4, 3.10. Differs: 3.10 prints Q_1 = -gy1 V_2, which 3.13 contradicts.
    """
    laws = []
    for branch in graph.of(Kind.D_TYPE):
        cause, effect = _resistance_variables(branch, across, through)
        laws.append(effect - parameter_symbol(branch) * cause)
    for one, two in graph.pairs():
        ratio = parameter_symbol(one)
        if one.kind is Kind.TRANSFORMER:
            laws.append(across[one.name] - ratio * across[two.name])
            laws.append(through[two.name] + ratio * through[one.name])
        else:
            laws.append(through[one.name] - ratio * across[two.name])
            laws.append(through[two.name] + ratio * across[one.name])
    return laws


def tidy(expression: Expr) -> Expr:
    """Return a sum; terms over the same sum as denominator share one factored coefficient."""
    total, fractions = sympy.S.Zero, dict[tuple[Expr, Expr], Expr]()
    for term in sympy.Add.make_args(sympy.expand(expression)):
        variables = (symbol for symbol in term.free_symbols if not symbol.is_positive)
        constant, carrier = term.as_independent(*variables)
        numerator, denominator = sympy.fraction(constant)
        if any(factor.is_Add for factor in sympy.Mul.make_args(denominator)):
            key = (carrier, denominator)
            fractions[key] = fractions.get(key, sympy.S.Zero) + numerator
        else:
            total += term
    shared = []
    for (carrier, below), above in fractions.items():
        minus = -1 if above.could_extract_minus_sign() else 1
        shared.append(sympy.Mul(minus, carrier, sympy.factor(minus * above), 1 / below))
    return sympy.Add(total, *shared)


def _resistance_variables(
    branch: Branch, across: dict[str, Expr], through: dict[str, Expr]
) -> tuple[Expr, Expr]:
    """Return what a D-type's constant multiplies, and the result: Q and P, or V and F."""
    a, f = across[branch.name], through[branch.name]
    return (f, a) if branch.domain is Domain.HYDRAULIC else (a, f)


def _solved(tree: NormalTree, across: dict[str, Expr], through: dict[str, Expr]) -> dict[Symbol, Expr]:
    """Return the primary variables that are neither state nor input, in states, inputs and parameters."""
    graph, inside = tree.graph, {branch.name for branch in tree.tree}

    def primary(branch: Branch) -> Symbol:
        return (across if branch.name in inside else through)[branch.name]

    unknown = {primary(branch): branch for branch in graph.of(Kind.D_TYPE, *TWO_PORTS)}
    quadratic = {primary(branch): branch for branch in graph.of(Kind.QUADRATIC)}
    known = merged(tree, across, through, _solve_linear(graph, linear_laws(graph, across, through), unknown))
    return solve_quadratic(graph, across, through, known, quadratic)


def _solve_linear(
    graph: LinearGraph, laws: Sequence[Expr], unknown: dict[Symbol, Branch]
) -> dict[Symbol, Expr]:
    """Solve the linear laws; what is left of a singular system names its elements."""
    if not unknown:
        return {}
    solutions = sympy.linsolve(laws, list(unknown))
    values = dict(zip(unknown, next(iter(solutions)), strict=True)) if solutions else {}
    free = {s for value in values.values() for s in value.free_symbols} & set(unknown)
    if free or not values:
        names = sorted({unknown[symbol].name for symbol in free or unknown})
        raise GraphError(
            f"{graph.name}: continuity, compatibility and linear laws do not determine "
            f"element {', '.join(names)}"
        )
    return values


def _unique(symbols: Sequence[Symbol]) -> list[Symbol]:
    return list(dict.fromkeys(symbols))
