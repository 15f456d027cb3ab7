"""LLVM's text becomes machine code, and machine code a function.

Only making the code needs LLVM (llvmlite), and some seconds. Linked to a shared object, which needs a
linker of the system, the code is loaded by ctypes. Unlinked object code is loaded by llvmlite, which costs
50 MB of memory. Both have the same instructions.
"""

import contextlib
import ctypes
import importlib.metadata
import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ENTRY = "forest_kernel"
ARGUMENTS = {"p": ctypes.c_void_p, "d": ctypes.c_double, "i": ctypes.c_int64}
Kernel = Callable[..., None]
LINKERS = ("ld", "ld.lld", "cc", "gcc")
_LINK_S = 60.0
_MATHEMATICS = ("sin", "cos", "sincos", "exp", "log", "acos", "atan2", "pow", "fmod")
_LIBM = "libm.so.6"
# What of /proc/cpuinfo decides which instructions there are; clock and core numbers do not.
_PROCESSOR = {"vendor_id", "cpu family", "model", "model name", "stepping", "flags"}


def optimised(text: str) -> bytes:
    """Return the object code of LLVM's text on this processor.

    Raises:
        ModuleNotFoundError: llvmlite is not installed.
    """
    import llvmlite.binding as llvm

    machine = _target(llvm)
    head = f'target triple = "{machine.triple}"\ntarget datalayout = "{machine.target_data}"\n'
    module = llvm.parse_assembly(head + text)
    # Sums side by side become one of a vector: each still rounds as it does alone.
    options = llvm.PipelineTuningOptions(speed_level=3)
    options.slp_vectorization = True
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


def linked(code: bytes) -> bytes:
    """Return object code as a shared object.

    Raises:
        OSError: no linker of the system makes one.
    """
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder, "kernel.o"), Path(folder, "kernel.so")
        given.write_bytes(code)
        for linker in filter(None, map(shutil.which, LINKERS)):
            command = [linker, "-shared", "-nostdlib", "-o", str(made), str(given), *_mathematics()]
            with contextlib.suppress(OSError, subprocess.SubprocessError):
                subprocess.run(command, check=True, capture_output=True, timeout=_LINK_S)
                return made.read_bytes()
    raise OSError(f"no linker of the system links; looked for: {', '.join(LINKERS)}")


def load_shared(code: bytes, arguments: str) -> Kernel:
    """Return the function `ENTRY` of a shared object; all else as `load`.

    It is loaded from memory, so that what becomes of its file meanwhile does not matter.

    Raises:
        OSError: the system does not load it.
    """
    handle = os.memfd_create(ENTRY)
    path = f"/proc/self/fd/{handle}"
    try:
        Path(path).write_bytes(code)
        library = ctypes.CDLL(path)
    except OSError:
        os.close(handle)
        raise
    # It stays open: under the same path again, the loader would take the next for this one.
    return _callable(ctypes.cast(library[ENTRY], ctypes.c_void_p).value, arguments, library)


def load(code: bytes, arguments: str) -> Kernel:
    """Return the function `ENTRY` of object code made on this processor.

    It releases Python's lock while it runs, so that threads run side by side. It raises ArithmeticError where
    the model functions end with a fault, see `frontend.arithmetic`.

    Args:
        code: from `optimised`.
        arguments: a letter for each: p pointer to doubles, d double, i integer.

    Raises:
        ModuleNotFoundError: llvmlite is not installed.
    """
    import llvmlite.binding as llvm

    machine = _target(llvm)
    library = ctypes.CDLL(_LIBM)
    for name in _MATHEMATICS:
        llvm.add_symbol(name, ctypes.cast(getattr(library, name), ctypes.c_void_p).value)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return _callable(engine.get_function_address(ENTRY), arguments, engine, library)


def _callable(at: Any, arguments: str, *keep: Any) -> Kernel:
    """Return a function at an address as one of Python's, which keeps alive what its code needs."""
    function = ctypes.CFUNCTYPE(ctypes.c_char_p, *(ARGUMENTS[letter] for letter in arguments))(at)

    def kernel(*values: Any) -> None:
        fault: bytes | None = function(*values)
        if fault:
            raise ArithmeticError(fault.decode())

    kernel.keep = keep  # type: ignore[attr-defined]
    return kernel


def bound_to() -> str:
    """Return what machine code is bound to, but for its source: LLVM's release and this processor.

    It does not import llvmlite.
    """
    try:
        llvm = importlib.metadata.version("llvmlite")
    except importlib.metadata.PackageNotFoundError:
        llvm = "none"
    first, *_ = Path("/proc/cpuinfo").read_text(encoding="utf-8").split("\n\n")
    facts = (line.partition(":") for line in first.splitlines())
    known = sorted((name.strip(), value.strip()) for name, _, value in facts if name.strip() in _PROCESSOR)
    return f"{llvm} {platform.machine()} {known}"


def _target(llvm: Any) -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(
        opt=3,
        reloc="pic",  # as a shared object needs it
        codemodel="small",
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
    )


def _mathematics() -> list[str]:
    """Return the path of the C library's mathematics, as this process has it."""
    ctypes.CDLL(_LIBM)
    maps = Path("/proc/self/maps").read_text(encoding="utf-8").splitlines()
    return [line.split(maxsplit=5)[5] for line in maps if line.endswith(_LIBM)][:1]
