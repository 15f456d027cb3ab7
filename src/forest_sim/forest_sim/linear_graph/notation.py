"""Linear graphs in LaTeX: symbols as the thesis sets them, and the elements' laws."""

from sympy import Symbol

from forest_sim.linear_graph.drawing_geometry import notation
from forest_sim.linear_graph.linear_graph import Branch, Domain, Kind, LinearGraph
from forest_sim.linear_graph.symbols import (
    SOURCES,
    across_symbol,
    input_symbol,
    parameter_symbol,
    through_symbol,
)


def latex(name: str) -> str:
    """Return a symbol's name in LaTeX."""
    n = notation(name)
    base = rf"\dot {n.base}" if n.dotted else n.base if len(n.base) == 1 else rf"\mathit{{{n.base}}}"
    return base + (f"_{{{n.subscript}}}" if n.subscript else "") + ("'" if n.prime else "")


def symbol_names(graph: LinearGraph) -> dict[Symbol, str]:
    """Return the LaTeX of every symbol of a graph."""
    names = {}
    for branch in graph.branches:
        names[parameter_symbol(branch)] = latex(branch.parameter)
        inner = branch.name if branch.partner else latex(branch.name)
        for symbol, letter in (
            (across_symbol(branch), branch.domain.across),
            (through_symbol(branch), branch.domain.through),
        ):
            names[symbol] = f"{letter}_{{{inner}}}"
    for branch in graph.of(*SOURCES):  # the source's own variable is the input
        names[input_symbol(branch)] = latex(branch.parameter)
    return names


def law(branch: Branch, names: dict[Symbol, str]) -> str:
    """Return an element's law in LaTeX. Thesis eq. 3.4, 3.10."""
    a, f = names[across_symbol(branch)], names[through_symbol(branch)]
    c, hydraulic = latex(branch.parameter), branch.domain is Domain.HYDRAULIC
    effect, cause = (a, f) if hydraulic else (f, a)
    return {
        Kind.A_TYPE: rf"{c}\,\tfrac{{d}}{{dt}}{a} = {f}",
        Kind.T_TYPE: rf"{c}\,\tfrac{{d}}{{dt}}{f} = {a}"
        if hydraulic
        else rf"\tfrac{{d}}{{dt}}{f} = {c}\,{a}",
        Kind.D_TYPE: rf"{effect} = {c}\,{cause}",
        Kind.QUADRATIC: rf"{effect} = {c}\,{cause}\,\lvert {cause}\rvert",
    }.get(branch.kind, "input")


def two_port_laws(one: Branch, two: Branch, names: dict[Symbol, str]) -> tuple[str, str]:
    """Return the two laws of a transformer or gyrator in LaTeX. Thesis eq. 3.4, 3.10."""
    a_1, a_2 = names[across_symbol(one)], names[across_symbol(two)]
    f_1, f_2 = names[through_symbol(one)], names[through_symbol(two)]
    c = latex(one.parameter)
    if one.kind is Kind.TRANSFORMER:
        return rf"{a_1} = {c}\,{a_2}", rf"{f_2} = -{c}\,{f_1}"
    return rf"{f_1} = {c}\,{a_2}", rf"{f_2} = -{c}\,{a_1}"
