"""The laws, which are ordinary Python, as LLVM's text: one function that takes rows of doubles.

The subset:

- functions of numbers and nested tuples of numbers, without effects;
- assignment, `if`, `for` over a range, `while`, `break`, `else`, `return`;
- calls by position and by keyword, defaults, NamedTuples and their `_replace`, but no `*` or `**`;
- arithmetic, comparison, and the functions in `translate_numbers`, where also stands what becomes of Python's
  errors.

All else is refused (`NotTranslatedError`), with function, file and line.
A variable is of one kind on every way: double, whole number, truth, or a tuple of one type.
One that is not may not be used. Names outside of functions mean what they meant when the text was written.
A square is the C library's power, as in Python; a product is faster.
Each call is written out where it stands, so that LLVM sees the plant in one piece, except of functions that
are named as seldom called or large: those stay functions. `benchmarks/compilers.py` measures this against a
compiler for much more of Python (Numba).
"""

import ast
from collections.abc import Callable, Collection, Iterator, Mapping
from types import CodeType, FunctionType
from typing import Any

from forest_compile import fingerprint, llvm_text
from forest_compile.entry import Entry
from forest_compile.flat_layout import leaves
from forest_compile.llvm_text import (
    DOUBLE,
    POINTER,
    WHOLE,
    Function,
    NotTranslatedError,
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
from forest_compile.translate_numbers import ONE_ARGUMENT, TWO_ARGUMENTS
from forest_compile.translate_statements import Statements, Variables
from forest_compile.translate_whole import require_whole

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
        self._faults: dict[str, str] = {}
        self.under_way: list[FunctionType] = []

    def text(self) -> Iterator[str]:
        """Yield all lines."""
        for names, given in ((ONE_ARGUMENT, "double"), (TWO_ARGUMENTS, "double, double")):
            for name in sorted(set(names.values())):
                yield f"declare double @{name}({given}) #{2 if name == 'pow' else 0}"
        for text, name in self._faults.items():
            code = text.encode()
            plain = "".join(chr(b) if 31 < b < 127 and b not in b'"\\' else f"\\{b:02x}" for b in code)
            yield f'{name} = private unnamed_addr constant [{len(code) + 1} x i8] c"{plain}\\00"'
        yield from self._lines
        yield "attributes #0 = { nounwind willreturn speculatable memory(none) }"
        yield "attributes #1 = { nounwind noinline }"
        yield '!0 = !{!"branch_weights", i32 1000000, i32 1}'  # of what a fault leaves aside
        # Not for LLVM to replace: its root for a power of 0.5 is another last bit than CPython's.
        yield "attributes #2 = { nounwind willreturn speculatable memory(none) nobuiltin }"

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
        """Add the function that the world calls: it returns null, or the text of a fault.

        Args:
            name: of it.
            text: its source in Python; it returns nothing.
            names: what names in the source mean.
            arguments: a letter for each: p pointer to doubles, d double, i whole number.
            views: names of tuples that lie flat in an argument: the argument's name, and an example.
            copies: the same, of arguments that the function writes to.
            fixed: numbers that LLVM may take for granted: an argument's name, and where in it.
        """
        (node,), (code, *_) = ast.parse(text).body, compile(text, name, "exec").co_consts
        if not (isinstance(node, ast.FunctionDef) and isinstance(code, CodeType)):
            raise NotTranslatedError("the entry's source is no function", name)
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
        for view, (under, example) in (*views.items(), *copies.items()):
            for at, (path, leaf) in enumerate(leaves(example, view)):
                if isinstance(leaf, int):  # or a truth
                    require_whole(into, f"%{under}", at, f"{name}: {path}", isinstance(leaf, bool))
        Statements(into, self).entry(node, Frame(variables, names, name, code))
        into.end("ret ptr null")
        if into.faults:
            into.end(f"ret ptr {into.fault(self._fault).text}")
        self._lines += [f"define ptr @{name}({', '.join(kinds)}) nounwind {{", *into.text(), "}"]

    def _fault(self, text: str) -> str:
        """Return a fault's name in the module."""
        return self._faults.setdefault(text, f"@fault.{len(self._faults)}")

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
        if into.faults:
            results.append(POINTER)
            numbers.append(Scalar(POINTER, "null"))
        whole = "{ " + ", ".join(results) + " }"
        built = "undef"
        for k, number in enumerate(numbers):
            text = f"insertvalue {whole} {built}, {number.kind} {number.text}, {k}"
            built = into.emit(whole, text).text
        into.end(f"ret {whole} {built}")
        if into.faults:
            fault, last = into.fault(self._fault).text, len(results) - 1
            text = f"insertvalue {whole} zeroinitializer, ptr {fault}, {last}"
            into.end(f"ret {whole} {into.emit(whole, text).text}")
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
