"""What is done or read by hand in an experiment, and no sensor tells: names, units, what can be.

A person writes them into a bag's `experiment.yaml`, in any unit that a machine file may use. A fact that
nobody would look at, of another quantity, or beyond what any crane has, is refused: it is a slip.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from forest_description.config.units import UNITS


class Fact(NamedTuple):
    """A quantity by hand: its SI unit and its bounds in it; ``whole``: a count or a yes (1) or no (0)."""

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


def value(name: str, told: Any) -> float:
    """Return a fact in its SI unit.

    Args:
        name: of the fact.
        told: what the file has there, {value: .., unit: ..}.

    Raises:
        ValueError: there is no such fact, or this cannot be its value; the text says what is allowed.
    """
    fact = FACTS.get(name)
    if fact is None:
        raise ValueError(f"no fact {name!r}; allowed: {', '.join(FACTS)}")
    if not (isinstance(told, Mapping) and set(told) == {"value", "unit"}):
        raise ValueError(f"{name}: {told!r}; allowed: {{value: 1.0, unit: {fact.unit}}}")
    unit = UNITS.get(str(told["unit"]))
    if unit is None or unit.si != fact.unit:
        allowed = ", ".join(text for text, known in UNITS.items() if known.si == fact.unit)
        raise ValueError(f"{name}: unit {told['unit']!r}; allowed: {allowed}")
    return checked(name, told["value"], unit.factor)


def checked(name: str, number: Any, factor: float = 1.0) -> float:
    """Return a fact's number times a unit's factor.

    Raises:
        ValueError: it is no number, or cannot be.
    """
    fact = FACTS[name]
    try:
        found = float(number) * factor
    except (TypeError, ValueError):
        found = math.nan
    if not fact.low <= found <= fact.high or (fact.whole and found != round(found)):
        kind = "whole numbers " if fact.whole else ""
        bounds = f"{fact.low / factor:g} .. {fact.high / factor:g}"
        raise ValueError(f"{name}: {number!r}; allowed: {kind}{bounds}")
    return found
