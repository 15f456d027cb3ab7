"""Statements of the laws, and their calls of each other, in LLVM's text.

Where branches meet, and where a loop begins, each variable that may have come by several ways becomes one
(LLVM's phi). A variable lives on after a branch or a loop if every way there gives it a value of one kind.
"""

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Protocol

from forest_compile.llvm_text import (
    POINTER,
    TRUTH,
    WHOLE,
    Function,
    NotTranslatedError,
    Record,
    Row,
    Scalar,
    Stored,
    Value,
    known,
    number,
    rebuilt,
    scalars,
)
from forest_compile.translate_expressions import Expressions, Frame
from forest_compile.translate_whole import ZERO

Variables = dict[str, Value]


class Apart(Protocol):
    """Who knows the functions that are not written out where they are called."""

    under_way: list[FunctionType]
    """Functions that are being written, each called by the one before it."""

    def is_apart(self, function: FunctionType) -> bool:
        """Tell whether calls of a function stay calls."""

    def function(self, function: FunctionType, arguments: list[Value]) -> tuple[str, list[str], Value]:
        """Return name, kinds of results and result of a function that stays one, for such arguments."""


@lru_cache(maxsize=1024)
def source(function: FunctionType) -> ast.FunctionDef:
    """Return a function's syntax tree.

    Raises:
        NotTranslatedError: it does not stand by itself in a module, as it stands.
    """
    code = function.__code__
    for node in _module(code.co_filename).body:
        if isinstance(node, ast.FunctionDef) and code.co_firstlineno in _first_lines(node):
            if node.decorator_list:
                raise NotTranslatedError("a decorated function is not translated")
            if node.name == code.co_name:
                return node
    raise NotTranslatedError("only functions that a module defines by themselves are translated")


def _first_lines(node: ast.FunctionDef) -> set[int]:
    return {node.lineno, *(decorator.lineno for decorator in node.decorator_list)}


@lru_cache(maxsize=64)
def _module(path: str) -> ast.Module:
    try:
        return ast.parse(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise NotTranslatedError("its source is no file that can be read") from error


class Statements(Expressions):
    """Writes statements into a function."""

    def __init__(self, into: Function, library: Apart) -> None:
        super().__init__(into)
        self._library = library

    def call(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a function of the laws gives, written out or by a call."""
        if function in self._library.under_way:
            raise NotTranslatedError(f"{function.__qualname__!r} calls itself")
        if not self._library.is_apart(function):
            return self.written_out(function, arguments)
        arguments = [a if isinstance(a, Stored) else self.settled_all(self.into.taken(a)) for a in arguments]
        name, results, shape = self._library.function(function, arguments)
        given: list[str] = []
        for argument in arguments:
            if isinstance(argument, Stored):
                given.append(f"ptr {self.into.element(argument.row, argument.offset).text}")
            else:
                given += [f"{number.kind} {number.text}" for number in scalars(argument)]
        whole = "{ " + ", ".join(results) + " }"
        together = self.into.emit(whole, f"call {whole} @{name}({', '.join(given)})").text
        numbers = [
            self.into.emit(kind, f"extractvalue {whole} {together}, {k}") for k, kind in enumerate(results)
        ]
        if results[-1:] == [POINTER]:
            fault = numbers.pop()
            self.into.require(self.into.emit(TRUTH, f"icmp eq ptr {fault.text}, null"), fault)
        return rebuilt(shape, iter(numbers))

    def settled_all(self, value: Value) -> Value:
        """Return a value once all whole numbers in it are known to be no larger than they may."""
        if isinstance(value, Record):
            return Record(value.sort, tuple(self.settled_all(item) for item in value.items))
        return self.settled(value) if isinstance(value, Scalar) else value

    def written_out(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a function of the laws gives, its statements written here.

        Raises:
            NotTranslatedError: something in it is outside the subset; the error tells the place.
        """
        name = f"{function.__module__}.{function.__qualname__}"
        frame = Frame({}, function.__globals__, name, function.__code__)
        self._library.under_way.append(function)
        with self._inside(frame):
            node = source(function)
            given = *node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs
            frame.variables = dict(zip((argument.arg for argument in given), arguments, strict=True))
            self.run(node.body, frame)
            result = self._returned(frame)
        self._library.under_way.pop()
        return result

    def entry(self, node: ast.FunctionDef, frame: Frame) -> None:
        """Write a function that returns nothing."""
        with self._inside(frame):
            self.run(node.body, frame)

    @contextmanager
    def _inside(self, frame: Frame) -> Iterator[None]:
        """Give what is refused meanwhile its place, and whatever else fails, too."""
        outside = getattr(self, "frame", frame)
        self.frame = frame
        try:
            yield
        except NotTranslatedError as error:
            if error.place:
                raise
            raise NotTranslatedError(error.message, frame.place()) from error
        except Exception as error:
            raise NotTranslatedError(f"not translated, for {error!r}", frame.place()) from error
        finally:
            self.frame = outside

    def _returned(self, frame: Frame) -> Value:
        """Return what a function gives whose statements are written, and go on after it."""
        into = self.into
        if into.open or not frame.returns:
            raise NotTranslatedError("a way through the function that returns nothing is not translated")
        if len(frame.returns) == 1:
            (block, value), *_ = frame.returns
            into.start(block)
            return value
        end = into.label()
        for block, _ in frame.returns:
            into.end(f"br label %{end}", block)
        into.start(end)
        return into.joined(frame.returns)

    def run(self, body: list[ast.stmt], frame: Frame) -> None:
        """Write statements, up to one that leaves."""
        for node in body:
            if not self.into.open:
                return
            frame.line = node.lineno
            method = getattr(self, f"_do_{type(node).__name__.lower()}", None)
            if method is None:
                raise NotTranslatedError(f"{type(node).__name__} is not translated")
            method(node, frame)

    def _do_expr(self, node: ast.Expr, _: Frame) -> None:
        if not isinstance(node.value, ast.Constant):
            raise NotTranslatedError("an expression without use is not translated")

    def _do_assign(self, node: ast.Assign, frame: Frame) -> None:
        value = self.value(node.value, frame)
        for target in node.targets:
            self._assign(target, value, frame)

    def _assign(self, target: ast.expr, value: Value, frame: Frame) -> None:
        if isinstance(target, ast.Name):
            frame.variables[target.id] = value
        elif isinstance(target, ast.Tuple):
            items = self.into.items(value)
            if len(items) != len(target.elts):
                raise NotTranslatedError(f"{ast.unparse(target)!r} is given a tuple of {len(items)}")
            for part, item in zip(target.elts, items, strict=True):
                self._assign(part, item, frame)
        elif isinstance(target, ast.Subscript):
            row, index = self.value(target.value, frame), self.whole(self.number(target.slice, frame))
            if not (isinstance(row, Row) and isinstance(value, Scalar)):
                raise NotTranslatedError(f"{ast.unparse(target)!r}: only rows take numbers")
            at = self.into.element(row.text, self.row_index(index))
            stored = self._double(value)
            self.into.do(f"store double {stored.text}, ptr {at.text}, align 8")
        else:
            raise NotTranslatedError(f"{ast.unparse(target)!r} is not assigned to")

    def _do_augassign(self, node: ast.AugAssign, frame: Frame) -> None:
        before = self.number(node.target, frame)
        after = self.operation(node.op, before, self.number(node.value, frame))
        self._assign(node.target, after, frame)

    def _do_return(self, node: ast.Return, frame: Frame) -> None:
        if node.value is None:
            raise NotTranslatedError("a return without value is not translated")
        value = self.settled_all(self.value(node.value, frame))
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
        """Go on where several blocks lead, with the variables that all have, and of one kind."""
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
        frame.variables = {}
        for name in arrivals[0][1]:
            if name in common:
                with suppress(NotTranslatedError):  # an error where it is used: `Expressions._known`
                    frame.variables[name] = into.joined([(block, held[name]) for block, held in arrivals])

    def _do_while(self, node: ast.While, frame: Frame) -> None:
        self._loop(node, frame, {}, lambda yes, no: self.jump_if(node.test, frame, yes, no), dict, dict)

    def _do_for(self, node: ast.For, frame: Frame) -> None:
        call = node.iter
        if not (isinstance(call, ast.Call) and self.means(call.func, frame, range)):
            raise NotTranslatedError("only ranges are gone through")
        if not isinstance(node.target, ast.Name) or call.keywords:
            raise NotTranslatedError(f"{ast.unparse(node.target)!r} is no counter, or the range is none")
        numbers = [self.settled(self.whole(self.number(item, frame))) for item in call.args]
        first, end, stride = self._range(numbers)
        counter = node.target.id + "'"  # no name of Python's, so that the body cannot change it
        into, target = self.into, node.target.id

        def here() -> Scalar:
            (at,) = scalars(frame.variables[counter])
            return at

        def test(yes: str, no: str) -> None:
            upwards = into.emit(TRUTH, f"icmp slt i64 {here().text}, {end.text}")
            downwards = into.emit(TRUTH, f"icmp sgt i64 {here().text}, {end.text}")
            up = into.emit(TRUTH, f"icmp sgt i64 {stride.text}, 0")
            text = f"select i1 {up.text}, i1 {upwards.text}, i1 {downwards.text}"
            into.branch(into.emit(TRUTH, text), yes, no)

        def advance() -> Variables:
            return {counter: into.emit(WHOLE, f"add nsw i64 {here().text}, {stride.text}")}

        self._loop(node, frame, {counter: first}, test, lambda: {target: here()}, advance)

    def _range(self, numbers: list[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """Return first number, end and stride of a range."""
        if len(numbers) not in (1, 2, 3):
            raise NotTranslatedError(f"a range of {len(numbers)} numbers is none")
        first, end = (ZERO, *numbers) if len(numbers) == 1 else numbers[:2]
        stride = numbers[2] if len(numbers) == 3 else number(1)
        if known(stride) == 0:
            raise NotTranslatedError("a range's stride is zero")
        if known(stride) is None:
            self.require(self.into.emit(TRUTH, f"icmp ne i64 {stride.text}, 0"), "a range's stride is zero")
        return first, end, stride

    def _loop(
        self,
        node: ast.While | ast.For,
        frame: Frame,
        counters: Variables,
        test: Callable[[str, str], None],
        begin: Callable[[], Variables],
        advance: Callable[[], Variables],
    ) -> None:
        """Write a loop.

        Args:
            node: the loop.
            frame: the function's.
            counters: variables that nobody sees, as they are before it.
            test: writes what decides between two labels, another round and the end.
            begin: returns variables that a round begins with.
            advance: returns the counters after a round.
        """
        into = self.into
        changed = {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        frame.variables = dict(frame.variables)
        for name in sorted(changed & set(frame.variables)):
            frame.variables[name] = self.settled_all(frame.variables[name])
        before = into.block
        head, body, done = into.label(), into.label(), into.label()
        into.jump(head)
        into.start(head)
        frame.variables = dict(frame.variables) | counters
        closing = {}
        for name, value in list(frame.variables.items()):
            if name in changed or name in counters:
                frame.variables[name], closing[name] = into.repeated(value, before)
        test(body, done)
        outside = {name: value for name, value in frame.variables.items() if name not in counters}
        into.start(body)
        frame.breaks.append([])
        frame.continues.append([])
        frame.variables = frame.variables | begin()
        self.run(node.body, frame)
        ends = [(into.block, frame.variables)] if into.open else []
        self._meet(ends + frame.continues.pop(), frame)
        if not into.open:
            raise NotTranslatedError("a loop that never goes round is not translated")
        frame.line = node.lineno
        frame.variables = frame.variables | advance()
        for name in closing:
            if name not in frame.variables:
                raise NotTranslatedError(f"a loop makes something of another kind of {name!r}")
            frame.variables[name] = self.settled_all(frame.variables[name])
        for name, close in closing.items():
            close(into.block, frame.variables[name])
        into.jump(head)
        self._meet(self._else(node, done, outside, frame) + frame.breaks.pop(), frame)

    def _else(
        self, node: ast.While | ast.For, done: str, outside: Variables, frame: Frame
    ) -> list[tuple[str, Variables]]:
        """Write what is done after a loop that nothing broke off; return how that ends."""
        self.into.start(done)
        frame.variables = dict(outside)
        self.run(node.orelse, frame)
        return [(self.into.block, frame.variables)] if self.into.open else []
