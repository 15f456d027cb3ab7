"""Statements of the laws, and their calls of each other, in LLVM's text.

Where branches meet, and where a loop begins, each variable that may have come by several ways becomes one
(LLVM's phi). A variable lives on after a branch or a loop if every way there gives it a value.
"""

import ast
import inspect
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Protocol

from forest_compile.llvm_text import (
    DOUBLE,
    TRUTH,
    WHOLE,
    Function,
    Row,
    Scalar,
    Stored,
    Value,
    rebuilt,
    scalars,
)
from forest_compile.translate_expressions import Expressions, Frame
from forest_compile.translate_numbers import NotTranslatedError

Variables = dict[str, Value]


class Apart(Protocol):
    """Who knows the functions that are not written out where they are called."""

    def is_apart(self, function: FunctionType) -> bool:
        """Tell whether calls of a function stay calls."""

    def function(self, function: FunctionType, arguments: list[Value]) -> tuple[str, list[str], Value]:
        """Return name, kinds of results and result of a function that stays one, for such arguments."""


@lru_cache(maxsize=1024)
def source(function: FunctionType) -> ast.FunctionDef:
    """Return a function's syntax tree."""
    for node in _module(inspect.getfile(function)).body:
        if isinstance(node, ast.FunctionDef) and node.name == function.__name__:
            return node
    raise NotTranslatedError(f"{function.__qualname__} is no function of a module")


@lru_cache(maxsize=64)
def _module(path: str) -> ast.Module:
    return ast.parse(Path(path).read_text(encoding="utf-8"))


class Statements(Expressions):
    """Writes statements into a function."""

    def __init__(self, into: Function, library: Apart) -> None:
        super().__init__(into)
        self._library = library

    def call(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a function of the laws gives, written out or by a call."""
        if not self._library.is_apart(function):
            return self.written_out(function, arguments)
        arguments = [a if isinstance(a, Stored) else self.into.taken(a) for a in arguments]
        name, results, shape = self._library.function(function, arguments)
        given: list[str] = []
        for argument in arguments:
            if isinstance(argument, Stored):
                given.append(f"ptr {self.into.element(argument.row, argument.offset).text}")
            else:
                given += [f"{number.kind} {number.text}" for number in scalars(argument)]
        whole = "{ " + ", ".join(results) + " }"
        together = self.into.emit(whole, f"call {whole} @{name}({', '.join(given)})").text
        numbers = (
            self.into.emit(kind, f"extractvalue {whole} {together}, {k}") for k, kind in enumerate(results)
        )
        return rebuilt(shape, numbers)

    def written_out(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a function of the laws gives, its statements written here."""
        node = source(function)
        names = [argument.arg for argument in node.args.args]
        frame = Frame(dict(zip(names, arguments, strict=True)), function.__globals__)
        try:
            self.run(node.body, frame)
        except NotTranslatedError as error:
            raise NotTranslatedError(f"{function.__module__}.{function.__name__}: {error}") from error
        if len(frame.returns) == 1:
            (block, value), *_ = frame.returns
            self.into.start(block)
            return value
        end = self.into.label()
        for block, _ in frame.returns:
            self.into.end(f"br label %{end}", block)
        self.into.start(end)
        return self.into.joined(frame.returns)

    def run(self, body: list[ast.stmt], frame: Frame) -> None:
        """Write statements, up to one that leaves."""
        for node in body:
            if not self.into.open:
                return
            method = getattr(self, f"_do_{type(node).__name__.lower()}", None)
            if method is None:
                raise NotTranslatedError(f"line {node.lineno}: {type(node).__name__} is not translated")
            method(node, frame)

    def _do_expr(self, node: ast.Expr, _: Frame) -> None:
        if not isinstance(node.value, ast.Constant):
            raise NotTranslatedError(f"line {node.lineno}: an expression without use is not translated")

    def _do_assign(self, node: ast.Assign, frame: Frame) -> None:
        value = self.value(node.value, frame)
        for target in node.targets:
            self._assign(target, value, frame)

    def _assign(self, target: ast.expr, value: Value, frame: Frame) -> None:
        if isinstance(target, ast.Name):
            frame.variables[target.id] = value
        elif isinstance(target, ast.Tuple):
            for i, item in enumerate(target.elts):
                self._assign(item, self.into.member(value, i), frame)
        elif isinstance(target, ast.Subscript):
            row, index = self.value(target.value, frame), self.number(target.slice, frame)
            if not (isinstance(row, Row) and isinstance(value, Scalar)):
                raise NotTranslatedError(f"{ast.unparse(target)!r}: only rows take numbers")
            at = self.into.element(row.text, index)
            number = self.into.converted(value, DOUBLE)
            self.into.do(f"store double {number.text}, ptr {at.text}, align 8")
        else:
            raise NotTranslatedError(f"{ast.unparse(target)!r} is not assigned to")

    def _do_augassign(self, node: ast.AugAssign, frame: Frame) -> None:
        before = self.number(node.target, frame)
        after = self.operation(node.op, before, self.number(node.value, frame))
        self._assign(node.target, after, frame)

    def _do_return(self, node: ast.Return, frame: Frame) -> None:
        if node.value is None:
            raise NotTranslatedError(f"line {node.lineno}: a return without value is not translated")
        value = self.value(node.value, frame)
        frame.returns.append((self.into.block, value))
        self.into.open = False

    def _do_break(self, _: ast.Break, frame: Frame) -> None:
        frame.breaks[-1].append((self.into.block, dict(frame.variables)))
        self.into.open = False

    def _do_continue(self, _: ast.Continue, frame: Frame) -> None:
        frame.continues[-1].append((self.into.block, dict(frame.variables)))
        self.into.open = False

    def _do_if(self, node: ast.If, frame: Frame) -> None:
        into, before = self.into, frame.variables
        yes, no = into.label(), into.label()
        self.jump_if(node.test, frame, yes, no)
        arrivals = []
        for label, body in ((yes, node.body), (no, node.orelse)):
            into.start(label)
            frame.variables = dict(before)
            self.run(body, frame)
            if into.open:
                arrivals.append((into.block, frame.variables))
        self._meet(arrivals, frame)

    def _meet(self, arrivals: list[tuple[str, Variables]], frame: Frame) -> None:
        """Go on where several blocks lead, with the variables that all have."""
        into = self.into
        if not arrivals:
            into.open = False
            return
        if len(arrivals) == 1:
            (block, frame.variables), *_ = arrivals
            into.start(block)
            return
        end = into.label()
        for block, _ in arrivals:
            into.end(f"br label %{end}", block)
        into.start(end)
        common = set.intersection(*(set(variables) for _, variables in arrivals))
        frame.variables = {
            name: into.joined([(block, variables[name]) for block, variables in arrivals])
            for name in arrivals[0][1]
            if name in common
        }

    def _do_while(self, node: ast.While, frame: Frame) -> None:
        self._loop(node, frame, {}, lambda yes, no: self.jump_if(node.test, frame, yes, no), dict)

    def _do_for(self, node: ast.For, frame: Frame) -> None:
        call = node.iter
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"):
            raise NotTranslatedError(f"line {node.lineno}: only ranges are gone through")
        if not isinstance(node.target, ast.Name):
            raise NotTranslatedError(f"line {node.lineno}: {ast.unparse(node.target)!r} is no counter")
        numbers = [self.number(item, frame) for item in call.args]
        zero, one = Scalar(WHOLE, "0"), Scalar(WHOLE, "1")
        first, end, stride = {1: (zero, *numbers, one), 2: (*numbers, one), 3: (*numbers,)}[len(numbers)]
        counter = node.target.id + "'"  # no name of Python's, so that the body cannot change it
        into, target = self.into, node.target.id

        def test(yes: str, no: str) -> None:
            order = "sgt" if stride.text.startswith("-") else "slt"
            at = frame.variables[counter]
            frame.variables[target] = at
            here = next(scalars(at)).text
            into.branch(into.emit(TRUTH, f"icmp {order} i64 {here}, {end.text}"), yes, no)

        def advance() -> Variables:
            here = next(scalars(frame.variables[counter])).text
            return {counter: into.emit(WHOLE, f"add i64 {here}, {stride.text}")}

        self._loop(node, frame, {counter: first}, test, advance)

    def _loop(
        self,
        node: ast.While | ast.For,
        frame: Frame,
        counters: Variables,
        test: Callable[[str, str], None],
        advance: Callable[[], Variables],
    ) -> None:
        into, before = self.into, self.into.block
        changed = {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        head, body, done = into.label(), into.label(), into.label()
        into.jump(head)
        into.start(head)
        frame.variables = dict(frame.variables) | counters
        closing = {}
        for name, value in list(frame.variables.items()):
            if name in changed or name in counters:
                frame.variables[name], closing[name] = into.repeated(value, before)
        test(body, done)
        arrivals = [(done, frame.variables)]
        into.start(done)
        into.start(body)
        frame.breaks.append([])
        frame.continues.append([])
        frame.variables = dict(frame.variables)
        self.run(node.body, frame)
        ends = [(into.block, frame.variables)] if into.open else []
        self._meet(ends + frame.continues.pop(), frame)
        if not into.open:
            raise NotTranslatedError(f"line {node.lineno}: a loop that never goes round is not translated")
        frame.variables = dict(frame.variables) | advance()
        for name, close in closing.items():
            close(into.block, frame.variables[name])
        into.jump(head)
        self._meet(arrivals + frame.breaks.pop(), frame)
