"""Arithmetic of integers and booleans, and what becomes of an integer that is too large.

Python's integers have no end, a register has. One that leaves +-`LARGEST` ends the kernel with a fault, so
that each that goes on is Python's, and every double made of one is exact.
"""

import ast
import operator
from collections.abc import Callable

from forest_compile.frontend.frame import Frame
from forest_compile.ir.function import Function
from forest_compile.ir.values import (
    DOUBLE,
    INTEGER,
    LARGEST,
    NotTranslatedError,
    Record,
    Scalar,
    Value,
    known,
    number,
)

ZERO = number(0)
ROOM = 2**62  # for sums of integers, before they leave 64 bits
_OPERATIONS: dict[type[ast.operator], Callable[[int, int], int]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Mod: operator.mod,
}


class Integers:
    """Writes what is done to integers into a function."""

    into: Function
    """What is being written."""
    frames: list[Frame]
    """Calls that are being translated, each called by the one before it."""

    @property
    def frame(self) -> Frame:
        """The innermost call."""
        return self.frames[-1]

    def require(self, condition: Scalar, fault: str) -> None:
        """Go on if a condition holds; else the kernel raises an error that names the fault and the place."""
        self.into.require(condition, f"{self.frame.place()}: {fault}")

    def integer(self, value: Scalar) -> Scalar:
        """Return a boolean as an integer, an integer as it is.

        Raises:
            NotTranslatedError: it is a double.
        """
        if value.kind == DOUBLE:
            raise NotTranslatedError("a double where Python takes a whole number")
        return self.into.converted(value, INTEGER)

    def integer_operation(self, sort: ast.operator, left: Scalar, right: Scalar) -> Scalar:
        """Return sum, difference, product or remainder of integers."""
        if type(sort) not in _OPERATIONS:
            raise NotTranslatedError(f"{type(sort).__name__} of whole numbers is not translated")
        left, right = self.integer(left), self.integer(right)
        a, b = known(left), known(right)
        if a is not None and b is not None and not (isinstance(sort, ast.Mod) and b == 0):
            return number(_OPERATIONS[type(sort)](a, b))
        if isinstance(sort, ast.Mod):
            return self._remainder(left, right)
        if isinstance(sort, ast.Mult):
            return self._product(left, right)
        bound = self.into.bound(left) + self.into.bound(right)
        if bound > ROOM:
            left, right, bound = self._settled(left), self._settled(right), 2 * LARGEST
        instruction = "add nsw" if isinstance(sort, ast.Add) else "sub nsw"
        return self.into.bounded(self.into.operate(instruction, left, right), most=bound)

    def _product(self, left: Scalar, right: Scalar) -> Scalar:
        left, right = self._settled(left), self._settled(right)
        bound = self.into.bound(left) * self.into.bound(right)
        result = self.into.operate("mul", left, right)
        if bound <= ROOM:
            return self.into.bounded(result, most=bound)
        # The doubles' product is exact while it is small enough, and not small enough otherwise.
        factors = [self.into.converted(factor, DOUBLE) for factor in (left, right)]
        self._require_small(self.into.operate("fmul", *factors))
        return result

    def settled(self, value: Value) -> Value:
        """Return a value once it is known that no integer in it is larger than `LARGEST`."""
        if isinstance(value, Scalar):
            return self._settled(value)
        if isinstance(value, Record) and not value.address:
            return Record(value.sort, tuple(self.settled(item) for item in value.items))
        return value

    def _settled(self, value: Scalar) -> Scalar:
        if value.kind != INTEGER or self.into.bound(value) <= LARGEST:
            return value
        moved = self.into.operate("add nsw", value, number(LARGEST))
        small = self.into.operate("icmp ule", moved, Scalar(INTEGER, str(2 * LARGEST)))
        self.require(small, "a whole number beyond 2**53 - 1")
        return self.into.operate("add", value, ZERO)  # another register, with another bound

    def _remainder(self, left: Scalar, right: Scalar) -> Scalar:
        """Return Python's remainder, which has the divisor's sign; the processor's has the dividend's."""
        into = self.into
        self.require(into.operate("icmp ne", right, ZERO), "a remainder by zero")
        rest = into.operate("srem", left, right)
        differ = into.operate("icmp slt", into.operate("xor", rest, right), ZERO)
        wrong = into.operate("and", differ, into.operate("icmp ne", rest, ZERO))
        return into.bounded(into.select(wrong, into.operate("add", rest, right), rest), right)

    def negative(self, value: Scalar) -> Scalar:
        """Return an integer or boolean with the other sign; zero has none."""
        constant = known(value)
        if constant is not None:
            return number(-constant)
        return self.into.bounded(self.into.operate("sub nsw", ZERO, self.integer(value)), value)

    def cut(self, value: Scalar) -> Scalar:
        """Return a number as `int()` does."""
        if value.kind == DOUBLE:
            self._require_small(value)
        return self.into.converted(value, INTEGER)

    def _require_small(self, value: Scalar) -> None:
        size = self.into.emit(DOUBLE, f"call double @llvm.fabs.f64(double {value.text})")
        small = self.into.operate("fcmp olt", size, number(LARGEST + 1.0))
        self.require(small, "a whole number beyond 2**53 - 1, or of no number")

    def require_stored(self, array: str, at: int, name: str, kind: str) -> None:
        """Go on if what lies in an array for an integer or a boolean is one.

        Args:
            array: its address.
            at: where in it.
            name: of the number.
            kind: what it is to be.
        """
        into, stored = self.into, self.into.load(array, at)
        most, fault = (LARGEST, "no whole number up to 2**53 - 1") if kind == INTEGER else (1, "no truth")
        size = into.emit(DOUBLE, f"call double @llvm.fabs.f64(double {stored.text})")
        into.require(into.operate("fcmp ole", size, number(float(most))), f"{name} is {fault}")
        back = into.converted(into.converted(stored, INTEGER), DOUBLE)
        into.require(into.operate("fcmp oeq", back, stored), f"{name} is {fault}")
