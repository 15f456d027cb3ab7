"""Facts of an experiment that no sensor measures: names, units and ranges.

A person writes them into a bag's `experiment.yaml`, in any unit that a machine file may use. An unknown fact,
another quantity, or a value out of range is refused: it is a slip.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from forest_description.config.units import UNITS


class Fact(NamedTuple):
    """A quantity: its SI unit and its bounds; ``whole``: a count, or yes (1) or no (0)."""

    unit: str
    low: float
    high: float
    whole: bool = False


FACTS = {
    "case_drain_volume": Fact("m3", 0.0, 1.0),
    "hose_length": Fact("m", 0.01, 100.0),
    "hose_axis": Fact("1", 0, 2, whole=True),
    "laminar": Fact("1", 0, 1, whole=True),
    "exact_sensors": Fact("1", 0, 1, whole=True),
    "ice_until": Fact("s", 2.0, 1e5),
    "boiling_from": Fact("s", 2.0, 1e5),
    "platform_tilt": Fact("rad", -0.5, 0.5),
}


def value(name: str, entry: Any) -> float:
    """Return a fact in its SI unit.

    Args:
        name: of the fact.
        entry: of the file, {value: .., unit: ..}.

    Raises:
        ValueError: there is no such fact, or its value is not allowed; the text names what is allowed.
    """
    fact = FACTS.get(name)
    if fact is None:
        raise ValueError(f"no fact {name!r}; allowed: {', '.join(FACTS)}")
    if not (isinstance(entry, Mapping) and set(entry) == {"value", "unit"}):
        raise ValueError(f"{name}: {entry!r}; allowed: {{value: 1.0, unit: {fact.unit}}}")
    unit = UNITS.get(str(entry["unit"]))
    if unit is None or unit.si != fact.unit:
        allowed = ", ".join(text for text, known in UNITS.items() if known.si == fact.unit)
        raise ValueError(f"{name}: unit {entry['unit']!r}; allowed: {allowed}")
    return checked(name, entry["value"], unit.factor)


def checked(name: str, number: Any, factor: float = 1.0) -> float:
    """Return a fact's number times a unit's factor.

    Raises:
        ValueError: it is no number, or cannot be.
    """
    fact = FACTS[name]
    try:
        found = float(number) * factor
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not fact.low <= found <= fact.high or (fact.whole and found != round(found)):
        kind = "whole numbers " if fact.whole else ""
        bounds = f"{fact.low / factor:g} .. {fact.high / factor:g}"
        raise ValueError(f"{name}: {number!r}; allowed: {kind}{bounds}")
    return found
