"""Expressions of the laws in LLVM's text: numbers, tuples, comparisons, and calls of known functions.

Python's meaning is kept to the last bit, but for errors: a quotient by zero is infinite, a root of a negative
number no number. What is not in the subset is refused by name.
"""

import ast
import builtins
import math
from collections.abc import Callable
from types import FunctionType
from typing import Any

from forest_sim.llvm_text import (
    DOUBLE,
    TRUTH,
    WHOLE,
    Function,
    Record,
    Row,
    Scalar,
    Stored,
    Value,
    constant,
    size,
)

TRUE, FALSE = Scalar(TRUTH, "true"), Scalar(TRUTH, "false")
ONE_ARGUMENT: dict[Any, str] = {
    math.sqrt: "llvm.sqrt.f64",
    abs: "llvm.fabs.f64",
    math.fabs: "llvm.fabs.f64",
    math.sin: "sin",
    math.cos: "cos",
    math.exp: "exp",
}
TWO_ARGUMENTS: dict[Any, str] = {math.copysign: "llvm.copysign.f64"}
EXTERNAL = {**ONE_ARGUMENT, **TWO_ARGUMENTS}
_ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("fadd", "add"),
    ast.Sub: ("fsub", "sub"),
    ast.Mult: ("fmul", "mul"),
}
_COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("olt", "slt"),
    ast.LtE: ("ole", "sle"),
    ast.Gt: ("ogt", "sgt"),
    ast.GtE: ("oge", "sge"),
    ast.Eq: ("oeq", "eq"),
    ast.NotEq: ("une", "ne"),
}


class NotTranslatedError(TypeError):
    """Something in the laws is outside the subset: the message tells what and where."""


class Frame:
    """One call of a function: its variables, and what names mean outside it."""

    def __init__(self, variables: dict[str, Value], names: dict[str, Any]) -> None:
        self.variables, self.names = variables, names
        self.returns: list[tuple[str, Value]] = []
        self.breaks: list[list[tuple[str, dict[str, Value]]]] = []


class Expressions:
    """Writes expressions into a function."""

    def __init__(self, into: Function) -> None:
        self.into = into

    def value(self, node: ast.expr, frame: Frame) -> Value:
        """Return what an expression gives."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise NotTranslatedError(f"{ast.unparse(node)!r}: {type(node).__name__} is not translated")
        result: Value = method(node, frame)
        return result

    def number(self, node: ast.expr, frame: Frame) -> Scalar:
        """Return what an expression gives, which must be a number."""
        value = self.value(node, frame)
        if not isinstance(value, Scalar):
            raise NotTranslatedError(f"{ast.unparse(node)!r} is no number")
        return value

    def call(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a function of the laws gives."""
        raise NotImplementedError

    def jump_if(self, node: ast.expr, frame: Frame, yes: str, no: str) -> None:
        """Go on at one label or the other, looking only at what decides."""
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            self.jump_if(node.operand, frame, no, yes)
        elif isinstance(node, ast.BoolOp):
            for part in node.values[:-1]:
                further = self.into.label()
                if isinstance(node.op, ast.And):
                    self.jump_if(part, frame, further, no)
                else:
                    self.jump_if(part, frame, yes, further)
                self.into.start(further)
            self.jump_if(node.values[-1], frame, yes, no)
        else:
            self.into.branch(self._truth(self.number(node, frame)), yes, no)

    def _truth(self, number: Scalar) -> Scalar:
        if number.kind == TRUTH:
            return number
        return self._compared(ast.NotEq(), number, Scalar(WHOLE, "0"))

    def _constant(self, node: ast.Constant, _: Frame) -> Value:
        return constant(node.value)

    def _name(self, node: ast.Name, frame: Frame) -> Value:
        if node.id in frame.variables:
            return frame.variables[node.id]
        return constant(self._known(node, frame))

    def _known(self, node: ast.expr, frame: Frame) -> Any:
        """Return what a name means outside the function."""
        if isinstance(node, ast.Attribute):
            return getattr(self._known(node.value, frame), node.attr)
        if isinstance(node, ast.Name) and node.id not in frame.variables:
            found = frame.names.get(node.id, getattr(builtins, node.id, None))
            if found is not None:
                return found
        raise NotTranslatedError(f"{ast.unparse(node)!r} has no meaning outside the function, and none in it")

    def _attribute(self, node: ast.Attribute, frame: Frame) -> Value:
        root: ast.expr = node
        while isinstance(root, ast.Attribute):
            root = root.value
        if isinstance(root, ast.Name) and root.id not in frame.variables:
            return constant(self._known(node, frame))
        value = self.value(node.value, frame)
        sort: Any = value.sort if isinstance(value, Record) else type(getattr(value, "example", None))
        if node.attr not in getattr(sort, "_fields", ()):
            raise NotTranslatedError(f"{ast.unparse(node)!r}: there is no such field")
        return self.into.member(value, sort._fields.index(node.attr))

    def _subscript(self, node: ast.Subscript, frame: Frame) -> Value:
        value, index = self.value(node.value, frame), self.number(node.slice, frame)
        if isinstance(value, Row):
            return self.into.load(value.text, index)
        if index.text.lstrip("-").isdigit():
            return self.into.member(value, int(index.text))
        if not isinstance(value, Stored) or size(value.example) != len(value.example):
            raise NotTranslatedError(
                f"{ast.unparse(node)!r}: only stored rows of numbers have a variable index"
            )
        at = self.into.emit(WHOLE, f"add i64 {index.text}, {value.offset}")
        return self.into.load(value.row, at)

    def _tuple(self, node: ast.Tuple, frame: Frame) -> Value:
        return Record(None, tuple(self.value(item, frame) for item in node.elts))

    def _unaryop(self, node: ast.UnaryOp, frame: Frame) -> Value:
        number = self.number(node.operand, frame)
        if isinstance(node.op, ast.Not):
            return self.into.emit(TRUTH, f"xor i1 {self._truth(number).text}, true")
        if not isinstance(node.op, ast.USub):
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        if number.kind == WHOLE:
            if number.text.isdigit():
                return Scalar(WHOLE, f"-{number.text}")
            return self.into.emit(WHOLE, f"sub i64 0, {number.text}")
        return self.into.emit(DOUBLE, f"fneg double {self.into.converted(number, DOUBLE).text}")

    def _binop(self, node: ast.BinOp, frame: Frame) -> Value:
        left = self.number(node.left, frame)
        if isinstance(node.op, ast.Pow):
            if not (isinstance(node.right, ast.Constant) and node.right.value == 2):
                raise NotTranslatedError(f"{ast.unparse(node)!r}: only squares are translated")
            return self.operation(ast.Mult(), left, left)
        return self.operation(node.op, left, self.number(node.right, frame))

    def operation(self, operator: ast.operator, left: Scalar, right: Scalar) -> Scalar:
        """Return a sum, difference, product or quotient."""
        if isinstance(operator, ast.Div):
            left, right = self.into.converted(left, DOUBLE), self.into.converted(right, DOUBLE)
            return self.into.emit(DOUBLE, f"fdiv double {left.text}, {right.text}")
        if type(operator) not in _ARITHMETIC:
            raise NotTranslatedError(f"{type(operator).__name__} is not translated")
        kind = DOUBLE if DOUBLE in (left.kind, right.kind) else WHOLE
        left, right = self.into.converted(left, kind), self.into.converted(right, kind)
        instruction = _ARITHMETIC[type(operator)][kind == WHOLE]
        return self.into.emit(kind, f"{instruction} {kind} {left.text}, {right.text}")

    def _compare(self, node: ast.Compare, frame: Frame) -> Value:
        values = [self.value(item, frame) for item in (node.left, *node.comparators)]
        result: Scalar | None = None
        for operator, left, right in zip(node.ops, values[:-1], values[1:], strict=True):
            holds = self._compared(operator, left, right)
            result = holds if result is None else self._both(result, holds)
        return result or TRUE

    def _compared(self, operator: ast.cmpop, left: Value, right: Value) -> Scalar:
        if isinstance(left, Scalar) and isinstance(right, Scalar):
            kind = DOUBLE if DOUBLE in (left.kind, right.kind) else WHOLE
            left, right = self.into.converted(left, kind), self.into.converted(right, kind)
            sort = _COMPARISONS[type(operator)][kind == WHOLE]
            instruction = "icmp" if kind == WHOLE else "fcmp"
            return self.into.emit(TRUTH, f"{instruction} {sort} {kind} {left.text}, {right.text}")
        if isinstance(operator, ast.NotEq):
            return self.into.emit(TRUTH, f"xor i1 {self._compared(ast.Eq(), left, right).text}, true")
        one, other = self.into.taken(left), self.into.taken(right)
        if not (isinstance(operator, ast.Eq) and isinstance(one, Record) and isinstance(other, Record)):
            raise NotTranslatedError("tuples are compared for equality alone")
        result = TRUE
        for a, b in zip(one.items, other.items, strict=True):
            result = self._both(result, self._compared(operator, a, b))
        return result

    def _both(self, one: Scalar, other: Scalar) -> Scalar:
        return self.into.emit(TRUTH, f"and i1 {one.text}, {other.text}")

    def _boolop(self, node: ast.BoolOp, frame: Frame) -> Value:
        return self._chosen(node, frame, lambda: TRUE, lambda: FALSE)

    def _ifexp(self, node: ast.IfExp, frame: Frame) -> Value:
        return self._chosen(
            node.test, frame, lambda: self.value(node.body, frame), lambda: self.value(node.orelse, frame)
        )

    def _chosen(
        self, test: ast.expr, frame: Frame, yes: Callable[[], Value], no: Callable[[], Value]
    ) -> Value:
        into = self.into
        first, second, end = into.label(), into.label(), into.label()
        self.jump_if(test, frame, first, second)
        arrivals = []
        for label, make in ((first, yes), (second, no)):
            into.start(label)
            value = make()
            arrivals.append((into.block, value))
            into.jump(end)
        into.start(end)
        return into.joined(arrivals)

    def _call(self, node: ast.Call, frame: Frame) -> Value:
        function = self._known(node.func, frame)
        arguments = [self.value(item, frame) for item in node.args]
        if isinstance(function, type) and issubclass(function, tuple):
            named = {str(word.arg): self.value(word.value, frame) for word in node.keywords}
            fields: tuple[str, ...] = getattr(function, "_fields", ())
            return Record(function, (*arguments, *(named[name] for name in fields[len(arguments) :])))
        if isinstance(function, FunctionType):
            named = {str(word.arg): self.value(word.value, frame) for word in node.keywords}
            names = function.__code__.co_varnames[len(arguments) : function.__code__.co_argcount]
            return self.call(function, [*arguments, *(named[name] for name in names)])
        numbers = [item for item in arguments if isinstance(item, Scalar)]
        if len(numbers) != len(arguments) or node.keywords:
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        return self._builtin(function, numbers, ast.unparse(node))

    def _builtin(self, function: Any, numbers: list[Scalar], text: str) -> Scalar:
        into = self.into
        if function in (max, min):
            return self._extreme(ast.Gt() if function is max else ast.Lt(), numbers)
        if function in (int, float):
            return into.converted(numbers[0], WHOLE if function is int else DOUBLE)
        if function is math.isfinite:
            size = self._builtin(abs, numbers, text)
            return self._compared(ast.Lt(), size, Scalar(DOUBLE, "0x7FF0000000000000"))
        if function not in EXTERNAL:
            raise NotTranslatedError(f"{text!r} is not translated")
        given = ", ".join(f"double {into.converted(number, DOUBLE).text}" for number in numbers)
        return into.emit(DOUBLE, f"call double @{EXTERNAL[function]}({given})")

    def _extreme(self, operator: ast.cmpop, numbers: list[Scalar]) -> Scalar:
        """Return the greatest or least number; the first of equals, and of what cannot be compared."""
        kind = DOUBLE if any(number.kind == DOUBLE for number in numbers) else WHOLE
        result, *others = (self.into.converted(number, kind) for number in numbers)
        for other in others:
            beyond = self._compared(operator, other, result)
            text = f"select i1 {beyond.text}, {kind} {other.text}, {kind} {result.text}"
            result = self.into.emit(kind, text)
        return result
