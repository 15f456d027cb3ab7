"""A core's step as machine code, behind the same call: `step(state, *inputs, p, dt) -> (state, output)`.

State, inputs, parameters and output are nested NamedTuples of numbers, each of one shape. They lie flat for
the machine code (`flat_layout`). Parameters seldom change, and a loop hands back the state that it was given:
both are laid out again only if they are others. A state is built for Python only when somebody looks at it.
"""

import ctypes
import struct
from collections.abc import Callable
from functools import cached_property
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
        step: the function.
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
        text="\n".join(lines),
        names={"step": step},
        arguments=ARGUMENTS,
        tuples={
            "before": ("state", example.state),
            "given": ("inputs", example.inputs),
            "p": ("parameters", example.p),
        },
        noinline=noinline,
    )


class FlatBuffer:
    """Memory in which a nested tuple lies flat."""

    def __init__(self, example: Any) -> None:
        self._pack, self._unpack = flat_layout.packer(example), flat_layout.unpacker(example)
        self._numbers = struct.Struct(f"{sum(1 for _ in flat_layout.leaves(example, ''))}d")
        self._memory = ctypes.create_string_buffer(self._numbers.size)
        self.address = ctypes.addressof(self._memory)

    def store(self, value: Any) -> None:
        """Lay a tuple out."""
        self._numbers.pack_into(self._memory, 0, *self._pack(value))

    def copy(self) -> bytes:
        """Return a copy of what lies here, for `build`."""
        return self._memory.raw

    def build(self, numbers: bytes) -> Any:
        """Build a tuple."""
        return self._unpack(self._numbers.unpack(numbers))


class LazyState:
    """A state as a step left it; it is built when somebody looks at it."""

    def __init__(self, buffer: FlatBuffer) -> None:
        self._bytes, self._build = buffer.copy(), buffer.build

    @cached_property
    def built(self) -> Any:
        """The state."""
        return self._build(self._bytes)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.built, name)


class CompiledStep:
    """The call.

    Args:
        kernel: the loaded code of `entry`.
        example: as of `entry`.
    """

    def __init__(self, kernel: machine_code.Kernel, example: Example) -> None:
        self._kernel, self._buffers = kernel, [FlatBuffer(part) for part in example]
        self._addresses = [buffer.address for buffer in self._buffers]
        self._p: Any = None  # parameters that lie flat
        self._after: LazyState | None = None  # the state that does

    def __call__(self, state: Any, *arguments: Any) -> tuple[Any, Any]:
        """Return the state a step later, and the output; arguments are the inputs, the parameters, dt [s]."""
        *inputs, p, dt = arguments
        states, given, parameters, output = self._buffers
        if p is not self._p:
            self._p = p
            parameters.store(p)
        if state is not self._after:
            states.store(state.built if isinstance(state, LazyState) else state)
        given.store(inputs)
        self._after = None  # the kernel overwrites it, if only in part where it ends with a fault
        self._kernel(*self._addresses, dt)
        self._after = LazyState(states)
        return self._after, output.build(output.copy())
