"""LLVM's text, block by block: what `translate` writes a function of the laws into.

| word | meaning |
|---|---|
| Scalar | a number in a register, or a constant: `double`, `i64` or `i1` |
| Record | a tuple, NamedTuple or not: no place in memory, only its numbers |
| Stored | a tuple that lies flat in a row of doubles (`flat`); its numbers are loaded where they are used |
| Row | an array of doubles |
| block | a stretch of instructions that is entered at its label alone and left at its end alone |
| fault | what ends a call early: its text is what the function returns |

A whole number is at most `LARGEST` on either side of zero, so that a double holds it exactly. Sums on the way
to one may be larger: `bound` tells how much.
"""

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

DOUBLE, WHOLE, TRUTH, POINTER = "double", "i64", "i1", "ptr"
LARGEST = 2**53 - 1  # whole number
FAULT = "fault"  # label of the block where faults arrive


class NotTranslatedError(TypeError):
    """Something in the laws is outside the subset.

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
    """A tuple of values; `sort` is its NamedTuple, or None."""

    sort: type | None
    items: "tuple[Value, ...]"


class Stored(NamedTuple):
    """A tuple in memory: an example of it, the row's register, and where in the row it begins."""

    example: tuple[Any, ...]
    row: str
    offset: int


class Row(NamedTuple):
    """An array of doubles, by its register."""

    text: str


Value = Scalar | Record | Stored | Row


def constant(value: Any) -> Value:
    """Return a number or a nested tuple of numbers as it stands in the text.

    Raises:
        NotTranslatedError: it is something else, or a whole number beyond `LARGEST`.
    """
    if isinstance(value, bool):
        return Scalar(TRUTH, "true" if value else "false")
    if isinstance(value, int):
        if abs(value) > LARGEST:
            raise NotTranslatedError(f"{value} is beyond the largest whole number, 2**53 - 1")
        return Scalar(WHOLE, str(int(value)))  # an IntEnum's member, too
    if isinstance(value, float):
        return Scalar(DOUBLE, f"0x{struct.pack('>d', value).hex().upper()}")
    if isinstance(value, tuple):
        sort = type(value) if hasattr(value, "_fields") else None
        return Record(sort, tuple(constant(item) for item in value))
    raise NotTranslatedError(f"{value!r} is no number")


def known(value: Scalar) -> int | None:
    """Return a whole number or truth that is a constant; None if it is none."""
    if value.kind == TRUTH:
        return {"true": 1, "false": 0}.get(value.text)
    return int(value.text) if value.kind == WHOLE and value.text.lstrip("-").isdigit() else None


def number(value: float) -> Scalar:
    """Return a number as it stands in the text."""
    (scalar,) = scalars(constant(value))
    return scalar


def size(example: Any) -> int:
    """Return how many numbers a nested tuple holds."""
    return sum(size(item) for item in example) if isinstance(example, tuple) else 1


def scalars(value: Value) -> Iterator[Scalar]:
    """Yield the numbers of a value that does not lie in memory, depth first."""
    if isinstance(value, Record):
        for item in value.items:
            yield from scalars(item)
    elif isinstance(value, Scalar):
        yield value
    else:
        raise NotTranslatedError("a row is no number, and no tuple of numbers")


def rebuilt(value: Value, numbers: Iterator[Scalar]) -> Value:
    """Return a value of the same shape made of other numbers."""
    if isinstance(value, Record):
        return Record(value.sort, tuple(rebuilt(item, numbers) for item in value.items))
    return next(numbers)


def common_kind(numbers: Sequence[Scalar]) -> str:
    """Return the kind that one of several numbers has: double, or whole number, or truth.

    Raises:
        NotTranslatedError: some are doubles and others are not. Python would go on with the one or the other,
            and a whole number has no negative zero.
    """
    kinds = {number.kind for number in numbers}
    if DOUBLE in kinds and len(kinds) > 1:
        raise NotTranslatedError("a double on one way, a whole number on another; write 0.0, or float(...)")
    return next(kind for kind in (DOUBLE, WHOLE, TRUTH) if kind in kinds)


def sort_of(value: Value) -> type | None:
    """Return the NamedTuple that a tuple is; None if it is a plain one, or none."""
    if isinstance(value, Record):
        return value.sort
    example = value.example if isinstance(value, Stored) else None
    return type(example) if hasattr(example, "_fields") else None


def shape(value: Value) -> Any:
    """Return what items of one tuple must have in common to be chosen by a variable index."""
    if isinstance(value, Scalar):
        return value.kind
    if isinstance(value, Record):
        return value.sort, tuple(shape(item) for item in value.items)
    return shape(constant(value.example)) if isinstance(value, Stored) else value


class Function:
    """One function under way: its blocks, and the one that is being written."""

    def __init__(self, loaded: dict[tuple[str, int], Scalar] | None = None) -> None:
        """Begin a function.

        Args:
            loaded: known numbers of rows; given, even without any, all else is loaded once, at the start.
        """
        self._early = loaded
        self._bodies: dict[str, list[str]] = {}
        self._ends: dict[str, str] = {}
        self._count = 0
        self._bounds: dict[str, int] = {}
        self.faults: list[tuple[str, str | Scalar]] = []  # block, text or pointer
        self.block = ""
        self.open = False
        self._entry = self.label()
        self.start(self._entry)

    def label(self) -> str:
        """Return a name that no block has yet."""
        self._count += 1
        return f"b{self._count}"

    def start(self, label: str) -> None:
        """Go on in a new block, or in one that has no end yet."""
        self._bodies.setdefault(label, [])
        self.block, self.open = label, True

    def emit(self, kind: str, text: str, block: str | None = None) -> Scalar:
        """Write an instruction, and return its result."""
        self._count += 1
        name = f"%v{self._count}"
        self._bodies[block or self.block].append(f"{name} = {text}")
        return Scalar(kind, name)

    def bound(self, value: Scalar) -> int:
        """Return what a whole number or truth is at most, on either side of zero."""
        constant = known(value)
        if constant is not None:
            return abs(constant)
        return 1 if value.kind == TRUTH else self._bounds.get(value.text, LARGEST)

    def bounded(self, value: Scalar, *among: Scalar, most: int = 0) -> Scalar:
        """Return a whole number after noting that it is one of several, or at most so much."""
        if value.kind == WHOLE:
            self._bounds[value.text] = max([most, *map(self.bound, among)])
        return value

    def do(self, text: str) -> None:
        """Write an instruction without result."""
        self._bodies[self.block].append(text)

    def end(self, text: str, block: str | None = None) -> None:
        """End a block, by default the one that is being written."""
        self._ends[block or self.block] = text
        if block in (None, self.block):
            self.open = False

    def jump(self, label: str) -> None:
        """Go on elsewhere."""
        self.end(f"br label %{label}")

    def branch(self, condition: Scalar, yes: str, no: str) -> None:
        """Go on at one label or the other."""
        self.end(f"br i1 {condition.text}, label %{yes}, label %{no}")

    def require(self, condition: Scalar, fault: str | Scalar) -> None:
        """Go on if a condition holds; else the function ends with a fault: a text, or what points to one."""
        further = self.label()
        self.faults.append((self.block, fault))
        self.end(f"br i1 {condition.text}, label %{further}, label %{FAULT}, !prof !0")
        self.start(further)

    def fault(self, names: Callable[[str], str]) -> Scalar:
        """Go on where faults arrive; return the pointer to the text of the one that did.

        Args:
            names: gives a text's name in the module.
        """
        self.start(FAULT)
        arrivals = [
            (block, fault if isinstance(fault, Scalar) else Scalar(POINTER, names(fault)))
            for block, fault in self.faults
        ]
        return self._first(POINTER, _phi(POINTER, arrivals))

    def text(self) -> Iterator[str]:
        """Yield the function's lines."""
        for label, body in self._bodies.items():
            yield f"{label}:"
            yield from body
            yield self._ends[label]

    def element(self, row: str, index: Scalar | int, block: str | None = None) -> Scalar:
        """Return the address of a number of a row."""
        at = str(index) if isinstance(index, int) else index.text
        return self.emit(POINTER, f"getelementptr double, ptr {row}, i64 {at}", block)

    def load(self, row: str, index: Scalar | int, block: str | None = None) -> Scalar:
        """Return a number of a row."""
        at = self.element(row, index, block)
        return self.emit(DOUBLE, f"load double, ptr {at.text}, align 8", block)

    def converted(self, value: Scalar, kind: str, block: str | None = None) -> Scalar:
        """Return a number as one of another kind; a double is cut to a whole number as int() does.

        Whether it is small enough for that is for others to see.
        """
        if value.kind == kind:
            return value
        constant = known(value)
        if constant is not None and kind == WHOLE:
            return Scalar(WHOLE, str(constant))
        if kind == WHOLE and value.kind == TRUTH:
            return self.bounded(self.emit(WHOLE, f"zext i1 {value.text} to i64", block), most=1)
        ways = {
            (WHOLE, DOUBLE): "sitofp",
            (DOUBLE, WHOLE): "fptosi",
            (TRUTH, DOUBLE): "uitofp",
        }
        if kind == TRUTH:
            test = "fcmp une double" if value.kind == DOUBLE else "icmp ne i64"
            return self.emit(TRUTH, f"{test} {value.text}, {'0.0' if value.kind == DOUBLE else '0'}", block)
        return self.emit(kind, f"{ways[value.kind, kind]} {value.kind} {value.text} to {kind}", block)

    def member(self, value: Value, index: int, block: str | None = None) -> Value:
        """Return an item of a tuple."""
        count = _count(value)
        if not -count <= index < count:
            raise NotTranslatedError(f"there is no item {index} in a tuple of {count}")
        index %= count
        if not isinstance(value, Stored):
            return self.items(value)[index]
        item = value.example[index]
        offset = value.offset + size(value.example[:index])
        if isinstance(item, tuple):
            return Stored(item, value.row, offset)
        kind = TRUTH if isinstance(item, bool) else WHOLE if isinstance(item, int) else DOUBLE
        if self._early is None:
            return self.converted(self.load(value.row, offset, block), kind, block)
        if (value.row, offset) not in self._early:
            loaded = self.converted(self.load(value.row, offset, self._entry), kind, self._entry)
            self._early[value.row, offset] = loaded
        return self._early[value.row, offset]

    def taken(self, value: Value, block: str | None = None) -> Value:
        """Return a value with all its numbers loaded."""
        if isinstance(value, Record):
            return Record(value.sort, tuple(self.taken(item, block) for item in value.items))
        if isinstance(value, Stored):
            return Record(sort_of(value), tuple(self.taken(item, block) for item in self.items(value, block)))
        return value

    def joined(self, arrivals: Sequence[tuple[str, Value]]) -> Value:
        """Return what a value is in the block being written, to which others lead with values of theirs.

        Raises:
            NotTranslatedError: they are not of one kind.
        """
        values = [value for _, value in arrivals]
        if all(value == values[0] for value in values):
            return values[0]
        if all(isinstance(value, Scalar) for value in values):
            return self._joined(
                [block for block, _ in arrivals], [v for v in values if isinstance(v, Scalar)]
            )
        if len({(sort_of(value), _count(value)) for value in values}) > 1:
            raise NotTranslatedError("tuples of different types or lengths on different ways")
        # Item by item: what is the same on all ways may stay in memory.
        ways = [(block, self.items(value, block)) for block, value in arrivals]
        places = zip(*(items for _, items in ways), strict=True)
        blocks = [block for block, _ in ways]
        joined = (self.joined(list(zip(blocks, place, strict=True))) for place in places)
        return Record(sort_of(values[0]), tuple(joined))

    def items(self, value: Value, block: str | None = None) -> tuple[Value, ...]:
        """Return the items of a tuple; what lies in memory is not loaded unless it is a number."""
        if isinstance(value, Record):
            return value.items
        return tuple(self.member(value, i, block) for i in range(_count(value)))

    def chosen(self, value: Value, index: Scalar) -> Value:
        """Return the item of a tuple of items alike at an index that varies, and is none beyond it."""
        if isinstance(value, Stored):
            example = value.example[0]
            at = self.emit(WHOLE, f"mul i64 {index.text}, {size(example)}")
            row = self.element(value.row, self.emit(WHOLE, f"add i64 {at.text}, {value.offset}"))
            early, self._early = self._early, None  # where the row begins is known only here
            item = self.taken(self.member(Stored((example,), row.text, 0), 0))
            self._early = early
            return item
        result, *others = [self.taken(item) for item in self.items(value)]
        for i, other in enumerate(others, start=1):
            here = self.emit(TRUTH, f"icmp eq i64 {index.text}, {i}").text
            pairs = zip(scalars(other), scalars(result), strict=True)
            picked = [
                self.bounded(
                    self.emit(a.kind, f"select i1 {here}, {a.kind} {a.text}, {a.kind} {b.text}"), a, b
                )
                for a, b in pairs
            ]
            result = rebuilt(result, iter(picked))
        return result

    def _joined(self, blocks: Sequence[str], numbers: Sequence[Scalar]) -> Scalar:
        if all(number == numbers[0] for number in numbers):
            return numbers[0]
        kind = common_kind(numbers)
        numbers = [self.converted(n, kind, block) for n, block in zip(numbers, blocks, strict=True)]
        return self.bounded(self._first(kind, _phi(kind, zip(blocks, numbers, strict=True))), *numbers)

    def repeated(self, value: Value, before: str) -> tuple[Value, Callable[[str, Value], None]]:
        """Return what a value is at the head of a loop, entered from a block `before`.

        The function that comes with it is to be told from which block the loop goes round with which value.
        """
        taken = self.taken(value, before)
        heads = [self._first(number.kind, "") for number in scalars(taken)]
        head, numbers = self.block, list(scalars(taken))

        def close(block: str, after: Value) -> None:
            around = self.taken(after, block)
            if _structure(around) != _structure(taken):
                raise NotTranslatedError("a loop makes something of another type or length of a tuple")
            for place, first, again in zip(heads, numbers, scalars(around), strict=True):
                if common_kind([place, again]) != place.kind:
                    raise NotTranslatedError("a loop makes a whole number of what is a truth before it")
                again = self.converted(again, place.kind, block)
                text = _phi(place.kind, [(before, first), (block, again)])
                at = self._bodies[head].index(f"{place.text} = ")
                self._bodies[head][at] += text

        return rebuilt(taken, iter(heads)), close

    def _first(self, kind: str, text: str) -> Scalar:
        """Write an instruction at the beginning of the block."""
        self._count += 1
        name = f"%v{self._count}"
        self._bodies[self.block].insert(0, f"{name} = {text}")
        return Scalar(kind, name)


def _count(value: Value) -> int:
    """Return how many items a tuple has."""
    if isinstance(value, Record):
        return len(value.items)
    if not isinstance(value, Stored):
        raise NotTranslatedError("a number or a row is no tuple")
    return len(value.example)


def _structure(value: Value) -> Any:
    """Return the lengths and NamedTuples of a value all of whose numbers are loaded."""
    return (value.sort, *map(_structure, value.items)) if isinstance(value, Record) else None


def _phi(kind: str, arrivals: Iterable[tuple[str, Scalar]]) -> str:
    return f"phi {kind} " + ", ".join(f"[{number.text}, %{block}]" for block, number in arrivals)
