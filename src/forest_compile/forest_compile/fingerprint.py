"""Whether a kernel on disk is still what its model functions would give: a digest of all that decides it.

The digest follows the names in the bytecode through what is imported: functions, numbers, tuples and types.
It reads no source, since a node computes it at every start; 120 functions take about a millisecond. A name
counts even where the bytecode means a field of the same name: the digest covers a little too much, never too
little. Strings do not count: no model function can use them.
"""

import hashlib
import re
from collections.abc import Callable, Iterator
from importlib.machinery import SourceFileLoader
from types import CodeType, FunctionType
from typing import Any

from forest_compile.entry import RUNTIME, Entry, RuntimeNumber

Names = frozenset[str]
_PARTS = (
    *("co_code", "co_exceptiontable", "co_flags", "co_argcount", "co_posonlyargcount"),
    *("co_kwonlyargcount", "co_names", "co_varnames", "co_freevars", "co_cellvars"),
    *("co_firstlineno", "co_linetable"),  # a kernel may name the place of what fails in it
)


def digest(entry: Entry) -> str:
    """Return what changes with the entry, or with a function, number or type that its names lead to."""
    return hashlib.sha256(repr(_Fingerprint(entry).words).encode()).hexdigest()


def functions(entry: Entry) -> list[FunctionType]:
    """Return the functions that the entry's names lead to."""
    return [one for one in _Fingerprint(entry).known if isinstance(one, FunctionType)]


def changed(entry: Entry) -> Iterator[FunctionType]:
    """Yield functions whose file does not say what was imported, while it is the file that is translated."""
    files: dict[str, list[list[Any]]] = {}
    for one in functions(entry):
        if one.__qualname__.isidentifier():  # a method is no model function
            path = one.__code__.co_filename
            if path not in files:
                files[path] = _written(path)
            if files[path] and _words(one.__code__) not in files[path]:
                yield one


def _written(path: str) -> list[list[Any]]:
    """Return what a file's functions do, and in which lines; nothing if it is no file."""
    try:
        code = SourceFileLoader(path, path).get_code(path)  # quick, for Python keeps it
    except OSError:
        return []
    return [_words(inner) for inner in _inner(code)] if code else []


class _Fingerprint:
    """All that decides a kernel, as words."""

    def __init__(self, entry: Entry) -> None:
        self.words: list[Any] = [entry.text, entry.arguments, sorted(entry.tuples)]
        self.known: dict[type | FunctionType, int] = {}
        names = frozenset(re.findall(r"\w+", entry.text))
        for name, value in sorted(entry.names.items()):
            self.words.append(name)
            self._value(value, names)
        for name, (argument, example) in entry.tuples.items():
            self.words += [name, argument]
            self._layout(example)
        self.words.append([self.known[function] for function in entry.noinline if function in self.known])

    def _value(self, value: Any, names: Names = frozenset(), within: tuple[Any, ...] = ()) -> None:
        """Add what a name means; `names` are those by which its attributes may be called."""
        if isinstance(value, RuntimeNumber):
            self.words += [RUNTIME, value.place]
        elif isinstance(value, int | float):
            self.words.append(_kind(value)(value))
        elif isinstance(value, tuple):
            self._items(value, self._value)
        elif isinstance(value, FunctionType):
            self._function(value)
        else:  # a module, a type, a function of the C library; or something that no model function can use
            self._sort(value if isinstance(value, type) else type(value))
            self.words += [getattr(value, "__module__", ""), getattr(value, "__qualname__", "")]
            if hasattr(value, "__dict__") and not any(value is outer for outer in within):
                for name in sorted(names):
                    if hasattr(value, name):
                        self.words.append(name)
                        self._value(getattr(value, name), names, (*within, value))

    def _layout(self, example: Any) -> None:
        """Add a nested tuple's shape; its numbers do not count."""
        if isinstance(example, tuple):
            self._items(example, self._layout)
        else:
            self.words.append(_kind(example).__name__)

    def _items(self, values: tuple[Any, ...], add: Callable[[Any], None]) -> None:
        self._sort(type(values))
        self.words.append(len(values))
        for item in values:
            add(item)

    def _function(self, function: FunctionType) -> None:
        """Add a function, and all that its names lead to."""
        if self._is_known(function):
            return
        self._value(function.__defaults__ or ())
        self._value(tuple(sorted((function.__kwdefaults__ or {}).items())))
        self.words.append(_words(function.__code__))
        names = frozenset(_names(function.__code__))
        for name in sorted(names & function.__globals__.keys()):
            self.words.append(name)
            self._value(function.__globals__[name], names)

    def _sort(self, sort: type) -> None:
        if not self._is_known(sort):
            self.words.append(getattr(sort, "_fields", ()))
            for name, value in getattr(sort, "_field_defaults", {}).items():
                self.words.append(name)
                self._value(value)

    def _is_known(self, one: type | FunctionType) -> bool:
        """Tell whether a function or type has been added already; add its name if not."""
        if one in self.known:
            self.words.append(self.known[one])
            return True
        self.known[one] = len(self.known)
        self.words += [one.__module__, one.__qualname__]
        return False


def _inner(code: CodeType) -> Iterator[CodeType]:
    """Yield the code of what is defined within a module or function."""
    return (constant for constant in code.co_consts if isinstance(constant, CodeType))


def _names(code: CodeType) -> Iterator[str]:
    """Yield the names in a function's code that are not its variables."""
    yield from code.co_names
    for inner in _inner(code):
        yield from _names(inner)


def _words(code: CodeType) -> list[Any]:
    """Return what a function does, and in which lines."""
    numbers = [constant for constant in code.co_consts if isinstance(constant, int | float | tuple)]
    return [*(getattr(code, part, b"") for part in _PARTS), numbers, *map(_words, _inner(code))]


def _kind(value: Any) -> type:
    """Return what a number is to the translator."""
    if isinstance(value, bool):
        return bool
    return int if isinstance(value, int) else float
