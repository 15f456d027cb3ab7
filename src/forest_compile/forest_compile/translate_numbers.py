"""Arithmetic, comparisons and functions of numbers in LLVM's text: what expressions are made of.

Python's meaning is kept to the last bit, but for errors: a quotient by zero is infinite, a root of a negative
number no number. A square is a product, where Python's `x**2` is the C library's power: in one of a thousand
the last bit differs, so laws that must agree write the product.
"""

import ast
import math
from collections.abc import Callable
from typing import Any

from forest_compile.llvm_text import DOUBLE, TRUTH, WHOLE, Function, Record, Scalar, Value

TRUE, FALSE = Scalar(TRUTH, "true"), Scalar(TRUTH, "false")
ZERO, INFINITE = Scalar(WHOLE, "0"), Scalar(DOUBLE, "0x7FF0000000000000")
ONE_ARGUMENT: dict[Any, str] = {
    math.sqrt: "llvm.sqrt.f64",
    abs: "llvm.fabs.f64",
    math.fabs: "llvm.fabs.f64",
    math.sin: "sin",
    math.cos: "cos",
    math.exp: "exp",
    math.acos: "acos",
}
TWO_ARGUMENTS: dict[Any, str] = {
    math.copysign: "llvm.copysign.f64",
    math.atan2: "atan2",
    pow: "pow",
    math.fmod: "fmod",
}
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


class Numbers:
    """Writes what is done to numbers into a function."""

    def __init__(self, into: Function) -> None:
        self.into = into

    def _truth(self, number: Scalar) -> Scalar:
        return self.into.converted(number, TRUTH)

    def operation(self, operator: ast.operator, left: Scalar, right: Scalar) -> Scalar:
        """Return a sum, difference, product, quotient or remainder."""
        if isinstance(operator, ast.Mod):
            return self._remainder(left, right)
        if isinstance(operator, ast.Div):
            left, right = self.into.converted(left, DOUBLE), self.into.converted(right, DOUBLE)
            return self.into.emit(DOUBLE, f"fdiv double {left.text}, {right.text}")
        if type(operator) not in _ARITHMETIC:
            raise NotTranslatedError(f"{type(operator).__name__} is not translated")
        kind = DOUBLE if DOUBLE in (left.kind, right.kind) else WHOLE
        left, right = self.into.converted(left, kind), self.into.converted(right, kind)
        instruction = _ARITHMETIC[type(operator)][kind == WHOLE]
        return self.into.emit(kind, f"{instruction} {kind} {left.text}, {right.text}")

    def _remainder(self, left: Scalar, right: Scalar) -> Scalar:
        """Return Python's remainder, which has the divisor's sign; C's has the dividend's."""
        if left.kind == DOUBLE or right.kind == DOUBLE:
            rest = self._builtin(math.fmod, [left, right], "%")
            add = "fadd"
        else:
            left, right = self.into.converted(left, WHOLE), self.into.converted(right, WHOLE)
            rest = self.into.emit(WHOLE, f"srem i64 {left.text}, {right.text}")
            add = "add"
        kind = rest.kind
        right = self.into.converted(right, kind)
        signs = [self._compared(ast.Lt(), number, ZERO).text for number in (rest, right)]
        differ = self.into.emit(TRUTH, f"xor i1 {signs[0]}, {signs[1]}")
        wrong = self._both(differ, self._compared(ast.NotEq(), rest, ZERO))
        moved = self.into.emit(kind, f"{add} {kind} {rest.text}, {right.text}")
        text = f"select i1 {wrong.text}, {kind} {moved.text}, {kind} {rest.text}"
        return self.into.emit(kind, text)

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

    def _builtin(self, function: Any, numbers: list[Scalar], text: str) -> Scalar:
        """Return what a function of numbers gives; `text` is the call's."""
        if function in _SPECIAL:
            return _SPECIAL[function](self, numbers)
        if function not in EXTERNAL:
            raise NotTranslatedError(f"{text!r} is not translated")
        given = ", ".join(f"double {self.into.converted(number, DOUBLE).text}" for number in numbers)
        return self.into.emit(DOUBLE, f"call double @{EXTERNAL[function]}({given})")

    def _is_nan(self, number: Scalar) -> Scalar:
        return self._compared(ast.NotEq(), *2 * (self.into.converted(number, DOUBLE),))

    def _is_finite(self, number: Scalar) -> Scalar:
        return self._compared(ast.Lt(), self._builtin(abs, [number], "abs"), INFINITE)

    def _floor(self, number: Scalar) -> Scalar:
        """Return the greatest whole number that is not greater."""
        cut = self.into.converted(number, WHOLE)
        less = self._compared(ast.Lt(), number, self.into.converted(cut, DOUBLE))
        return self.operation(ast.Sub(), cut, self.into.converted(less, WHOLE))

    def _extreme(self, operator: ast.cmpop, numbers: list[Scalar]) -> Scalar:
        """Return the greatest or least number; the first of equals, and of what cannot be compared."""
        kind = DOUBLE if any(number.kind == DOUBLE for number in numbers) else WHOLE
        result, *others = (self.into.converted(number, kind) for number in numbers)
        for other in others:
            beyond = self._compared(operator, other, result)
            text = f"select i1 {beyond.text}, {kind} {other.text}, {kind} {result.text}"
            result = self.into.emit(kind, text)
        return result


_SPECIAL: dict[Any, Callable[[Numbers, list[Scalar]], Scalar]] = {
    max: lambda to, given: to._extreme(ast.Gt(), given),
    min: lambda to, given: to._extreme(ast.Lt(), given),
    int: lambda to, given: to.into.converted(given[0], WHOLE),
    float: lambda to, given: to.into.converted(given[0], DOUBLE),
    bool: lambda to, given: to._truth(given[0]),
    math.floor: lambda to, given: to._floor(to.into.converted(given[0], DOUBLE)),
    math.isnan: lambda to, given: to._is_nan(given[0]),
    math.isfinite: lambda to, given: to._is_finite(given[0]),
}
