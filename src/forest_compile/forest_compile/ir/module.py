"""LLVM's module as text: declared functions, the texts of faults, defined functions.

It is text, not llvmlite's own builder (`llvmlite.ir`): 85 000 instructions, those of the plant, the
controller, the valve driver and the loop, take 1.05 s to build and print there, and 0.06 s here. LLVM needs
6.5 s for them.
"""

from collections.abc import Iterable, Iterator, Mapping


class Module:
    """Functions and texts that are being written.

    Args:
        externals: functions of the C library and of LLVM: name to the count of their arguments, all doubles.
    """

    def __init__(self, externals: Mapping[str, int]) -> None:
        self._externals = externals
        self._faults: dict[str, str] = {}
        self._lines: list[str] = []
        self.runtime = ""
        """Name of what points to the numbers that are given when the kernel runs; "": none are."""

    def fault(self, text: str) -> str:
        """Return the name of a fault's text."""
        return self._faults.setdefault(text, f"@fault.{len(self._faults)}")

    def define(self, head: str, body: Iterable[str]) -> None:
        """Add a function.

        Args:
            head: all before its body.
            body: its lines.
        """
        self._lines += [f"define {head} {{", *body, "}"]

    def text(self) -> Iterator[str]:
        """Yield all lines."""
        for name, count in sorted(self._externals.items()):
            given = ", ".join(["double"] * count)
            yield f"declare double @{name}({given}) #{2 if name == 'pow' else 0}"
        for text, name in self._faults.items():
            code = text.encode()
            plain = "".join(chr(b) if 31 < b < 127 and b not in b'"\\' else f"\\{b:02x}" for b in code)
            yield f'{name} = private unnamed_addr constant [{len(code) + 1} x i8] c"{plain}\\00"'
        if self.runtime:
            yield f"{self.runtime} = internal global ptr null, align 8"
        yield from self._lines
        yield "attributes #0 = { nounwind willreturn speculatable memory(none) }"
        yield "attributes #1 = { nounwind noinline }"
        # Not for LLVM to replace: its root for a power of 0.5 is another last bit than CPython's.
        yield "attributes #2 = { nounwind willreturn speculatable memory(none) nobuiltin }"
        yield '!0 = !{!"branch_weights", i32 1000000, i32 1}'  # of what a fault leaves aside
