"""What a kernel is made of: the function that the world calls, and what its names mean.

An entry holds everything that decides a kernel: `translate.text` makes the kernel of it, `fingerprint.digest`
tells whether a kernel that lies on disk is still the one.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple


class Entry(NamedTuple):
    """The function that the world calls."""

    text: str
    """Its source in Python; it returns nothing."""
    names: Mapping[str, Any]
    """What names in the source mean: functions of the laws, types, numbers and tuples of numbers."""
    arguments: str
    """A letter for each argument: p pointer to doubles, d double, i whole number."""
    views: Mapping[str, tuple[str, Any]]
    """Names of tuples that lie flat in an argument: the argument's name, and an example."""
    copies: Mapping[str, tuple[str, Any]]
    """The same, of arguments that the function writes to."""
    apart: tuple[Callable[..., Any], ...] = ()
    """Functions whose calls stay calls: those that are seldom called, or large."""
    fixed: Mapping[tuple[str, int], float] = {}
    """Numbers that LLVM may take for granted: an argument's name, and where in it."""
