"""A core's step as machine code, behind the same call: `step(state, *inputs, p, dt) -> (state, output)`.

State, inputs, parameters and output are nested NamedTuples of numbers, each of one shape, and lie flat for
the machine code (`flat`). Parameters seldom change, and a loop hands back the state that it was given: both
are laid out again only if they are others. So a state is built for Python only when somebody looks at it.
"""

import ctypes
import struct
from collections.abc import Callable
from typing import Any, NamedTuple

from forest_compile import flat_layout, machine_code
from forest_compile.entry import Entry

ARGUMENTS = "ppppd"  # state, inputs, parameters, output; dt
_HEAD = "def kernel(state, inputs, parameters, output, dt):"


class Example(NamedTuple):
    """What a step takes and gives; any numbers will do."""

    state: Any
    inputs: tuple[Any, ...]
    p: Any
    output: Any


def entry(step: Callable[..., Any], example: Example, noinline: tuple[Callable[..., Any], ...]) -> Entry:
    """Return what a step's kernel is made of.

    Args:
        step: of the laws.
        example: of what it takes and gives.
        noinline: functions whose calls stay calls.
    """
    given = ", ".join(f"given[{i}]" for i in range(len(example.inputs)))
    lines = [
        _HEAD,
        f"    after, result = step(before, {given}, p, dt)",
        *(
            f"    state[{i}] = {path}"
            for i, (path, _) in enumerate(flat_layout.leaves(example.state, "after"))
        ),
        *(
            f"    output[{i}] = {path}"
            for i, (path, _) in enumerate(flat_layout.leaves(example.output, "result"))
        ),
    ]
    return Entry(
        *("\n".join(lines), {"step": step}, ARGUMENTS),
        {
            "before": ("state", example.state),
            "given": ("inputs", example.inputs),
            "p": ("parameters", example.p),
        },
        noinline,
    )


class Row:
    """A nested tuple that lies flat."""

    def __init__(self, example: Any) -> None:
        self._pack, self._unpack = flat_layout.packer(example), flat_layout.unpacker(example)
        self._numbers = struct.Struct(f"{sum(1 for _ in flat_layout.leaves(example, ''))}d")
        self._row = ctypes.create_string_buffer(self._numbers.size)
        self.at = ctypes.addressof(self._row)

    def store(self, value: Any) -> None:
        """Lay a tuple out."""
        self._numbers.pack_into(self._row, 0, *self._pack(value))

    def restore(self) -> Any:
        """Build the tuple that lies here."""
        return self.build(self.copy())

    def copy(self) -> bytes:
        """Return the numbers that lie here, for `build`."""
        return self._row.raw

    def build(self, numbers: bytes) -> Any:
        """Build a tuple."""
        return self._unpack(self._numbers.unpack(numbers))


class Moved:
    """A state as a step left it; it is built when somebody looks at it."""

    def __init__(self, row: Row) -> None:
        self._numbers, self._build = row.copy(), row.build
        self._built: Any = None

    def built(self) -> Any:
        """Return the state."""
        if self._built is None:
            self._built = self._build(self._numbers)
        return self._built

    def __getattr__(self, name: str) -> Any:
        return getattr(self.built(), name)


class CompiledStep:
    """The call.

    Args:
        kernel: the loaded code of `entry`.
        example: as of `entry`.
    """

    def __init__(self, kernel: machine_code.Kernel, example: Example) -> None:
        self._kernel = kernel
        self._state, self._inputs, self._p, self._output = map(Row, example)
        self._at = tuple(row.at for row in (self._state, self._inputs, self._p, self._output))
        self._known: Any = None  # parameters that lie flat
        self._moved: Moved | None = None  # the state that does

    def __call__(self, state: Any, *arguments: Any) -> tuple[Any, Any]:
        """Return the state a step later, and the output; arguments are the inputs, the parameters, dt [s]."""
        *inputs, p, dt = arguments
        if p is not self._known:
            self._known = p
            self._p.store(p)
        if state is not self._moved:
            self._state.store(state.built() if isinstance(state, Moved) else state)
        self._inputs.store(inputs)
        self._moved = None  # the kernel overwrites it, if only in part where it ends with a fault
        self._kernel(*self._at, dt)
        self._moved = Moved(self._state)
        return self._moved, self._output.restore()
