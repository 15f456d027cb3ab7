"""A call of a function that is being translated, and the function's syntax tree."""

import ast
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path, PurePath
from types import CodeType, FunctionType
from typing import Any

from forest_compile.ir.values import NotTranslatedError, Value

Variables = dict[str, Value]
Arrival = tuple[str, Variables]  # a block that leads somewhere, and the variables at its end


class Frame:
    """A call: its variables, and what names mean outside the function.

    Args:
        name: of the function.
        code: Python's of it, which knows file and variables.
        names: what names mean outside.
        function: it; None for a kernel's own source.
    """

    def __init__(
        self, name: str, code: CodeType, names: Mapping[str, Any], function: FunctionType | None = None
    ) -> None:
        self.name, self.names, self.function = name, names, function
        self.file, self.own = PurePath(code.co_filename).name, {*code.co_varnames, *code.co_cellvars}
        self.line = code.co_firstlineno
        self.variables: Variables = {}
        self.returns: list[tuple[str, Value]] = []
        self.breaks: list[list[Arrival]] = []
        self.continues: list[list[Arrival]] = []

    def place(self) -> str:
        """Return which function, file and line is being translated."""
        return f"{self.name} ({self.file}, line {self.line})"


@lru_cache(maxsize=1024)
def syntax_tree(function: FunctionType) -> ast.FunctionDef:
    """Return a function's syntax tree.

    Raises:
        NotTranslatedError: it does not stand by itself in a module, as it stands.
    """
    code = function.__code__
    for node in _module(code.co_filename).body:
        if isinstance(node, ast.FunctionDef) and code.co_firstlineno in _first_lines(node):
            if node.decorator_list:
                raise NotTranslatedError("a decorated function is not translated")
            if node.name == code.co_name:
                return node
    raise NotTranslatedError("only functions that a module defines by themselves are translated")


def _first_lines(node: ast.FunctionDef) -> set[int]:
    return {node.lineno, *(decorator.lineno for decorator in node.decorator_list)}


@lru_cache(maxsize=64)
def _module(path: str) -> ast.Module:
    try:
        return ast.parse(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise NotTranslatedError("its source is no file that can be read") from error
