"""Nested NamedTuples of numbers as flat rows of floats, and back: how the plant meets machine code.

The order is that of the fields, depth first. Integers are stored as floats too. Both directions are
generated as Python source from an example, once per type, because walking the tree each time would cost more
than a step of the plant.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache
from types import CodeType
from typing import Any

Row = tuple[float, ...]


def packer(example: Any) -> Callable[[Any], Row]:
    """Return a function that lays tuples like the example out flat."""
    row = ", ".join(path for path, _ in leaves(example, "value"))
    function: Callable[[Any], Row] = _evaluate(f"lambda value: ({row},)", {})
    return function


def unpacker(example: Any) -> Callable[[Any], Any]:
    """Return a function that builds a tuple like the example from a row of as many numbers."""
    names: dict[str, Any] = {}
    function: Callable[[Any], Any] = _evaluate(f"lambda row: {construction(example, 'row', names)}", names)
    return function


def leaves(example: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield expression and value of every number in a nested tuple; `path` is the expression of the whole."""
    if not isinstance(example, tuple):
        yield path, example
        return
    fields = getattr(example, "_fields", None)
    for i, item in enumerate(example):
        yield from leaves(item, f"{path}.{fields[i]}" if fields else f"{path}[{i}]")


def construction(example: Any, row: str, names: dict[str, Any]) -> str:
    """Return the expression that builds a tuple like the example from the numbers `row[0]`, `row[1]`...

    Args:
        example: a nested tuple of numbers.
        row: name of the row in the expression.
        names: is given the NamedTuples that the expression needs.
    """
    count = iter(range(1_000_000))

    def build(item: Any) -> str:
        if isinstance(item, tuple):
            inner = ", ".join(build(part) for part in item)
            if not hasattr(item, "_fields"):
                return f"({inner},)"
            name = type(item).__name__
            while names.setdefault(name, type(item)) is not type(item):
                name += "_"  # two types of one name
            return f"{name}({inner})"
        index = next(count)
        if isinstance(item, bool):
            return f"bool({row}[{index}])"
        return f"int({row}[{index}])" if isinstance(item, int) else f"{row}[{index}]"

    return build(example)


def _evaluate(expression: str, names: dict[str, Any]) -> Any:
    return eval(_code(expression), names)  # noqa: S307  our own text, made of field names


@lru_cache(maxsize=64)
def _code(expression: str) -> CodeType:
    """Return a layout's code: all loops of a process have the same few layouts."""
    return compile(expression, "<layout>", "eval")
