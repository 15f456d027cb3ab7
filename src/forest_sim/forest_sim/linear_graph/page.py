"""Write docs/explanation/linear-graphs.md and its drawings: each circuit, its normal tree, its equations.

`python -m forest_sim.linear_graph.page` writes them; a test compares. The equations are those that
`state_equations` derives, set in LaTeX. A denominator that is a sum gets a name, Δ.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

try:
    import sympy
    from sympy import Expr, Symbol
except ModuleNotFoundError:
    if __name__ != "__main__":
        raise
    sys.exit("the page needs sympy; allowed: scripts/setup.sh test, or pip install 'forest-crane[graphs]'")

from forest_sim.linear_graph.drawing import svg
from forest_sim.linear_graph.layouts import CIRCUITS, Circuit
from forest_sim.linear_graph.linear_graph import TWO_PORTS, Domain, Kind
from forest_sim.linear_graph.normal_tree import NormalTree
from forest_sim.linear_graph.notation import latex, law, symbol_names, two_port_laws
from forest_sim.linear_graph.page_text import INTRODUCTION, NOTES
from forest_sim.linear_graph.state_equations import StateEquations, state_equations
from forest_sim.linear_graph.symbols import across_symbol, through_symbol


def element_table(tree: NormalTree) -> str:
    """Return the table of branches: kind, nodes, law, and continuity or compatibility."""
    graph, names = tree.graph, symbol_names(tree.graph)
    laws = {b.name: law(b, names) for b in graph.branches if b.kind not in TWO_PORTS}
    for one, two in graph.pairs():
        laws[one.name], laws[two.name] = two_port_laws(one, two, names)
    inside = {branch.name for branch in tree.tree}
    rows = ["| branch | kind | from, to | law | in | interconnection |", "|---|---|---|---|---|---|"]
    for branch in graph.branches:
        in_tree = branch.name in inside
        signs = (tree.continuity() if in_tree else tree.compatibility())[branch.name]
        symbol = through_symbol if in_tree else across_symbol
        total = _signed([(s, names[symbol(graph.branch(name))]) for name, s in signs.items()])
        shown = branch.name if branch.partner else f"${latex(branch.name)}$"
        domain = "" if branch.domain is Domain.HYDRAULIC else f", {branch.domain.name.lower()}"
        rule = laws[branch.name]
        cells = [
            shown,
            f"{branch.kind.value}{domain}",
            f"{branch.start}, {branch.end}",
            rule if rule == "input" else f"${rule}$",
            "**tree**" if in_tree else "link",
            f"${names[symbol(branch)]} = {total}$",
        ]
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def equation_text(equations: StateEquations) -> str:
    """Return the state equations, and the variables that the rest of the machine needs, in LaTeX blocks."""
    graph = equations.tree.graph
    storages = equations.tree.storages
    rates = [
        equations.through[b.name] if b.kind is Kind.A_TYPE else equations.across[b.name] for b in storages
    ]
    others = secondary(equations)
    named, sums = name_denominators([*rates, *others.values()])
    names = symbol_names(graph) | {symbol: symbol.name for symbol in sums}

    def text(expression: Expr) -> str:
        return str(sympy.latex(expression, symbol_names=names))

    constants = [latex(branch.parameter) for branch in storages]
    left = [
        rf"{c}\,\frac{{d{text(state)}}}{{dt}}" for c, state in zip(constants, equations.states, strict=True)
    ]
    left += [text(symbol) for symbol in others]
    lines = [_block(f"{one} = {text(value)}") for one, value in zip(left, named, strict=True)]
    parts = ["State equations:", *lines[: len(rates)]]
    parts += ["Pressure and flow of the actuator's ports, and the load:", *lines[len(rates) :]]
    where = [_block(f"{text(symbol)} = {text(total)}") for symbol, total in sums.items()]
    return "\n\n".join([*parts, "with", *where] if where else parts)


def secondary(equations: StateEquations) -> dict[Symbol, Expr]:
    """Return pressure and flow of the hydraulic ports, and what the mechanical sources carry."""
    graph = equations.tree.graph
    ports = [b for b in graph.of(*TWO_PORTS) if b.domain is Domain.HYDRAULIC]
    loads = [b for b in graph.of(Kind.ACROSS_SOURCE) if b.domain is not Domain.HYDRAULIC]
    pressures = {across_symbol(b): equations.across[b.name] for b in ports}
    return pressures | {through_symbol(b): equations.through[b.name] for b in ports + loads}


def name_denominators(expressions: Sequence[Expr]) -> tuple[list[Expr], dict[Symbol, Expr]]:
    """Return the expressions with every denominator that is a sum replaced, and the sums by name."""
    found = {
        power.base: None
        for expression in expressions
        for power in sorted(expression.atoms(sympy.Pow), key=sympy.default_sort_key)
        if power.exp == -1 and power.base.is_Add
    }
    names = [r"\Delta"] if len(found) == 1 else [rf"\Delta_{{{k + 1}}}" for k in range(len(found))]
    sums = {Symbol(name, positive=True): total for name, total in zip(names, found, strict=True)}
    swap = {1 / total: 1 / symbol for symbol, total in sums.items()}
    return [expression.xreplace(swap) for expression in expressions], sums


def section(circuit: Circuit) -> str:
    """Return one circuit's part of the page."""
    equations = state_equations(circuit.graph())
    inside = ", ".join(f"branch {b.name}" if b.partner else f"${latex(b.name)}$" for b in equations.tree.tree)
    return "\n\n".join(
        (
            f"## {circuit.title}",
            f"![Linear graph: {circuit.title}](graphs/{circuit.file}.svg)",
            NOTES[circuit.file],
            f"Normal tree:\n{inside}.",
            element_table(equations.tree),
            equation_text(equations),
        )
    )


def files() -> dict[str, str]:
    """Return the text of the page and of each drawing, by its path below docs/explanation."""
    page = "\n\n".join([INTRODUCTION.rstrip(), *(section(circuit) for circuit in CIRCUITS)]) + "\n"
    drawings = {f"graphs/{c.file}.svg": svg(state_equations(c.graph()).tree, c.layout) for c in CIRCUITS}
    return {"linear-graphs.md": page} | drawings


def main() -> None:
    """Write the page and the drawings into the directory that is named, by default docs/explanation."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("directory", nargs="?", type=Path, default=Path("docs/explanation"))
    root = parser.parse_args().directory
    for name, text in files().items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, "utf-8")


def _signed(terms: Sequence[tuple[int, str]]) -> str:
    """Return a sum of signed symbols."""
    text = "".join(f" {'+' if s > 0 else '-'} {symbol}" for s, symbol in terms).strip()
    return text.removeprefix("+ ") or "0"


def _block(equation: str) -> str:
    return f"$${equation}$$"


if __name__ == "__main__":
    main()
