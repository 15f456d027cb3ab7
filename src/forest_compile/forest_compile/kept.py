"""Machine code that is kept: made once for a state of the sources, loaded within milliseconds ever after.

The object code lies in a cache under a digest of the interpreter, the processor, the translator and the laws'
sources. Only who asks for a kernel by `kernel` makes it; a node, which must start at once, asks whether
`is_ready`, and runs interpreted otherwise.
"""

import hashlib
import importlib.util
import os
import sys
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from types import ModuleType

from forest_compile import (
    flat,
    llvm_text,
    machine_code,
    translate,
    translate_expressions,
    translate_numbers,
    translate_statements,
    translate_whole,
)

COMPILER: tuple[ModuleType, ...] = (
    *(llvm_text, translate_whole, translate_numbers, translate_expressions, translate_statements, translate),
    *(machine_code, flat, sys.modules[__name__]),
)


class Kept:
    """One kernel.

    Args:
        name: what its file's name begins with.
        laws: modules of all that is translated, and of who writes the text.
        text: writes LLVM's text.
        arguments: of the kernel; see `machine_code.load`.
    """

    def __init__(
        self, name: str, laws: Sequence[ModuleType], text: Callable[[], str], arguments: str
    ) -> None:
        self._name, self._laws, self.text, self._arguments = name, laws, text, arguments
        self._loaded: machine_code.Kernel | None = None

    def kernel(self) -> machine_code.Kernel:
        """Return the function; it is made if need be.

        Raises:
            ModuleNotFoundError: llvmlite is not installed.
        """
        if self._loaded is None:
            try:
                code = self.file.read_bytes()
            except OSError:
                code = machine_code.optimised(self.text())
                machine_code.write(self.file, code)
            self._loaded = machine_code.load(code, self._arguments)
        return self._loaded

    @property
    def is_ready(self) -> bool:
        """Whether the code is there, or would have to be made first."""
        return can_compile() and self.file.exists()

    @cached_property
    def file(self) -> Path:
        """Where this version's object code lies for this interpreter and processor.

        Raises:
            ModuleNotFoundError: llvmlite is not installed.
        """
        digest = hashlib.sha256(f"{sys.version} {machine_code.processor()}".encode())
        for module in (*self._laws, *COMPILER):
            digest.update(Path(str(module.__file__)).read_bytes())
        return cache_directory() / f"{self._name}-{digest.hexdigest()[:24]}.o"


def can_compile() -> bool:
    """Tell whether compiled code can be made and loaded."""
    return importlib.util.find_spec("llvmlite") is not None


def cache_directory() -> Path:
    """Return where object code is kept."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "forest_sim"
