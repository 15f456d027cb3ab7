"""What the head holds, and when: a log grasped and dropped in mid-run, by a text or while a node runs.

A schedule says "500 kg from 2 s; 800 kg, 5 m from 4 s; 0 kg from 6 s": masses of logs, perhaps with
their lengths, and times since the start. What is heavier than before joins the head
(`solver.load_change`), what is lighter has been dropped. A change acts from the first sample at or
after its time.
"""

import math
import re
from itertools import pairwise
from typing import NamedTuple

from forest_description.derived.bodies import with_log
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.mechanics.manipulator import fold_head
from forest_sim.mechanics.pendulum import hanging_head

GREATEST_MASS = 1e4  # [kg] of a log, more than a loader of this sort lifts
GREATEST_LENGTH = 30.0  # [m] of a whole tree
LATEST = 7.0 * 86400.0  # [s]
LOG_LENGTH = 4.0  # [m] of a log that is not told: between pulpwood and saw logs
ROUNDING = 1e-9  # [s] of a time that is a multiple of the period
ALLOWED = "MASS kg from TIME s; MASS kg, LENGTH m from TIME s; 0 kg from TIME s drops it"
_NUMBER = r"[-+]?[0-9.]+(?:e[-+]?[0-9]+)?"
_FORM = re.compile(
    rf"(?P<mass>{_NUMBER})\s*kg(?:\s*,?\s*(?P<length>{_NUMBER})\s*m)?\s+from\s+(?P<time>{_NUMBER})\s*s",
    re.IGNORECASE,
)


class Load(NamedTuple):
    """The log that a head holds; of no mass: none."""

    mass: float  # [kg]
    length: float = LOG_LENGTH  # [m]


class LoadEvent(NamedTuple):
    """From when on a head holds another log."""

    time: float  # since the start [s]
    load: Load


Loads = tuple[LoadEvent, ...]


def parse_loads(text: str) -> Loads:
    """Return the schedule of a text; an empty one has no changes.

    Raises:
        ValueError: an entry is not of the form, or a number is out of range; the text says what is
            allowed.
    """
    entries = [entry.strip() for entry in re.split(r"[;\n]", text)]
    events = tuple(_event(entry) for entry in entries if entry)
    for before, after in pairwise(events):
        if after.time <= before.time:
            raise ValueError(
                f"{after.load.mass:g} kg from {after.time:g} s comes after {before.time:g} s; "
                "allowed: times that rise"
            )
    return events


def _event(entry: str) -> LoadEvent:
    form = _FORM.fullmatch(entry)
    if form is None:
        raise ValueError(f"'{entry}' is no load; allowed: {ALLOWED}")
    length = LOG_LENGTH if form["length"] is None else _number(entry, form["length"], GREATEST_LENGTH, "m")
    mass = _number(entry, form["mass"], GREATEST_MASS, "kg")
    return LoadEvent(_number(entry, form["time"], LATEST, "s"), Load(mass, length))


def _number(entry: str, text: str, greatest: float, unit: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value <= greatest:
        raise ValueError(f"'{entry}': {text} {unit}; allowed: 0 .. {greatest:g} {unit}")
    return value


def checked_load(mass: float, length: float) -> Load:
    """Return a log of a mass [kg] and a length [m].

    Raises:
        ValueError: there is no such log; the text says what is allowed.
    """
    if not (0.0 <= mass <= GREATEST_MASS and 0.0 <= length <= GREATEST_LENGTH):  # false for NaN as well
        raise ValueError(
            f"a log of {mass:g} kg, {length:g} m; "
            f"allowed: 0 .. {GREATEST_MASS:g} kg, 0 .. {GREATEST_LENGTH:g} m"
        )
    return Load(mass, length)


def own_load(m: Manipulator) -> Load:
    """Return the log that a machine's file gives to its head."""
    return Load(0.0) if m.log is None else Load(m.log.mass, m.log.length or 0.0)


def loaded(p: PlantParameters, m: Manipulator, load: Load) -> PlantParameters:
    """Return a machine's parameters with another log in its head."""
    if load == own_load(m):
        return p
    holding = with_log(m, load.mass, load.length)
    return p._replace(body=fold_head(holding), head=hanging_head(holding))


def by_period(loads: Loads, rate: float) -> dict[int, Load]:
    """Return a schedule by the number of the sampling period [Hz] from whose beginning on a load is held."""
    return {math.ceil((event.time - ROUNDING) * rate): event.load for event in loads}
