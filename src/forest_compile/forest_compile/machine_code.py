"""The laws as machine code on disk: `translate` writes LLVM's text, LLVM optimises, any process loads it.

Only LLVM is needed (llvmlite), and only for some seconds: what is kept is loaded within milliseconds.
"""

import ctypes
import ctypes.util
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ENTRY = "forest_kernel"
ARGUMENTS = {"p": ctypes.c_void_p, "d": ctypes.c_double, "i": ctypes.c_int64}
Kernel = Callable[..., None]
_MATHEMATICS = ("sin", "cos", "sincos", "exp", "acos", "atan2", "pow", "fmod")


def optimised(text: str) -> bytes:
    """Return the object code of LLVM's text on this processor.

    Raises:
        ModuleNotFoundError: llvmlite is not installed.
    """
    import llvmlite.binding as llvm

    machine = _target(llvm)
    head = f'target triple = "{machine.triple}"\ntarget datalayout = "{machine.target_data}"\n'
    module = llvm.parse_assembly(head + text)
    builder = llvm.create_pass_builder(machine, llvm.PipelineTuningOptions(speed_level=3))
    builder.getModulePassManager().run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


def load(code: bytes, arguments: str) -> Kernel:
    """Return the function `ENTRY` of object code made on this processor.

    It releases Python's lock while it runs, so that threads run side by side. It raises ArithmeticError where
    the laws end with a fault, see `translate_numbers`.

    Args:
        code: from `optimised`.
        arguments: a letter for each: p pointer to doubles, d double, i whole number.

    Raises:
        ModuleNotFoundError: llvmlite is not installed.
    """
    import llvmlite.binding as llvm

    machine = _target(llvm)
    library = ctypes.CDLL(ctypes.util.find_library("m"))
    for name in _MATHEMATICS:
        llvm.add_symbol(name, ctypes.cast(getattr(library, name), ctypes.c_void_p).value)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    prototype = ctypes.CFUNCTYPE(ctypes.c_char_p, *(ARGUMENTS[letter] for letter in arguments))
    function = prototype(engine.get_function_address(ENTRY))

    def kernel(*values: Any) -> None:
        fault: bytes | None = function(*values)
        if fault:
            raise ArithmeticError(fault.decode())

    kernel.keep = (engine, library)  # type: ignore[attr-defined]  # as long as the function lives
    return kernel


def processor() -> str:
    """Return what object code is bound to: LLVM's version and this processor's name and abilities.

    Raises:
        ModuleNotFoundError: llvmlite is not installed.
    """
    import llvmlite
    import llvmlite.binding as llvm

    return f"{llvmlite.__version__} {llvm.get_host_cpu_name()} {llvm.get_host_cpu_features().flatten()}"


def _target(llvm: Any) -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(
        opt=3,
        jit=True,
        codemodel="jitdefault",
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
    )


def write(path: Path, code: bytes) -> None:
    """Write a file that others see whole or not at all; a folder that cannot be written is no error."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(code)
        Path(name).replace(path)
    except OSError:
        return
