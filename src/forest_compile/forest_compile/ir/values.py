"""Values of LLVM's intermediate representation, as text.

| word | meaning |
|---|---|
| Scalar | a number in a register, or a constant: `double`, `i64` or `i1` |
| Record | a tuple, NamedTuple or not, all of whose numbers are scalars; it may lie in memory, too |
| Stored | a tuple that lies in memory alone; each number is loaded where it is used |
| Array | doubles in memory, nobody knows how many |
| shape | what is known of a value before there is one: a scalar's kind, or a record's type and items |

An integer is at most `LARGEST` on either side of zero, so that a double holds it exactly.
"""

import struct
from collections.abc import Callable, Iterator, Sequence
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


class Stored(NamedTuple):
    """A tuple in memory that stays as it is."""

    sort: type | None  # as of a record
    shapes: "tuple[Shape, ...]"  # of its items
    address: tuple[str, int]  # an array and an index there
    load: "Callable[[Shape, tuple[str, int], str | None], Value]"  # `Function.stored`


class Array(NamedTuple):
    """Doubles in memory: the register of their address."""

    text: str


Value = Scalar | Record | Stored | Array
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
    if isinstance(value, Record | Stored):
        return value.sort, item_shapes(value)
    return value.kind if isinstance(value, Scalar) else POINTER


def item_shapes(value: Record | Stored) -> tuple[Shape, ...]:
    """Return the shapes of a tuple's items."""
    return value.shapes if isinstance(value, Stored) else tuple(map(shape, value.items))


def size(of: Shape) -> int:
    """Return how many numbers a value of a shape holds."""
    return 1 if isinstance(of, str) else sum(size(item) for item in of[1])


def items(value: Value, block: str | None = None) -> tuple[Value, ...]:
    """Return the items of a tuple.

    Args:
        value: the tuple.
        block: at whose end those are loaded that lie in memory alone; None: where the function is written.

    Raises:
        NotTranslatedError: it is none.
    """
    if isinstance(value, Stored):
        return tuple(_stored_item(value, index, block) for index in range(len(value.shapes)))
    if not isinstance(value, Record):
        raise NotTranslatedError("a number or a row is no tuple")
    return value.items


def member(value: Value, index: int) -> Value:
    """Return an item of a tuple.

    Raises:
        NotTranslatedError: it is none, or has no such item.
    """
    count = len(value.shapes) if isinstance(value, Stored) else len(items(value))
    if not -count <= index < count:
        raise NotTranslatedError(f"there is no item {index} in a tuple of {count}")
    return _stored_item(value, index % count) if isinstance(value, Stored) else items(value)[index]


def _stored_item(value: Stored, index: int, block: str | None = None) -> Value:
    array, offset = value.address
    return value.load(value.shapes[index], (array, offset + sum(map(size, value.shapes[:index]))), block)


def fields(value: Value) -> tuple[str, ...]:
    """Return the names of a NamedTuple's fields; none if it is something else."""
    return getattr(value.sort, "_fields", ()) if isinstance(value, Record | Stored) else ()


def scalars(value: Value, block: str | None = None) -> Iterator[Scalar]:
    """Yield the numbers of a value, depth first; arguments as `items`.

    Raises:
        NotTranslatedError: there is an array in it.
    """
    if isinstance(value, Record | Stored):
        for item in items(value, block):
            yield from scalars(item, block)
    elif isinstance(value, Scalar):
        yield value
    else:
        raise NotTranslatedError("a row is no number, and no tuple of numbers")


def rebuilt(of: Shape, numbers: Iterator[Scalar]) -> Value:
    """Return a value of a shape's types and lengths made of numbers."""
    if isinstance(of, str):
        return next(numbers)
    return Record(of[0], tuple(rebuilt(item, numbers) for item in of[1]))


def same_structure(one: Shape, other: Shape) -> bool:
    """Tell whether two shapes are of tuples of the same types and lengths, or of no tuples."""
    if isinstance(one, str) or isinstance(other, str):
        return isinstance(one, str) and isinstance(other, str) and (one == POINTER) == (other == POINTER)
    alike = one[0] == other[0] and len(one[1]) == len(other[1])
    return alike and all(map(same_structure, one[1], other[1]))


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
