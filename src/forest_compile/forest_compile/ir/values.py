"""Values of LLVM's intermediate representation, as text.

| word | meaning |
|---|---|
| Scalar | a number in a register, or a constant: `double`, `i64` or `i1` |
| Record | a tuple, NamedTuple or not, all of whose numbers are scalars; it may lie in memory, too |
| Array | doubles in memory, nobody knows how many |
| shape | what is known of a value before there is one: a scalar's kind, or a record's type and items |

An integer is at most `LARGEST` on either side of zero, so that a double holds it exactly.
"""

import struct
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

DOUBLE, INTEGER, BOOLEAN, POINTER = "double", "i64", "i1", "ptr"
LARGEST = 2**53 - 1  # integer


class NotTranslatedError(TypeError):
    """Something in a model function is outside the subset.

    The message tells what, and in which function, file and line.

    Args:
        message: what.
        place: where; "" while it is not known.
    """

    def __init__(self, message: str, place: str = "") -> None:
        super().__init__(f"{place}: {message}" if place else message)
        self.message, self.place = message, place


class Scalar(NamedTuple):
    """A number: its kind, and the register or constant that holds it."""

    kind: str
    text: str


class Record(NamedTuple):
    """A tuple of values."""

    sort: type | None  # NamedTuple; None for a plain one
    items: "tuple[Value, ...]"
    address: tuple[str, int] | None = None  # an array and an index there, if it lies in memory


class Array(NamedTuple):
    """Doubles in memory: the register of their address."""

    text: str


Value = Scalar | Record | Array
Shape = str | tuple[type | None, tuple["Shape", ...]]


def constant(value: Any) -> Value:
    """Return a number or a nested tuple of numbers as it stands in the text.

    Raises:
        NotTranslatedError: it is something else, or an integer beyond `LARGEST`.
    """
    if isinstance(value, tuple):
        sort = type(value) if hasattr(value, "_fields") else None
        return Record(sort, tuple(constant(item) for item in value))
    if isinstance(value, int | float):
        return number(value)
    raise NotTranslatedError(f"{value!r} is no number")


def number(value: float) -> Scalar:
    """Return a number as it stands in the text; errors as `constant`."""
    if isinstance(value, bool):
        return Scalar(BOOLEAN, "true" if value else "false")
    if isinstance(value, float):
        return Scalar(DOUBLE, f"0x{struct.pack('>d', value).hex().upper()}")
    if abs(value) > LARGEST:
        raise NotTranslatedError(f"{value} is beyond the largest whole number, 2**53 - 1")
    return Scalar(INTEGER, str(int(value)))  # an IntEnum's member, too


def known(value: Scalar) -> int | None:
    """Return an integer or boolean that is a constant; None if it is none."""
    if value.kind == BOOLEAN:
        return {"true": 1, "false": 0}.get(value.text)
    return int(value.text) if value.kind == INTEGER and value.text.lstrip("-").isdigit() else None


def shape(value: Value) -> Shape:
    """Return the shape of a value."""
    if isinstance(value, Record):
        return value.sort, tuple(shape(item) for item in value.items)
    return value.kind if isinstance(value, Scalar) else POINTER


def size(of: Shape) -> int:
    """Return how many numbers a value of a shape holds."""
    return 1 if isinstance(of, str) else sum(size(item) for item in of[1])


def items(value: Value) -> tuple[Value, ...]:
    """Return the items of a tuple.

    Raises:
        NotTranslatedError: it is none.
    """
    if not isinstance(value, Record):
        raise NotTranslatedError("a number or a row is no tuple")
    return value.items


def member(value: Value, index: int) -> Value:
    """Return an item of a tuple.

    Raises:
        NotTranslatedError: it is none, or has no such item.
    """
    inner = items(value)
    if not -len(inner) <= index < len(inner):
        raise NotTranslatedError(f"there is no item {index} in a tuple of {len(inner)}")
    return inner[index]


def fields(value: Value) -> tuple[str, ...]:
    """Return the names of a NamedTuple's fields; none if it is something else."""
    return getattr(value.sort, "_fields", ()) if isinstance(value, Record) else ()


def scalars(value: Value) -> Iterator[Scalar]:
    """Yield the numbers of a value, depth first.

    Raises:
        NotTranslatedError: there is an array in it.
    """
    if isinstance(value, Record):
        for item in value.items:
            yield from scalars(item)
    elif isinstance(value, Scalar):
        yield value
    else:
        raise NotTranslatedError("a row is no number, and no tuple of numbers")


def rebuilt(value: Value, numbers: Iterator[Scalar]) -> Value:
    """Return a value of the same types and lengths made of other numbers."""
    if isinstance(value, Record):
        return Record(value.sort, tuple(rebuilt(item, numbers) for item in value.items))
    return next(numbers)


def same_structure(one: Value, other: Value) -> bool:
    """Tell whether two values are tuples of the same types and lengths, or no tuples."""
    if isinstance(one, Record) and isinstance(other, Record):
        alike = one.sort == other.sort and len(one.items) == len(other.items)
        return alike and all(map(same_structure, one.items, other.items))
    return type(one) is type(other)


def common_kind(numbers: Sequence[Scalar]) -> str:
    """Return the kind that one of several numbers has: double, or integer, or boolean.

    Raises:
        NotTranslatedError: some are doubles and others are not. Python would go on with the one or the other,
            and an integer has no negative zero.
    """
    kinds = {number.kind for number in numbers}
    if DOUBLE in kinds and len(kinds) > 1:
        raise NotTranslatedError("a double on one way, a whole number on another; write 0.0, or float(...)")
    return next(kind for kind in (DOUBLE, INTEGER, BOOLEAN) if kind in kinds)
