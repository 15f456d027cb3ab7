"""A function of LLVM's intermediate representation, written block by block.

A block is a stretch of instructions that is entered at its label alone and left at its end alone. Where
blocks meet, a phi instruction gives a value that depends on the block before. Each function returns null, or
a pointer to the text of a fault: of what ended it early.

Sums on the way to an integer may be larger than `LARGEST`: `bound` tells how much.
"""

from collections.abc import Callable, Iterator, Sequence

from forest_compile.ir.module import Module
from forest_compile.ir.values import (
    BOOLEAN,
    DOUBLE,
    INTEGER,
    LARGEST,
    POINTER,
    Array,
    NotTranslatedError,
    Record,
    Scalar,
    Shape,
    Stored,
    Value,
    common_kind,
    item_shapes,
    items,
    known,
    number,
    rebuilt,
    same_structure,
    scalars,
    shape,
    size,
)

Incoming = list[tuple[str, Scalar]]  # block and number


class Function:
    """A function in the making: its blocks, and the one that is being written.

    Args:
        module: knows the texts of faults.
    """

    def __init__(self, module: Module) -> None:
        self._module = module
        self._bodies: dict[str, list[str]] = {}
        self._phis: dict[str, list[tuple[Scalar, Incoming]]] = {}
        self._ends: dict[str, str] = {}
        self._fault_blocks: dict[str, str] = {}  # of a pointer to a fault's text
        self._stack: dict[tuple[int, int], str] = {}
        self._bounds: dict[str, int] = {}
        self._count = 0
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
        self._phis.setdefault(label, [])
        self.block, self.open = label, True

    def text(self) -> Iterator[str]:
        """Yield the function's lines."""
        for label, body in self._bodies.items():
            yield f"{label}:"
            for phi, incoming in self._phis[label]:
                ways = ", ".join(f"[{number.text}, %{block}]" for block, number in incoming)
                yield f"{phi.text} = phi {phi.kind} {ways}"
            yield from body
            yield self._ends[label]
        for pointer, label in self._fault_blocks.items():
            yield from (f"{label}:", f"ret ptr {pointer}")

    def emit(self, kind: str, text: str, block: str | None = None) -> Scalar:
        """Write an instruction, and return its result."""
        result = self._register(kind)
        self._bodies[block or self.block].append(f"{result.text} = {text}")
        return result

    def operate(self, instruction: str, left: Scalar, right: Scalar) -> Scalar:
        """Write an instruction on two numbers of one kind, and return its result."""
        kind = BOOLEAN if "cmp" in instruction else left.kind
        return self.emit(kind, f"{instruction} {left.kind} {left.text}, {right.text}")

    def select(self, condition: Scalar, yes: Scalar, no: Scalar) -> Scalar:
        """Return one number or another of the same kind."""
        text = f"select i1 {condition.text}, {yes.kind} {yes.text}, {no.kind} {no.text}"
        return self.bounded(self.emit(yes.kind, text), yes, no)

    def phi(self, kind: str, incoming: Incoming) -> Scalar:
        """Return the number that comes with the block before; what `incoming` is given later counts, too."""
        result = self._register(kind)
        self._phis[self.block].append((result, incoming))
        return result

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

    def meet(self, blocks: Sequence[str]) -> None:
        """Go on where several blocks lead that have no end yet."""
        end = self.label()
        for block in blocks:
            self.end(f"br label %{end}", block)
        self.start(end)

    def require(self, condition: Scalar, fault: str | Scalar) -> None:
        """Go on if a condition holds; else the function ends with a fault: a text, or what points to one."""
        pointer = fault.text if isinstance(fault, Scalar) else self._module.fault(fault)
        aside = self._fault_blocks.setdefault(pointer, f"fault{len(self._fault_blocks)}")
        further = self.label()
        self.end(f"br i1 {condition.text}, label %{further}, label %{aside}, !prof !0")
        self.start(further)

    def bound(self, value: Scalar) -> int:
        """Return what an integer or boolean is at most, on either side of zero."""
        constant = known(value)
        if constant is not None:
            return abs(constant)
        return 1 if value.kind == BOOLEAN else self._bounds.get(value.text, LARGEST)

    def bounded(self, value: Scalar, *among: Scalar, most: int = 0) -> Scalar:
        """Return an integer after noting that it is one of several, or at most so much."""
        if value.kind == INTEGER:
            self._bounds[value.text] = max([most, *map(self.bound, among)])
        return value

    def element(self, array: str, index: Scalar | int, block: str | None = None) -> str:
        """Return the address of a number of an array."""
        at = str(index) if isinstance(index, int) else index.text
        return self.emit(POINTER, f"getelementptr double, ptr {array}, i64 {at}", block).text

    def load(self, array: str, index: Scalar | int, block: str | None = None) -> Scalar:
        """Return a number of an array."""
        return self.emit(DOUBLE, f"load double, ptr {self.element(array, index, block)}, align 8", block)

    def store(self, value: Scalar, array: str, index: Scalar | int) -> None:
        """Write a number to an array."""
        double = self.converted(value, DOUBLE)
        text = f"store double {double.text}, ptr {self.element(array, index)}, align 8"
        self._bodies[self.block].append(text)

    def give_runtime(self, array: str) -> None:
        """Tell all functions where the numbers lie that are given when the kernel runs."""
        self._module.runtime = "@runtime"
        self._bodies[self.block].append(f"store ptr {array}, ptr {self._module.runtime}, align 8")

    def runtime(self, place: int) -> Scalar:
        """Return a number that is given when the kernel runs, by its place among such.

        Raises:
            NotTranslatedError: none are given.
        """
        if not self._module.runtime:
            raise NotTranslatedError("a number of the time when a kernel runs, but its entry is given none")
        return self.load(self.emit(POINTER, f"load ptr, ptr {self._module.runtime}, align 8").text, place)

    def loaded(self, of: Shape, array: str, offset: int, constant: bool = True) -> Value:
        """Return a value that lies in an array.

        Args:
            of: its shape.
            array: the array's address.
            offset: where in the array it begins.
            constant: whether the array stays as it is while the function runs.
        """
        if of == POINTER:
            return Array(array)
        if isinstance(of, str):
            return self.converted(self.load(array, offset), of)
        (sort, inner), at, parts = of, offset, []
        for item in inner:
            parts.append(self.loaded(item, array, at, constant))
            at += size(item)
        return Record(sort, tuple(parts), (array, offset) if constant else None)

    def stored(self, of: Shape, address: tuple[str, int], block: str | None = None) -> Value:
        """Return a value of a shape that lies in an array and stays as it is while the function runs.

        A number is loaded here, or at the end of a block; of a tuple, each where it is used. Loaded before
        that, those of ways not taken would be, too, and most would wait on the stack.
        """
        array, offset = address
        if of == POINTER:
            return Array(array)
        if isinstance(of, str):
            return self.converted(self.load(array, offset, block), of, block)
        return Stored(*of, address, self.stored)

    def address(self, value: Value, place: int) -> str:
        """Return the address of a value: where it lies, or on the stack until the next one of this place."""
        if isinstance(value, Array):
            return value.text
        if isinstance(value, Record | Stored) and value.address:
            return self.element(*value.address)
        numbers = list(scalars(value))
        array = self.stack(len(numbers), place)
        for i, scalar in enumerate(numbers):
            self.store(scalar, array, i)
        return array

    def stack(self, count: int, place: int) -> str:
        """Return the address of so many doubles on the stack; the same ones for the same place."""
        if (count, place) not in self._stack:
            array = self.emit(POINTER, f"alloca double, i64 {count}, align 8", self._entry)
            self._stack[count, place] = array.text
        return self._stack[count, place]

    def converted(self, value: Scalar, kind: str, block: str | None = None) -> Scalar:
        """Return a number as one of another kind; a double is cut to an integer as int() does.

        Whether it is small enough for that is for others to see.
        """
        if value.kind == kind:
            return value
        constant = known(value)
        if constant is not None and kind == INTEGER:
            return number(constant)
        if kind == BOOLEAN:
            test, zero = ("fcmp une", "0.0") if value.kind == DOUBLE else ("icmp ne", "0")
            return self.emit(BOOLEAN, f"{test} {value.kind} {value.text}, {zero}", block)
        ways = {DOUBLE: "fptosi", INTEGER: "sitofp", BOOLEAN: "uitofp" if kind == DOUBLE else "zext"}
        result = self.emit(kind, f"{ways[value.kind]} {value.kind} {value.text} to {kind}", block)
        return self.bounded(result, most=1) if value.kind == BOOLEAN else result

    def joined(self, arrivals: Sequence[tuple[str, Value]]) -> Value:
        """Return what a value is in the block being written, to which others lead with values of theirs.

        Raises:
            NotTranslatedError: they are not of one kind.
        """
        values = [value for _, value in arrivals]
        if all(value == values[0] for value in values):
            return values[0]
        numbers = [(block, value) for block, value in arrivals if isinstance(value, Scalar)]
        if len(numbers) == len(arrivals):
            return self.joined_number(numbers)
        records = [value for value in values if isinstance(value, Record | Stored)]
        kinds = {(value.sort, len(item_shapes(value))) for value in records}
        if len(records) < len(arrivals) or len(kinds) > 1:
            raise NotTranslatedError("tuples of different types or lengths on different ways")
        blocks = [block for block, _ in arrivals]
        columns = zip(*map(items, records, blocks), strict=True)
        joined = (self.joined(list(zip(blocks, column, strict=True))) for column in columns)
        return Record(records[0].sort, tuple(joined))

    def joined_number(self, arrivals: Incoming) -> Scalar:
        """Return what a number is in the block being written; all else as `joined`."""
        numbers = [value for _, value in arrivals]
        if all(value == numbers[0] for value in numbers):
            return numbers[0]
        kind = common_kind(numbers)
        incoming = [(block, self.converted(value, kind, block)) for block, value in arrivals]
        return self.bounded(self.phi(kind, incoming), *(value for _, value in incoming))

    def repeated(self, value: Value, before: str) -> tuple[Value, Callable[[str, Value], None]]:
        """Return what a value is at the head of a loop, entered from a block `before`.

        The function that comes with it is to be told from which block the loop goes round with which value.
        """
        ways: list[Incoming] = [[(before, scalar)] for scalar in scalars(value, before)]
        heads = [self.phi(incoming[0][1].kind, incoming) for incoming in ways]

        def close(block: str, after: Value) -> None:
            if not same_structure(shape(after), shape(value)):
                raise NotTranslatedError("a loop makes something of another type or length of a tuple")
            for head, incoming, again in zip(heads, ways, scalars(after), strict=True):
                if common_kind([head, again]) != head.kind:
                    raise NotTranslatedError("a loop makes a whole number of what is a truth before it")
                incoming.append((block, self.converted(again, head.kind, block)))

        return rebuilt(shape(value), iter(heads)), close

    def chosen(self, value: Record | Stored, index: Scalar) -> Value:
        """Return the item of a tuple of items alike at an index that varies, and is none beyond it."""
        if value.address:
            (alike, *_), (array, offset) = item_shapes(value), value.address
            at = self.operate("mul", index, number(size(alike)))
            at = self.operate("add", at, number(offset))
            return self.loaded(alike, self.element(array, at), 0)
        result, *others = items(value)
        for i, other in enumerate(others, start=1):
            here = self.operate("icmp eq", index, number(i))
            pairs = zip(scalars(other), scalars(result), strict=True)
            result = rebuilt(shape(result), iter([self.select(here, *pair) for pair in pairs]))
        return result

    def _register(self, kind: str) -> Scalar:
        self._count += 1
        return Scalar(kind, f"%v{self._count}")
