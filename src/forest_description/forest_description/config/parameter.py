"""A machine parameter: a float in SI that knows its unit, its allowed range and its meaning.

Ranges are wide: they catch a slipped decimal point or a wrong unit, not an unusual crane.
"""

import dataclasses
import math
from collections.abc import Iterator
from typing import Any, NamedTuple, TypeVar


class MachineError(ValueError):
    """A machine, or a file that describes one, is not usable; the message says where and what is allowed."""


class Parameter(NamedTuple):
    """What a field of a machine dataclass may hold: SI unit, inclusive range in it, meaning."""

    unit: str
    low: float
    high: float
    doc: str

    @property
    def range(self) -> str:
        """The allowed range as text, for messages."""
        return f"{self.low:g} .. {in_unit(self.high, self.unit)}"


def in_unit(value: float, unit: str) -> str:
    """Return a number with its unit as people write it: a pure number has none."""
    return f"{value:g}" if unit == "1" else f"{value:g} {unit}"


class Choice(NamedTuple):
    """What a field of a machine dataclass may say: one of some words."""

    words: tuple[str, ...]
    doc: str


def parameter(unit: str, low: float, high: float, doc: str) -> Any:
    """Return a dataclass field for one parameter.

    Args:
        unit: SI unit, one of the values of ``units.UNITS``.
        low: Smallest allowed value [unit], inclusive.
        high: Largest allowed value [unit], inclusive.
        doc: Meaning, a few words.
    """
    return dataclasses.field(metadata={"parameter": Parameter(unit, low, high, doc)})


def optional_parameter(unit: str, low: float, high: float, doc: str) -> Any:
    """Return a dataclass field for a parameter that may be left out, and is None then."""
    return dataclasses.field(default=None, metadata={"parameter": Parameter(unit, low, high, doc)})


def curve(unit: str, low: float, high: float, doc: str) -> Any:
    """Return a dataclass field for a row of numbers, a tuple of floats; arguments as ``parameter``."""
    return dataclasses.field(metadata={"parameter": Parameter(unit, low, high, doc), "row": True})


def choice(*words: str, doc: str) -> Any:
    """Return a dataclass field, of type str, that holds one of some words."""
    return dataclasses.field(metadata={"choice": Choice(words, doc)})


def optional_choice(*words: str, doc: str) -> Any:
    """Return a dataclass field for one of some words that may be left out, and is None then."""
    return dataclasses.field(default=None, metadata={"choice": Choice(words, doc)})


def component() -> Any:
    """Return a dataclass field for a component, which stands for itself."""
    return dataclasses.field()


def may_be_left_out(field: dataclasses.Field[Any]) -> bool:
    """Tell whether a file may leave a field out: a component that is None by default.

    Files and records from before there was such a component stay what they are.
    """
    return field.default is None


def parameter_of(field: dataclasses.Field[Any]) -> Parameter | None:
    """Return the parameter that a dataclass field declares, or None for a field of another kind."""
    found: Parameter | None = field.metadata.get("parameter")
    return found


def choice_of(field: dataclasses.Field[Any]) -> Choice | None:
    """Return the choice that a dataclass field declares, or None for a field of another kind."""
    found: Choice | None = field.metadata.get("choice")
    return found


@dataclasses.dataclass(frozen=True)
class ParameterSet:
    """Base of the machine dataclasses: every parameter becomes a float and is checked against its range.

    This also guards ``dataclasses.replace``, with which identification and studies make their
    variants.
    """

    def __post_init__(self) -> None:
        """Check each parameter; None stays None (an optional component that is not there)."""
        for field in dataclasses.fields(self):
            where, value = f"{type(self).__name__}.{field.name}", getattr(self, field.name)
            allowed, words = parameter_of(field), choice_of(field)
            if value is None and may_be_left_out(field):
                continue
            if words is not None and value not in words.words:
                raise MachineError(f"{where}: {value!r} is none of {', '.join(words.words)}")
            if allowed is None or value is None:
                continue
            if field.metadata.get("row"):
                if not isinstance(value, (tuple, list)) or not value:
                    raise MachineError(f"{where}: {value!r} is not a row of numbers [{allowed.unit}]")
                numbers = tuple(_checked(where, item, allowed) for item in value)
                object.__setattr__(self, field.name, numbers)
            else:
                object.__setattr__(self, field.name, _checked(where, value, allowed))


def fields_of(part: ParameterSet, prefix: str = "") -> Iterator[tuple[str, dataclasses.Field[Any], Any]]:
    """Yield dotted key, field and value of everything that a machine, or a part of one, holds."""
    for field in dataclasses.fields(part):
        key, value = prefix + field.name, getattr(part, field.name)
        yield key, field, value
        if isinstance(value, ParameterSet):
            yield from fields_of(value, f"{key}.")


_Set = TypeVar("_Set", bound=ParameterSet)


def replace_unchecked(base: _Set, **changes: Any) -> _Set:
    """Return a copy with numbers that physics makes of checked ones; they may lie beyond the ranges.

    The ranges are for what somebody writes down. A machine at the edge of one must not stop because
    its oil warms.
    """
    copy = object.__new__(type(base))
    for field in dataclasses.fields(base):
        object.__setattr__(copy, field.name, changes.get(field.name, getattr(base, field.name)))
    return copy


def _checked(where: str, value: object, allowed: Parameter) -> float:
    """Return a number as a float if it is one and in its range."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise MachineError(f"{where}: {value!r} is not a finite number [{allowed.unit}]")
    if not allowed.low <= value <= allowed.high:
        raise MachineError(f"{where}: {in_unit(value, allowed.unit)} is outside {allowed.range}")
    return float(value)


def require_order(low_name: str, low: float, high_name: str, high: float, unit: str) -> None:
    """Raise a MachineError unless low < high; names and unit are for the message."""
    if not low < high:
        raise MachineError(f"{low_name} ({low:g} {unit}) must be smaller than {high_name} ({high:g} {unit})")
