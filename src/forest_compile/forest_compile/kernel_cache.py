"""The kernel cache: machine code is made once for a state of the sources, then loaded within milliseconds.

The code lies in a file under a digest of the kernel's entry and of all that its source means
(`fingerprint`), of the translator's sources, the interpreter, LLVM's release and the processor. Only who
asks for a `kernel` makes it. A node, which must start at once, asks for what is `ready`, and runs
interpreted otherwise.
"""

import contextlib
import hashlib
import importlib.util
import logging
import sys
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

from forest_compile import fingerprint, kernel_files, machine_code
from forest_compile.entry import Entry

_log = logging.getLogger(__name__)


class CachedKernel:
    """One kernel.

    Args:
        name: what its file's name begins with.
        entry: returns what the kernel is made of.
    """

    def __init__(self, name: str, entry: Callable[[], Entry]) -> None:
        self.name, self._entry = name, entry
        self._loaded: machine_code.Kernel | None = None

    def kernel(self) -> machine_code.Kernel:
        """Return the function; it is made if need be.

        Raises:
            ModuleNotFoundError: llvmlite is not installed.
        """
        if self._loaded is None:
            self._loaded = self._found("it is made anew")
        if self._loaded is None:
            with kernel_files.claimed() as waited:
                self._loaded = (self._found("it is made anew") if waited else None) or self._made()
        return self._loaded

    def ready(self) -> machine_code.Kernel | None:
        """Return the function if its code is there; None if it would have to be made."""
        if self._loaded is None:
            self._loaded = self._found("its laws run interpreted")
        return self._loaded

    @property
    def file(self) -> Path | None:
        """Where the code lies that the next process will use; None if there is none."""
        with contextlib.suppress(OSError):
            return next((f for f in (self._shared, self._object) if kernel_files.read(f) is not None), None)
        return None

    @cached_property
    def entry(self) -> Entry:
        """What the kernel is made of."""
        return self._entry()

    @cached_property
    def _shared(self) -> Path:
        mark = hashlib.sha256(f"{sys.version} {machine_code.bound_to()}".encode())
        for source in sorted(Path(__file__).parent.rglob("*.py")):
            mark.update(source.read_bytes())
        mark.update(fingerprint.digest(self.entry).encode())
        return kernel_files.directory() / f"{self.name}-{mark.hexdigest()[:24]}.so"

    @property
    def _object(self) -> Path:
        return self._shared.with_suffix(".o")

    def _found(self, otherwise: str) -> machine_code.Kernel | None:
        """Return the function if its code is there; say what is there but not used."""
        return self._loads(self._shared, otherwise) or self._loads(self._object, otherwise)

    def _loads(self, file: Path, otherwise: str) -> machine_code.Kernel | None:
        try:
            code = kernel_files.read(file)
            if code is not None and file == self._shared:
                return machine_code.load_shared(code, self.entry.arguments)
            if code is not None and can_compile():
                return machine_code.load(code, self.entry.arguments)
        except OSError as error:
            _log.warning("the machine code of %s is not used: %s; %s", self.name, error, otherwise)
        return None

    def _made(self) -> machine_code.Kernel:
        from forest_compile.frontend import translate

        code = machine_code.optimised(translate.llvm_ir(self.entry))
        try:
            file, made = self._shared, machine_code.linked(code)
            kernel = machine_code.load_shared(made, self.entry.arguments)
        except OSError:  # there is no linker, or the system does not load what it makes
            file, made = self._object, code
            kernel = machine_code.load(code, self.entry.arguments)
        try:
            kernel_files.write(file, made)
        except OSError as error:
            _log.warning("the machine code of %s cannot be kept: %s", self.name, error)
        return kernel


def can_compile() -> bool:
    """Tell whether machine code can be made."""
    return importlib.util.find_spec("llvmlite") is not None


def make(*kernels: CachedKernel) -> int:
    """Make kernels that are not there, and print where they are.

    Returns:
        The exit code of a program that does no more: 1 if nodes will run interpreted.
    """
    if not can_compile():
        print("llvmlite is not installed")
        return 1
    for kernel in kernels:
        kernel.kernel()
        if kernel.file is None:
            return 1  # the log says why
        print(kernel.file)
    return 0
