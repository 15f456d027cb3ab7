"""Writes the mutants of modules: each is the module's source with one small fault in it.

Cosmic Ray finds the places and edits its parse tree. The rest of the module keeps its text, which
`forest_compile` can still translate. Runs in the interpreter that has Cosmic Ray; see scripts/mutate.sh.

    python mutants.py SOURCE...    one JSON object a line: function, line, key, original, source, text
"""

from __future__ import annotations

import ast
import copy
import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.operators.boolean_replacer import AddNot
from cosmic_ray.operators.number_replacer import NumberReplacer
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator
from parso.python.tree import Name, Number

CORE = (
    *(f"ReplaceBinaryOperator_{change}" for change in ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul")),
    *(f"ReplaceBinaryOperator_{change}" for change in ("FloorDiv_Div", "Mod_Mul", "Pow_Mul")),
    *(f"ReplaceComparisonOperator_{change}" for change in ("Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt")),
    *(f"ReplaceComparisonOperator_{change}" for change in ("Lt_GtE", "LtE_Gt", "Gt_LtE", "GtE_Lt")),
    *(f"ReplaceComparisonOperator_{change}" for change in ("Eq_NotEq", "NotEq_Eq", "Is_IsNot", "IsNot_Is")),
    *("ReplaceUnaryOperator_Delete_USub", "ReplaceUnaryOperator_Delete_Not"),
    *("ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue"),
    *("ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "ZeroIterationForLoop"),
)
# What a hand confuses: the two ports, ends, directions of a thing.
SIDES = (
    *(("lower", "upper"), ("forward", "backward"), ("extending", "retracting"), ("shortest", "longest")),
    *(("first", "second"), ("older", "newer"), ("slow", "quick"), ("sin", "cos"), ("lowest", "highest")),
)
OTHER_EXTREME = {"min": "max", "max": "min", "abs": ""}
OTHER_SIDE = {**dict(SIDES), **{b: a for a, b in SIDES}}


class Own(Operator):
    """What Cosmic Ray has no operator for."""

    @classmethod
    def examples(cls) -> tuple[()]:
        return ()


class Otherwise(AddNot):
    """The contrary of a condition; that of one comparison is another comparison."""

    def mutation_positions(self, node: Any) -> Iterator[Any]:
        if node.type in ("if_stmt", "while_stmt", "test"):
            condition = node.children[2 if node.type == "test" else 1]
            if condition.type != "not_test" and (
                condition.type != "comparison" or len(condition.children) > 3
            ):
                yield condition.start_pos, condition.end_pos


class Whole(NumberReplacer):
    """One more and one less, of an index, a count and zero."""

    def mutation_positions(self, node: Any) -> Iterator[Any]:
        return super().mutation_positions(node) if not _has_size(node) else iter(())


class Size(Own):
    """Half and double, of a quantity: one more would be far off."""

    def mutation_positions(self, node: Any) -> Iterator[Any]:
        if _has_size(node):
            yield from [(node.start_pos, node.end_pos)] * 2

    def mutate(self, node: Any, index: int) -> Any:
        return Number(repr(float(node.value) * (0.5, 2.0)[index]), node.start_pos, node.prefix)


class Extreme(Own):
    """`min` for `max`, `max` for `min`, the number itself for its `abs`."""

    def mutation_positions(self, node: Any) -> Iterator[Any]:
        if isinstance(node, Name) and node.value in OTHER_EXTREME and _next_text(node).startswith("("):
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        node.value = OTHER_EXTREME[node.value]
        return node


class Side(Own):
    """A field for its counterpart: `lower` for `upper`, `port_1` for `port_2`."""

    def mutation_positions(self, node: Any) -> Iterator[Any]:
        if isinstance(node, Name) and node.parent.type == "trailer" and self._other(node.value):
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        node.value = self._other(node.value)
        return node

    @staticmethod
    def _other(name: str) -> str:
        if match := re.fullmatch(r"(.*_)([12])", name):
            return match[1] + "21"[int(match[2]) - 1]
        return OTHER_SIDE.get(name, "")


class Forget(Own):
    """Nothing for a call whose result is not used, and for an assignment to an object's field."""

    def mutation_positions(self, node: Any) -> Iterator[Any]:
        if node.type == "simple_stmt" and _has_effect(node.children[0]):
            yield node.children[0].start_pos, node.children[0].end_pos

    def mutate(self, node: Any, index: int) -> Any:
        first = node.children[0]
        node.children[0] = Name("pass", first.start_pos, first.get_first_leaf().prefix)
        return node


def _has_size(node: Any) -> bool:
    return isinstance(node, Number) and bool(re.search(r"[.eE]", node.value)) and float(node.value) != 0.0


def _next_text(node: Any) -> str:
    leaf = node.get_next_leaf()
    return leaf.value if leaf is not None else ""


def _has_effect(statement: Any) -> bool:
    if statement.type == "atom_expr":
        return bool(statement.children[-1].get_code().startswith("("))
    return statement.type == "expr_stmt" and statement.children[0].type == "atom_expr"


def _function(node: Any) -> str:
    """Return the dotted name of what a node stands in; "" at the module's top."""
    names: list[str] = []
    while node is not None:
        if node.type in ("funcdef", "classdef"):
            names.insert(0, node.name.value)
        node = node.parent
    return ".".join(names)


def _mutated(source: str, operator: Operator, node: Any, index: int) -> str:
    """Return the source with one node changed; Cosmic Ray itself would parse it anew."""
    first, last = _offset(source, node.get_start_pos_of_prefix()), _offset(source, node.end_pos)
    own = copy.deepcopy(node, {id(node.parent): node.parent})
    return source[:first] + str(operator.mutate(own, index).get_code()) + source[last:]


def _offset(source: str, position: tuple[int, int]) -> int:
    return sum(map(len, source.splitlines(keepends=True)[: position[0] - 1])) + position[1]


def _lines(source: str, mutated: str, start: tuple[int, int], end: tuple[int, int]) -> tuple[str, str]:
    """Return the changed line, and the same with old and new text between « and »."""
    lines = source.splitlines(keepends=True)
    first, last = _offset(source, start), _offset(source, end)
    old, new = source[first:last], mutated[first : len(mutated) - (len(source) - last)].strip()
    head, tail = lines[start[0] - 1][: start[1]], lines[end[0] - 1][end[1] :].split("  #")[0]
    return " ".join(f"{head}{old}{tail}".split()), " ".join(
        f"{head}«{old} → {new or 'nothing'}»{tail}".split()
    )


def mutants(path: str) -> Iterator[dict[str, Any]]:
    """Yield the mutants of a module, no two of the same meaning."""
    head, keys = "", Counter[tuple[str, str]]()
    statements = [child.get_code() for child in get_ast(Path(path).read_text("utf-8")).children]
    for number, statement in enumerate(statements):
        tail = "".join(statements[number + 1 :])
        for mutant in _of_statement(statement, head.count("\n")):
            keys[mutant["function"], mutant["key"]] += 1  # the same line may stand twice in a function
            again = keys[mutant["function"], mutant["key"]]
            mutant["key"] += f"  #{again}" if again > 1 else ""
            yield {**mutant, "source": path, "text": head + mutant["text"] + tail}
        head += statement


def _of_statement(source: str, above: int) -> Iterator[dict[str, Any]]:
    """Yield the mutants of one of a module's statements, which stands below so many lines."""
    seen, nodes = {ast.dump(ast.parse(source))}, [*ast_nodes(get_ast(source))]
    operators = [get_operator(f"core/{name}")() for name in CORE]
    for operator in (*operators, Otherwise(), Whole(), Size(), Extreme(), Side(), Forget()):
        places = [(n, i, *at) for n in nodes for i, at in enumerate(operator.mutation_positions(n))]
        for node, index, start, end in places:
            mutated = _mutated(source, operator, node, index)
            try:
                meaning = ast.dump(ast.parse(mutated))
            except SyntaxError:
                continue
            if meaning in seen:
                continue
            seen.add(meaning)
            original, key = _lines(source, mutated, start, end)
            place = {"function": _function(node), "line": above + start[0], "key": key, "original": original}
            yield {**place, "text": mutated}


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        for mutant in mutants(argument):
            print(json.dumps(mutant))
