"""What a kernel is made of: the function that the world calls, and what its names mean.

An entry holds everything that decides a kernel: `frontend.translate` makes the kernel of it, `fingerprint`
tells whether a kernel that lies on disk is still the one.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

RUNTIME = "runtime"  # the argument of an entry that points to the values of its `RuntimeNumber`s


class RuntimeNumber(float):
    """A number outside of functions that a kernel reads whenever it runs, not one in its code."""

    def __new__(cls, value: float, place: int) -> "RuntimeNumber":
        """Return the number.

        Args:
            value: what it is to Python.
            place: where a kernel finds it, in the row of doubles that its argument `RUNTIME` points to.
        """
        number = super().__new__(cls, value)
        number.place = place
        return number

    place: int


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
