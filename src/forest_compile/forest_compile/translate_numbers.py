"""Arithmetic, comparisons and functions of numbers in LLVM's text: what expressions are made of.

Where Python gives a number, machine code gives it to the last bit, zeros with their signs. Where it raises:

| Python's error | machine code |
|---|---|
| division by zero, root of a negative double, overflow of a double | IEEE 754's result: infinite or NaN |
| remainder of a whole number by zero, index beyond a tuple, `int()` of NaN | a fault: the kernel raises |

A whole number beyond 2**53 - 1 is a fault, too. A fractional power of a negative number, which Python makes
complex, is NaN. The sign of NaN is any. Tuples are compared number by number: one with NaN is unlike itself.
"""

import ast
import math
from collections.abc import Callable
from typing import Any

from forest_compile.llvm_text import (
    DOUBLE,
    TRUTH,
    WHOLE,
    NotTranslatedError,
    Scalar,
    Value,
    common_kind,
    number,
)
from forest_compile.translate_whole import FALSE, TRUE, WholeNumbers

NO_DOUBLE, INFINITE = number(0.0), number(math.inf)
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
_ARITHMETIC: dict[type[ast.operator], str] = {
    ast.Add: "fadd",
    ast.Sub: "fsub",
    ast.Mult: "fmul",
    ast.Div: "fdiv",
}
_COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("olt", "slt"),
    ast.LtE: ("ole", "sle"),
    ast.Gt: ("ogt", "sgt"),
    ast.GtE: ("oge", "sge"),
    ast.Eq: ("oeq", "eq"),
    ast.NotEq: ("une", "ne"),
}


class Numbers(WholeNumbers):
    """Writes what is done to numbers into a function."""

    def _truth(self, value: Scalar) -> Scalar:
        return self.into.converted(value, TRUTH)

    def _double(self, value: Scalar) -> Scalar:
        return self.into.converted(self.settled(value), DOUBLE)

    def operation(self, sort: ast.operator, left: Scalar, right: Scalar) -> Scalar:
        """Return a sum, difference, product, quotient, remainder or power."""
        if DOUBLE not in (left.kind, right.kind) and not isinstance(sort, ast.Div):
            return self.whole_operation(sort, left, right)
        left, right = self._double(left), self._double(right)
        if isinstance(sort, ast.Mod):
            return self._remainder(left, right)
        if isinstance(sort, ast.Pow):
            return self._external(pow, [left, right])
        if type(sort) not in _ARITHMETIC:
            raise NotTranslatedError(f"{type(sort).__name__} is not translated")
        return self.into.emit(DOUBLE, f"{_ARITHMETIC[type(sort)]} double {left.text}, {right.text}")

    def _remainder(self, left: Scalar, right: Scalar) -> Scalar:
        """Return Python's remainder, which has the divisor's sign, zero too; C's has the dividend's."""
        into, rest = self.into, self._external(math.fmod, [left, right])
        signs = [self._compared(ast.Lt(), value, NO_DOUBLE).text for value in (rest, right)]
        differ = into.emit(TRUTH, f"xor i1 {signs[0]}, {signs[1]}")
        moved = into.emit(DOUBLE, f"fadd double {rest.text}, {right.text}")
        signed = into.emit(DOUBLE, f"select i1 {differ.text}, double {moved.text}, double {rest.text}")
        zero = self._external(math.copysign, [NO_DOUBLE, right])
        some = self._compared(ast.NotEq(), rest, NO_DOUBLE)
        return into.emit(DOUBLE, f"select i1 {some.text}, double {signed.text}, double {zero.text}")

    def _compared(self, sort: ast.cmpop, left: Value, right: Value) -> Scalar:
        if type(sort) not in _COMPARISONS:
            raise NotTranslatedError(f"{type(sort).__name__} is not translated")
        if isinstance(left, Scalar) and isinstance(right, Scalar):
            kind = DOUBLE if DOUBLE in (left.kind, right.kind) else WHOLE
            both = self._double if kind == DOUBLE else self.whole
            left, right = both(left), both(right)
            condition = _COMPARISONS[type(sort)][kind == WHOLE]
            instruction = "icmp" if kind == WHOLE else "fcmp"
            return self.into.emit(TRUTH, f"{instruction} {condition} {kind} {left.text}, {right.text}")
        if isinstance(sort, ast.NotEq):
            return self.into.emit(TRUTH, f"xor i1 {self._compared(ast.Eq(), left, right).text}, true")
        if not isinstance(sort, ast.Eq) or isinstance(left, Scalar) or isinstance(right, Scalar):
            raise NotTranslatedError("tuples are compared with tuples, for equality alone")
        one, other = self.into.items(left), self.into.items(right)
        if len(one) != len(other):
            return FALSE
        result = TRUE
        for a, b in zip(one, other, strict=True):
            same = self._compared(sort, a, b)
            result = self.into.emit(TRUTH, f"and i1 {result.text}, {same.text}")
        return result

    def _builtin(self, function: Any, numbers: list[Scalar], text: str) -> Scalar:
        """Return what a function of numbers gives; `text` is the call's."""
        if function not in _ARITIES:
            raise NotTranslatedError(f"{text!r} is not translated")
        if len(numbers) not in _ARITIES[function]:
            raise NotTranslatedError(f"{text!r}: not with {len(numbers)} numbers")
        whole = all(value.kind != DOUBLE for value in numbers)
        if function is pow and whole:
            raise NotTranslatedError(f"{text!r}: a power of whole numbers is not translated")
        if function is abs and whole:
            return self._extreme(ast.Gt(), [self.whole(numbers[0]), self.negative(numbers[0])])
        if function in _SPECIAL:
            return _SPECIAL[function](self, numbers)
        return self._external(function, numbers)

    def _external(self, function: Any, numbers: list[Scalar]) -> Scalar:
        """Return what a function of doubles gives that LLVM or the C library has."""
        given = ", ".join(f"double {self._double(value).text}" for value in numbers)
        return self.into.emit(DOUBLE, f"call double @{EXTERNAL[function]}({given})")

    def _is_nan(self, value: Scalar) -> Scalar:
        return self._compared(ast.NotEq(), *2 * (self._double(value),))

    def _is_finite(self, value: Scalar) -> Scalar:
        return self._compared(ast.Lt(), self._external(abs, [value]), INFINITE)

    def _floor(self, value: Scalar) -> Scalar:
        """Return the greatest whole number that is not greater."""
        cut = self.cut(value)
        less = self.whole(self._compared(ast.Lt(), value, cut))
        return self.into.emit(WHOLE, f"sub i64 {cut.text}, {less.text}")

    def _extreme(self, sort: ast.cmpop, numbers: list[Scalar]) -> Scalar:
        """Return the greatest or least number; the first of equals, and of what cannot be compared."""
        kind = common_kind(numbers)
        result, *others = (self.into.converted(value, kind) for value in numbers)
        for other in others:
            beyond = self._compared(sort, other, result)
            text = f"select i1 {beyond.text}, {kind} {other.text}, {kind} {result.text}"
            result = self.into.bounded(self.into.emit(kind, text), result, other)
        return result


_SPECIAL: dict[Any, Callable[[Numbers, list[Scalar]], Scalar]] = {
    max: lambda to, given: to._extreme(ast.Gt(), given),
    min: lambda to, given: to._extreme(ast.Lt(), given),
    int: lambda to, given: to.cut(given[0]),
    float: lambda to, given: to._double(given[0]),
    bool: lambda to, given: to._truth(given[0]),
    math.floor: lambda to, given: to._floor(given[0]),
    math.isnan: lambda to, given: to._is_nan(given[0]),
    math.isfinite: lambda to, given: to._is_finite(given[0]),
}
_ARITIES: dict[Any, range] = (
    dict.fromkeys(_SPECIAL, range(1, 2))
    | dict.fromkeys(ONE_ARGUMENT, range(1, 2))
    | dict.fromkeys(TWO_ARGUMENTS, range(2, 3))
    | dict.fromkeys((max, min), range(2, 1000))
)
