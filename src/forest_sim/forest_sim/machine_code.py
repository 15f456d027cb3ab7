"""Python functions as machine code on disk: Numba translates, LLVM optimises, any process loads the result.

Numba alone keeps the laws as functions of their own, which hand each other records of hundreds of numbers; in
one piece the plant is three to four times as fast. And a process that only loads the object needs LLVM, not
Numba: half the memory, and no second of start-up.
"""

import ctypes
import ctypes.util
import os
import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ENTRY = "forest_kernel"
ARGUMENTS = {"p": ctypes.c_void_p, "d": ctypes.c_double, "i": ctypes.c_int64}
Kernel = Callable[..., int]
_MATHEMATICS = ("sin", "cos", "sincos", "sqrt", "exp", "sinh", "cosh", "hypot", "atan2", "acos", "pow")


def translate(function: Callable[..., None], arguments: str, kept_apart: tuple[str, ...]) -> bytes:
    """Return the object code of a function on this processor.

    Args:
        function: written for Numba; it returns nothing.
        arguments: a letter for each: p pointer to doubles, d double, i whole number.
        kept_apart: names of functions that are seldom called and would only make the whole larger.

    Raises:
        ModuleNotFoundError: numba is not installed.
    """
    import llvmlite.binding as llvm
    import numba
    from numba import types

    kinds = {"p": types.CPointer(types.float64), "d": types.float64, "i": types.int64}
    signature = types.void(*(kinds[letter] for letter in arguments))
    text = numba.cfunc(signature, error_model="numpy")(function).inspect_llvm()
    module = llvm.parse_assembly(_in_one_piece(text, kept_apart))
    machine = _target(llvm)
    builder = llvm.create_pass_builder(machine, llvm.PipelineTuningOptions(speed_level=3))
    builder.getModulePassManager().run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


def _in_one_piece(text: str, kept_apart: tuple[str, ...]) -> str:
    """Return LLVM's text with one entry, without Numba's wrapper for Python, all else to be inlined."""
    wrapped = re.search(r'^define [^\n]*@("?)cfunc\.(.*?)\1\(', text, re.MULTILINE)
    if wrapped is None:
        raise RuntimeError("Numba's code has changed: no C function in it")
    entry = wrapped.group(2)
    text = re.sub(r'^define [^\n]*@"?cfunc\..*?^}\n', "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(rf'@"?{re.escape(entry)}"?\(', f"@{ENTRY}(", text)

    def inlined(line: re.Match[str]) -> str:
        head = line.group(1)
        if f"@{ENTRY}(" in head:
            return head.replace("linkonce_odr ", "") + "{"
        return head + ("{" if any(name in head for name in kept_apart) else "alwaysinline {")

    text = re.sub(r"^(define [^\n]*?)\{$", inlined, text, flags=re.MULTILINE)
    return re.sub(r"\bnoinline\b", "nounwind", text)


def load(code: bytes, arguments: str) -> Kernel:
    """Return the function of object code made by `translate` on this processor, for the same arguments.

    It returns zero, or what Numba's code gives for an error.

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
    kinds = (ARGUMENTS[letter] for letter in arguments)
    prototype = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *kinds)
    function = prototype(engine.get_function_address(ENTRY))
    nothing = ctypes.c_void_p(), ctypes.c_void_p()
    result, error = ctypes.addressof(nothing[0]), ctypes.addressof(nothing[1])

    def kernel(*values: Any) -> int:
        status: int = function(result, error, *values)
        return status

    kernel.keep = (engine, library, nothing)  # type: ignore[attr-defined]  # as long as the function lives
    return kernel


def check(status: int) -> None:
    """Raise ArithmeticError if a kernel did not return zero."""
    if status != 0:
        raise ArithmeticError(f"the compiled plant stopped with status {status}")


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
