"""What a kernel is made of: the function that the world calls, and what its names mean.

An entry holds everything that decides a kernel: `frontend.translate` makes the kernel of it, `fingerprint`
tells whether a kernel that lies on disk is still the one.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple


class Entry(NamedTuple):
    """The function that the world calls."""

    text: str  # its source in Python; it returns nothing
    names: Mapping[str, Any]  # what names in it mean: model functions, types, numbers and tuples of numbers
    arguments: str  # a letter for each: p pointer to doubles, d double, i integer
    # Names of tuples that lie flat in an argument: the argument's name, and an example. If the source uses
    # the argument itself, too, the tuple is what lay there at the beginning.
    tuples: Mapping[str, tuple[str, Any]]
    # Functions whose calls stay calls: those that are seldom called, or large.
    noinline: tuple[Callable[..., Any], ...] = ()
