"""A kernel's functions, which are ordinary Python, become LLVM's intermediate representation (IR).

The subset:

- functions of numbers and nested tuples of numbers, without effects;
- assignment, `if`, `for` over a range, `while`, `break`, `else`, `return`;
- calls by position and by keyword, defaults, NamedTuples and their `_replace`, but no `*` or `**`;
- arithmetic, comparison, and the functions in `arithmetic`, where also stands what becomes of Python's
  errors.

All else is refused (`NotTranslatedError`), with function, file and line. A variable is of one kind on every
way: double, integer, boolean, or a tuple of one type. One that is not may not be used. Names outside of
functions mean what they meant when the text was written. A square is the C library's power, as in Python; a
product is faster.

Each call is inlined, so that LLVM sees the plant in one piece, except of functions that the entry names
(`noinline`). `benchmarks/compilers.py` measures this against a compiler for much more of Python (Numba).
"""

import ast
from collections.abc import Iterator
from contextlib import contextmanager
from types import CodeType, FunctionType

from forest_compile import fingerprint
from forest_compile.entry import RUNTIME, Entry
from forest_compile.flat_layout import leaves
from forest_compile.frontend.arithmetic import EXTERNAL
from forest_compile.frontend.frame import Frame, syntax_tree
from forest_compile.frontend.statements import Statements
from forest_compile.ir.function import Function
from forest_compile.ir.module import Module
from forest_compile.ir.values import (
    DOUBLE,
    INTEGER,
    POINTER,
    Array,
    NotTranslatedError,
    Scalar,
    Shape,
    Value,
    constant,
    number,
    scalars,
    shape,
    size,
)
from forest_compile.machine_code import ENTRY

_KINDS = {"d": DOUBLE, "i": INTEGER}
_NULL = Scalar(POINTER, "null")
_RESULT = -1  # its place on the stack


def llvm_ir(entry: Entry) -> str:
    """Return an entry as LLVM's text.

    Raises:
        NotTranslatedError: something in it, or in a function that it calls, is outside the subset; or a
            function's file does not say what was imported.
    """
    for function in fingerprint.changed(entry):
        raise NotTranslatedError(
            f"{function.__module__}.{function.__qualname__}: {function.__code__.co_filename} was changed "
            "after it was imported; start again"
        )
    module = Module(dict(EXTERNAL.values()))
    _Kernel(module, entry).write()
    return "\n".join(module.text())


class _Kernel(Statements):
    """Writes functions into a module."""

    def __init__(self, module: Module, entry: Entry) -> None:
        self._module, self._entry = module, entry
        self._known: dict[tuple[FunctionType, tuple[Shape, ...]], tuple[str, Shape]] = {}
        self.into, self.frames = Function(module), []

    def write(self) -> None:
        """Write the function that the world calls: it returns null, or the text of a fault."""
        entry = self._entry
        (node,), (code, *_) = ast.parse(entry.text).body, compile(entry.text, ENTRY, "exec").co_consts
        if not (isinstance(node, ast.FunctionDef) and isinstance(code, CodeType)):
            raise NotTranslatedError("the entry's source is no function", ENTRY)
        frame, parameters = Frame(ENTRY, code, entry.names), []
        shapes = {argument: shape(constant(example)) for argument, example in entry.tuples.values()}
        for letter, argument in zip(entry.arguments, [a.arg for a in node.args.args], strict=True):
            register = f"%{argument}"
            if letter == "p":
                parameters.append(_pointer(register, shapes.get(argument, POINTER), "noalias"))
                frame.variables[argument] = Array(register)
            else:
                parameters.append(f"{_KINDS[letter]} {register}")
                frame.variables[argument] = Scalar(_KINDS[letter], register)
        frame.variables |= self._tuples(node)
        with self._within(frame):
            if RUNTIME in frame.variables:
                self.into.give_runtime(f"%{RUNTIME}")
            self.run(node.body)
        self.into.end("ret ptr null")
        self._module.define(f"ptr @{ENTRY}({', '.join(parameters)}) nounwind", self.into.text())

    def _tuples(self, node: ast.FunctionDef) -> dict[str, Value]:
        """Return the tuples that lie in the entry's arguments, once integers are known to be such."""
        named, tuples = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}, {}
        for name, (argument, example) in self._entry.tuples.items():
            for at, (path, leaf) in enumerate(leaves(example, name)):
                kind = number(leaf).kind
                if kind != DOUBLE:
                    self.require_stored(f"%{argument}", at, f"{ENTRY}: {path}", kind)
            layout = shape(constant(example))
            tuples[name] = self.into.loaded(layout, f"%{argument}", 0, argument not in named)
        return tuples

    def call(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a model function gives, inlined or by a call."""
        if any(frame.function is function for frame in self.frames):
            raise NotTranslatedError(f"{function.__qualname__!r} calls itself")
        if function not in self._entry.noinline:
            return self._inlined(function, arguments)
        arguments = [self.settled(argument) for argument in arguments]
        key = function, tuple(map(shape, arguments))
        if key not in self._known:
            self._known[key] = self._defined(*key)
        name, result = self._known[key]
        given = [self.into.address(argument, place) for place, argument in enumerate(arguments)]
        given.append(self.into.stack(size(result), _RESULT))
        text = ", ".join(f"ptr {address}" for address in given)
        fault = self.into.emit(POINTER, f"call ptr @{name}({text})")
        self.into.require(self.into.operate("icmp eq", fault, _NULL), fault)
        return self.into.loaded(result, given[-1], 0, constant=False)

    def _inlined(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a model function gives, its statements written here.

        Raises:
            NotTranslatedError: something in it is outside the subset; the error tells the place.
        """
        name = f"{function.__module__}.{function.__qualname__}"
        with self._within(Frame(name, function.__code__, function.__globals__, function)):
            node = syntax_tree(function)
            names = (a.arg for a in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs))
            self.frame.variables = dict(zip(names, arguments, strict=True))
            self.run(node.body)
            return self.returned()

    def _defined(self, function: FunctionType, shapes: tuple[Shape, ...]) -> tuple[str, Shape]:
        """Write a function of arguments in memory; return its name, and its result's shape."""
        outer, self.into = self.into, Function(self._module)
        result = self._inlined(function, [self.into.stored(of, (f"%a{i}", 0)) for i, of in enumerate(shapes)])
        for i, scalar in enumerate(scalars(result)):
            self.into.store(scalar, "%result", i)
        self.into.end("ret ptr null")
        name = f"{function.__name__}.{len(self._known)}"
        parameters = [
            _pointer(f"%a{i}", of, "" if of == POINTER else "noalias readonly") for i, of in enumerate(shapes)
        ]
        parameters.append(_pointer("%result", shape(result), "noalias"))
        self._module.define(f"internal ptr @{name}({', '.join(parameters)}) #1", self.into.text())
        self.into = outer
        return name, shape(result)

    @contextmanager
    def _within(self, frame: Frame) -> Iterator[None]:
        """Translate a call; give what is refused meanwhile its place, and whatever else fails, too."""
        self.frames.append(frame)
        try:
            yield
        except NotTranslatedError as error:
            if error.place:
                raise
            raise NotTranslatedError(error.message, frame.place()) from error
        except Exception as error:
            raise NotTranslatedError(f"not translated, for {error!r}", frame.place()) from error
        finally:
            self.frames.pop()


def _pointer(register: str, of: Shape, attributes: str) -> str:
    """Return a parameter that points to a value of a shape, or to an array."""
    behind = "" if of == POINTER else f"dereferenceable({8 * size(of)}) align 8"
    return f"ptr {attributes} {behind} {register}"
