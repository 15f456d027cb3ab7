"""The laws, which are ordinary Python, as LLVM's text: one function that takes rows of doubles.

The subset: functions of numbers and nested tuples of numbers, without effects; assignment, `if`, `for` over a
range, `while`, `break`, `return`; arithmetic, comparison, and the functions in `translate_numbers`.
Each call is written out where it stands, so that LLVM sees the plant in one piece, except of functions that
are named as seldom called or large: those stay functions. `benchmarks/compilers.py` measures this against a
compiler for much more of Python (Numba).
"""

import ast
from collections.abc import Callable, Collection, Iterator, Mapping
from types import FunctionType
from typing import Any

from forest_compile import fingerprint, llvm_text
from forest_compile.entry import Entry
from forest_compile.llvm_text import (
    DOUBLE,
    WHOLE,
    Function,
    Record,
    Row,
    Scalar,
    Stored,
    Value,
    rebuilt,
    scalars,
    size,
)
from forest_compile.machine_code import ENTRY
from forest_compile.translate_expressions import Frame
from forest_compile.translate_numbers import ONE_ARGUMENT, TWO_ARGUMENTS, NotTranslatedError
from forest_compile.translate_statements import Statements, Variables

KINDS = {"p": "ptr noalias", "d": DOUBLE, "i": WHOLE}


def text(entry: Entry) -> str:
    """Return an entry as LLVM's text.

    Raises:
        NotTranslatedError: something in it, or in the laws that it calls, is outside the subset; or a law's
            file does not say what was imported.
    """
    for function in fingerprint.changed(entry):
        raise NotTranslatedError(
            f"{function.__module__}.{function.__qualname__}: {function.__code__.co_filename} was changed "
            "after it was imported; start again"
        )
    library = Library(entry.apart)
    fixed = {place: llvm_text.number(value) for place, value in entry.fixed.items()}
    library.entry(ENTRY, entry.text, dict(entry.names), entry.arguments, entry.views, entry.copies, fixed)
    return "\n".join(library.text())


class Library:
    """The functions that stay functions, and the text of all."""

    def __init__(self, apart: Collection[Callable[..., Any]]) -> None:
        """Keep these functions apart."""
        self._apart = apart
        self._known: dict[Any, tuple[str, list[str], Value]] = {}
        self._lines: list[str] = []

    def text(self) -> Iterator[str]:
        """Yield all lines."""
        for names, given in ((ONE_ARGUMENT, "double"), (TWO_ARGUMENTS, "double, double")):
            for name in sorted(set(names.values())):
                yield f"declare double @{name}({given}) #0"
        yield from self._lines
        yield "attributes #0 = { nounwind willreturn speculatable memory(none) }"
        yield "attributes #1 = { nounwind noinline }"

    def entry(
        self,
        name: str,
        text: str,
        names: dict[str, Any],
        arguments: str,
        views: Mapping[str, tuple[str, Any]],
        copies: Mapping[str, tuple[str, Any]],
        fixed: Mapping[tuple[str, int], Scalar] | None = None,
    ) -> None:
        """Add the function that the world calls.

        Args:
            name: of it.
            text: its source in Python; it returns nothing.
            names: what names in the source mean.
            arguments: a letter for each: p pointer to doubles, d double, i whole number.
            views: names of tuples that lie flat in an argument: the argument's name, and an example.
            copies: the same, of arguments that the function writes to.
            fixed: numbers that LLVM may take for granted: an argument's name, and where in it.
        """
        (node,) = ast.parse(text).body
        if not isinstance(node, ast.FunctionDef):
            raise NotTranslatedError("the entry's source is no function")
        known = {(f"%{argument}", at): number for (argument, at), number in (fixed or {}).items()}
        into, kinds = Function(known), []
        variables: Variables = {}
        for letter, argument in zip(arguments, [a.arg for a in node.args.args], strict=True):
            register = f"%{argument}"
            seen = [example for under, example in (*views.values(), *copies.values()) if under == argument]
            behind = f"dereferenceable({8 * size(seen[0])}) align 8 " if seen else ""
            kinds.append(f"{KINDS[letter]} {behind}{register}")
            variables[argument] = Row(register) if letter == "p" else Scalar(KINDS[letter], register)
        for view, (under, example) in views.items():
            variables[view] = Stored(example, f"%{under}", 0)
        for copy, (under, example) in copies.items():
            variables[copy] = into.taken(Stored(example, f"%{under}", 0))
        Statements(into, self).run(node.body, Frame(variables, names))
        into.end("ret void")
        self._lines += [f"define void @{name}({', '.join(kinds)}) nounwind {{", *into.text(), "}"]

    def is_apart(self, function: FunctionType) -> bool:
        """Tell whether calls of a function stay calls."""
        return function in self._apart

    def function(self, function: FunctionType, arguments: list[Value]) -> tuple[str, list[str], Value]:
        """Return name, kinds of results and result of a function that stays one, for such arguments."""
        key = function, tuple(_shape(argument) for argument in arguments)
        if key not in self._known:
            self._known[key] = self._define(function, arguments)
        return self._known[key]

    def _define(self, function: FunctionType, arguments: list[Value]) -> tuple[str, list[str], Value]:
        into, kinds = Function(), []
        inner: list[Value] = []
        for i, argument in enumerate(arguments):
            if isinstance(argument, Stored):
                kinds.append(
                    f"ptr noalias readonly dereferenceable({8 * size(argument.example)}) align 8 %a{i}"
                )
                inner.append(Stored(argument.example, f"%a{i}", 0))
                continue
            given = [Scalar(number.kind, f"%a{i}_{k}") for k, number in enumerate(scalars(argument))]
            kinds += [f"{number.kind} {number.text}" for number in given]
            inner.append(rebuilt(argument, iter(given)))
        result = into.taken(Statements(into, self).written_out(function, inner))
        numbers = list(scalars(result))
        results = [number.kind for number in numbers]
        whole = "{ " + ", ".join(results) + " }"
        built = "undef"
        for k, number in enumerate(numbers):
            text = f"insertvalue {whole} {built}, {number.kind} {number.text}, {k}"
            built = into.emit(whole, text).text
        into.end(f"ret {whole} {built}")
        name = f"{function.__name__}.{len(self._known)}.{len(self._lines)}"
        head = f"define internal {whole} @{name}({', '.join(kinds)}) #1 {{"
        self._lines += [head, *into.text(), "}"]
        return name, results, result


def _shape(value: Any) -> Any:
    """Return what of a value, or of a stored tuple's example, decides how a function of it is written."""
    if isinstance(value, Scalar):
        return value.kind
    if isinstance(value, Record):
        return value.sort, tuple(_shape(item) for item in value.items)
    if isinstance(value, Stored):
        return Stored, _shape(value.example)
    return (type(value), *map(_shape, value)) if isinstance(value, tuple) else type(value)
