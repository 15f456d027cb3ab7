"""Whether a kernel on disk is still the one that its laws would give: a digest of all that decides it.

The digest follows the names in the laws' bytecode through what is imported: functions, numbers, tuples and
types. It reads no source, since a node computes it at every start; 120 functions take about a millisecond. A
name counts even where the law means a field of the same name, so the digest covers a little too much, never
too little. Strings do not count: no law can use them.
"""

import hashlib
import re
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from types import CodeType, FunctionType
from typing import Any

from forest_compile.entry import Entry

Names = frozenset[str]
_PARTS = (
    *("co_code", "co_exceptiontable", "co_flags", "co_argcount", "co_posonlyargcount"),
    *("co_kwonlyargcount", "co_names", "co_varnames", "co_freevars", "co_cellvars"),
    *("co_firstlineno", "co_linetable"),  # a kernel may name the place of what fails in it
)


def digest(entry: Entry) -> str:
    """Return what changes with the entry, or with a function, number or type that its names lead to."""
    return hashlib.sha256(repr(_marked(entry).words).encode()).hexdigest()


def functions(entry: Entry) -> list[FunctionType]:
    """Return the functions that the entry's names lead to."""
    return [one for one in _marked(entry).known if isinstance(one, FunctionType)]


def changed(entry: Entry) -> Iterator[FunctionType]:
    """Yield functions whose file does not say what was imported, while it is the file that is translated."""
    files: dict[str, list[list[Any]]] = {}
    for one in functions(entry):
        if one.__qualname__.isidentifier():  # no method: that is no law
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


def _marked(entry: Entry) -> "_Fingerprint":
    mark = _Fingerprint()
    mark.tell(entry.text, entry.arguments)
    names = frozenset(re.findall(r"\w+", entry.text))
    for name, value in sorted(entry.names.items()):
        mark.tell(name)
        mark.value(value, names)
    mark.tell(len(entry.tuples))
    for name, (argument, example) in entry.tuples.items():
        mark.tell(name, argument)
        mark.layout(example)
    mark.tell([mark.known.get(function) for function in entry.noinline if function in mark.known])
    return mark


class _Fingerprint:
    def __init__(self) -> None:
        self.words: list[Any] = []
        self.known: dict[type | FunctionType, int] = {}

    def tell(self, *words: Any) -> None:
        self.words += words

    def value(self, value: Any, names: Names = frozenset(), within: tuple[Any, ...] = ()) -> None:
        """Add what a name means; `names` are those by which its attributes may be called."""
        if isinstance(value, int | float):
            self.tell(_kind(value)(value))
        elif isinstance(value, tuple):
            self._sort(type(value))
            self.tell(len(value))
            for item in value:
                self.value(item)
        elif isinstance(value, FunctionType):
            self.function(value)
        else:  # a module, a type, a function of the C library; or something that no law can use
            self._sort(value if isinstance(value, type) else type(value))
            self.tell(getattr(value, "__module__", ""), getattr(value, "__qualname__", ""))
            if hasattr(value, "__dict__") and not any(value is outer for outer in within):
                for name in sorted(names):
                    if hasattr(value, name):
                        self.tell(name)
                        self.value(getattr(value, name), names, (*within, value))

    def layout(self, example: Any) -> None:
        """Add a nested tuple's shape; its numbers do not count."""
        if not isinstance(example, tuple):
            self.tell(_kind(example).__name__)
            return
        self._sort(type(example))
        self.tell(len(example))
        for item in example:
            self.layout(item)

    def function(self, function: FunctionType) -> None:
        """Add a function, and all that its names lead to."""
        if self._is_known(function):
            return
        self.value(function.__defaults__ or ())
        self.value(tuple(sorted((function.__kwdefaults__ or {}).items())))
        self.tell(_words(function.__code__))
        names = frozenset(_names(function.__code__))
        for name in sorted(names & function.__globals__.keys()):
            self.tell(name)
            self.value(function.__globals__[name], names)

    def _sort(self, sort: type) -> None:
        if self._is_known(sort):
            return
        self.tell(getattr(sort, "_fields", ()))
        for name, value in getattr(sort, "_field_defaults", {}).items():
            self.tell(name)
            self.value(value)

    def _is_known(self, one: type | FunctionType) -> bool:
        """Tell whether a function or type has been added already; add its name if not."""
        if one in self.known:
            self.tell(self.known[one])
            return True
        self.known[one] = len(self.known)
        self.tell(one.__module__, one.__qualname__)
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
