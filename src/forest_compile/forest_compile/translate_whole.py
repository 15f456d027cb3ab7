"""Whole numbers and truths in LLVM's text: their arithmetic, and what becomes of one that is too large.

Python's whole numbers have no end, a register has. One that leaves +-`LARGEST` ends the kernel with a fault,
so that each that goes on is Python's, and every double made of one is exact.
"""

import ast
import operator
from collections.abc import Callable

from forest_compile.llvm_text import (
    DOUBLE,
    LARGEST,
    TRUTH,
    WHOLE,
    Function,
    NotTranslatedError,
    Scalar,
    known,
    number,
)

TRUE, FALSE = Scalar(TRUTH, "true"), Scalar(TRUTH, "false")
ZERO = Scalar(WHOLE, "0")
ROOM = 2**62  # for sums of whole numbers, before they leave 64 bits
LIMIT = Scalar(DOUBLE, "0x4340000000000000")  # LARGEST + 1
_Operation = tuple[str, Callable[[int, int], int]]
_OPERATIONS: dict[type[ast.operator], _Operation] = {
    ast.Add: ("add", operator.add),
    ast.Sub: ("sub", operator.sub),
    ast.Mult: ("mul", operator.mul),
    ast.Mod: ("srem", operator.mod),
}


class WholeNumbers:
    """Writes what is done to whole numbers into a function."""

    def __init__(self, into: Function) -> None:
        self.into = into

    def place(self) -> str:
        """Return which function, file and line is being written."""
        raise NotImplementedError

    def require(self, condition: Scalar, fault: str) -> None:
        """Go on if a condition holds; else the kernel raises an error that names the fault and the place."""
        self.into.require(condition, f"{self.place()}: {fault}")

    def whole(self, number: Scalar) -> Scalar:
        """Return a truth as a whole number, a whole number as it is.

        Raises:
            NotTranslatedError: it is a double.
        """
        if number.kind == DOUBLE:
            raise NotTranslatedError("a double where Python takes a whole number")
        return self.into.converted(number, WHOLE)

    def whole_operation(self, sort: ast.operator, left: Scalar, right: Scalar) -> Scalar:
        """Return sum, difference, product or remainder of whole numbers."""
        if type(sort) not in _OPERATIONS:
            raise NotTranslatedError(f"{type(sort).__name__} of whole numbers is not translated")
        instruction, python = _OPERATIONS[type(sort)]
        left, right = self.whole(left), self.whole(right)
        a, b = known(left), known(right)
        if a is not None and b is not None and not (instruction == "srem" and b == 0):
            return number(python(a, b))
        if instruction == "srem":
            return self._whole_remainder(left, right)
        if instruction == "mul":
            return self._product(left, right)
        bound = self.into.bound(left) + self.into.bound(right)
        if bound > ROOM:
            left, right, bound = self.settled(left), self.settled(right), 2 * LARGEST
        result = self.into.emit(WHOLE, f"{instruction} nsw i64 {left.text}, {right.text}")
        return self.into.bounded(result, most=bound)

    def _product(self, left: Scalar, right: Scalar) -> Scalar:
        left, right = self.settled(left), self.settled(right)
        bound = self.into.bound(left) * self.into.bound(right)
        result = self.into.emit(WHOLE, f"mul i64 {left.text}, {right.text}")
        if bound <= ROOM:
            return self.into.bounded(result, most=bound)
        # The doubles' product is exact while it is small enough, and not small enough otherwise.
        factors = [self.into.converted(factor, DOUBLE).text for factor in (left, right)]
        self._require_small(self.into.emit(DOUBLE, f"fmul double {factors[0]}, {factors[1]}"))
        return result

    def settled(self, value: Scalar) -> Scalar:
        """Return a number once it is known that a whole one is no larger than `LARGEST`."""
        if value.kind != WHOLE or self.into.bound(value) <= LARGEST:
            return value
        moved = self.into.emit(WHOLE, f"add nsw i64 {value.text}, {LARGEST}")
        small = self.into.emit(TRUTH, f"icmp ule i64 {moved.text}, {2 * LARGEST}")
        self.require(small, "a whole number beyond 2**53 - 1")
        return self.into.bounded(self.into.emit(WHOLE, f"add i64 {value.text}, 0"), most=LARGEST)

    def _whole_remainder(self, left: Scalar, right: Scalar) -> Scalar:
        """Return Python's remainder, which has the divisor's sign; the processor's has the dividend's."""
        into = self.into
        self.require(into.emit(TRUTH, f"icmp ne i64 {right.text}, 0"), "a remainder by zero")
        rest = into.emit(WHOLE, f"srem i64 {left.text}, {right.text}")
        signs = into.emit(WHOLE, f"xor i64 {rest.text}, {right.text}")
        differ = into.emit(TRUTH, f"icmp slt i64 {signs.text}, 0")
        some = into.emit(TRUTH, f"icmp ne i64 {rest.text}, 0")
        wrong = into.emit(TRUTH, f"and i1 {differ.text}, {some.text}")
        moved = into.emit(WHOLE, f"add i64 {rest.text}, {right.text}")
        rest = into.emit(WHOLE, f"select i1 {wrong.text}, i64 {moved.text}, i64 {rest.text}")
        return into.bounded(rest, right)

    def negative(self, value: Scalar) -> Scalar:
        """Return a whole number or truth with the other sign; zero has none."""
        constant = known(value)
        if constant is not None:
            return number(-constant)
        return self.into.bounded(self.into.emit(WHOLE, f"sub nsw i64 0, {self.whole(value).text}"), value)

    def cut(self, value: Scalar) -> Scalar:
        """Return a number as `int()` does."""
        if value.kind == DOUBLE:
            self._require_small(value)
        return self.into.converted(value, WHOLE)

    def _require_small(self, value: Scalar) -> None:
        size = self.into.emit(DOUBLE, f"call double @llvm.fabs.f64(double {value.text})")
        small = self.into.emit(TRUTH, f"fcmp olt double {size.text}, {LIMIT.text}")
        self.require(small, "a whole number beyond 2**53 - 1, or of no number")


def require_whole(into: Function, row: str, at: int, name: str, truth: bool) -> None:
    """Go on if what lies in a row for a whole number or a truth is one.

    Args:
        into: the function.
        row: register of the row.
        at: where in the row.
        name: of the number.
        truth: whether it is to be a truth.
    """
    stored, fault = (
        into.load(row, at),
        f"{name} is {'no truth' if truth else 'no whole number up to 2**53 - 1'}",
    )
    size = into.emit(DOUBLE, f"call double @llvm.fabs.f64(double {stored.text})")
    largest = float(1 if truth else LARGEST)
    into.require(into.emit(TRUTH, f"fcmp ole double {size.text}, {largest}"), fault)
    back = into.converted(into.converted(stored, WHOLE), DOUBLE)
    into.require(into.emit(TRUTH, f"fcmp oeq double {back.text}, {stored.text}"), fault)
