"""Arithmetic, comparisons and functions of numbers: what expressions are made of.

Where Python gives a number, machine code gives it to the last bit, zeros with their signs. Where it raises:

| Python's error | machine code |
|---|---|
| division by zero, root of a negative double, overflow of a double | IEEE 754's result: infinite or NaN |
| remainder of an integer by zero, index beyond a tuple, `int()` of NaN | a fault: the kernel raises |

An integer beyond 2**53 - 1 is a fault, too. A fractional power of a negative number, which Python makes
complex, is NaN. The sign of NaN is any. Tuples are compared number by number: one with NaN is unlike itself.
"""

import ast
import math
from collections.abc import Callable
from typing import Any

from forest_compile.frontend.integers import Integers
from forest_compile.ir.values import (
    BOOLEAN,
    DOUBLE,
    NotTranslatedError,
    Scalar,
    Value,
    common_kind,
    items,
    number,
)

TRUE, FALSE, NO_DOUBLE, INFINITE = number(True), number(False), number(0.0), number(math.inf)
EXTERNAL: dict[Any, tuple[str, int]] = {  # LLVM's or the C library's name, and how many doubles it takes
    math.sqrt: ("llvm.sqrt.f64", 1),
    abs: ("llvm.fabs.f64", 1),
    math.fabs: ("llvm.fabs.f64", 1),
    math.sin: ("sin", 1),
    math.cos: ("cos", 1),
    math.exp: ("exp", 1),
    math.log: ("log", 1),
    math.acos: ("acos", 1),
    math.copysign: ("llvm.copysign.f64", 2),
    math.atan2: ("atan2", 2),
    pow: ("pow", 2),
    math.fmod: ("fmod", 2),
}
_ARITHMETIC: dict[type[ast.operator], str] = {
    ast.Add: "fadd",
    ast.Sub: "fsub",
    ast.Mult: "fmul",
    ast.Div: "fdiv",
}
_COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("fcmp olt", "icmp slt"),
    ast.LtE: ("fcmp ole", "icmp sle"),
    ast.Gt: ("fcmp ogt", "icmp sgt"),
    ast.GtE: ("fcmp oge", "icmp sge"),
    ast.Eq: ("fcmp oeq", "icmp eq"),
    ast.NotEq: ("fcmp une", "icmp ne"),
}


class Arithmetic(Integers):
    """Writes what is done to numbers into a function."""

    def truth(self, value: Scalar) -> Scalar:
        """Return a number as a boolean."""
        return self.into.converted(value, BOOLEAN)

    def double(self, value: Scalar) -> Scalar:
        """Return a number as a double."""
        return self.into.converted(self._settled(value), DOUBLE)

    def operation(self, sort: ast.operator, left: Scalar, right: Scalar) -> Scalar:
        """Return a sum, difference, product, quotient, remainder or power."""
        if DOUBLE not in (left.kind, right.kind) and not isinstance(sort, ast.Div):
            return self.integer_operation(sort, left, right)
        left, right = self.double(left), self.double(right)
        if isinstance(sort, ast.Mod):
            return self._double_remainder(left, right)
        if isinstance(sort, ast.Pow):
            return self.external(pow, [left, right])
        if type(sort) not in _ARITHMETIC:
            raise NotTranslatedError(f"{type(sort).__name__} is not translated")
        return self.into.operate(_ARITHMETIC[type(sort)], left, right)

    def _double_remainder(self, left: Scalar, right: Scalar) -> Scalar:
        """Return Python's remainder, which has the divisor's sign, zero too; C's has the dividend's."""
        into, rest = self.into, self.external(math.fmod, [left, right])
        signs = [into.operate("fcmp olt", value, NO_DOUBLE) for value in (rest, right)]
        moved = into.operate("fadd", rest, right)
        signed = into.select(into.operate("xor", *signs), moved, rest)
        zero = self.external(math.copysign, [NO_DOUBLE, right])
        return into.select(into.operate("fcmp une", rest, NO_DOUBLE), signed, zero)

    def compared(self, sort: ast.cmpop, left: Value, right: Value) -> Scalar:
        """Return whether a comparison of numbers, or of tuples, holds."""
        if type(sort) not in _COMPARISONS:
            raise NotTranslatedError(f"{type(sort).__name__} is not translated")
        of_doubles, of_integers = _COMPARISONS[type(sort)]
        if isinstance(left, Scalar) and isinstance(right, Scalar):
            if DOUBLE in (left.kind, right.kind):
                return self.into.operate(of_doubles, self.double(left), self.double(right))
            return self.into.operate(of_integers, self.integer(left), self.integer(right))
        if isinstance(sort, ast.NotEq):
            return self.into.operate("xor", self.compared(ast.Eq(), left, right), TRUE)
        if not isinstance(sort, ast.Eq) or isinstance(left, Scalar) or isinstance(right, Scalar):
            raise NotTranslatedError("tuples are compared with tuples, for equality alone")
        if len(items(left)) != len(items(right)):
            return FALSE
        result = TRUE
        for one, other in zip(items(left), items(right), strict=True):
            result = self.into.operate("and", result, self.compared(sort, one, other))
        return result

    def builtin(self, function: Any, numbers: list[Scalar], text: str) -> Scalar:
        """Return what a function of numbers gives; `text` is the call's."""
        if function not in _SPECIAL and function not in EXTERNAL:
            raise NotTranslatedError(f"{text!r} is not translated")
        _, wanted = EXTERNAL.get(function, ("", 1))
        if not (len(numbers) > 1 if function in (max, min) else len(numbers) == wanted):
            raise NotTranslatedError(f"{text!r}: not with {len(numbers)} numbers")
        no_double = all(value.kind != DOUBLE for value in numbers)
        if function is pow and no_double:
            raise NotTranslatedError(f"{text!r}: a power of whole numbers is not translated")
        if function is abs and no_double:
            return self.extreme(ast.Gt(), [self.integer(numbers[0]), self.negative(numbers[0])])
        if function in _SPECIAL:
            return _SPECIAL[function](self, numbers)
        return self.external(function, numbers)

    def external(self, function: Any, numbers: list[Scalar]) -> Scalar:
        """Return what a function of doubles gives that LLVM or the C library has."""
        given = ", ".join(f"double {self.double(value).text}" for value in numbers)
        return self.into.emit(DOUBLE, f"call double @{EXTERNAL[function][0]}({given})")

    def floor(self, value: Scalar) -> Scalar:
        """Return the greatest integer that is not greater."""
        cut = self.cut(value)
        return self.into.operate("sub", cut, self.integer(self.compared(ast.Lt(), value, cut)))

    def extreme(self, sort: ast.cmpop, numbers: list[Scalar]) -> Scalar:
        """Return the greatest or least number; the first of equals, and of what cannot be compared."""
        kind = common_kind(numbers)
        result, *others = (self.into.converted(value, kind) for value in numbers)
        for other in others:
            result = self.into.select(self.compared(sort, other, result), other, result)
        return result


_SPECIAL: dict[Any, Callable[[Arithmetic, list[Scalar]], Scalar]] = {
    max: lambda to, given: to.extreme(ast.Gt(), given),
    min: lambda to, given: to.extreme(ast.Lt(), given),
    int: lambda to, given: to.cut(given[0]),
    float: lambda to, given: to.double(given[0]),
    bool: lambda to, given: to.truth(given[0]),
    math.floor: lambda to, given: to.floor(given[0]),
    math.isnan: lambda to, given: to.compared(ast.NotEq(), *given, *given),
    math.isfinite: lambda to, given: to.compared(ast.Lt(), to.external(abs, given), INFINITE),
}
