"""A machine that nobody knows: ``unknown``, ``unknown:SEED`` or ``unknown:SEED:BASE`` in place of a name.

What identification is there to find is drawn within 40 % of what the base (c180_hoses) says, each number
on its own, evenly; a valve that the base tells once gets two unlike directions. What a person reads
off a gauge, a plate or a drawing stays: pump, geometry, masses, sensors. An overlap stays below the
voltages at which a valve's curve was measured. A spool that lets more oil pass is pushed harder by it: its
spring is as much stiffer.

Equal seeds (0, if none is given) give equal machines, everywhere: a record, a fit and a run along a
path may each name ``unknown:7`` and mean one crane.

What is drawn is written as a machine file, so that it is read, checked and shown as any other.
"""

import math
import zlib
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from forest_description.config.parameter import MachineError

WORD = "unknown"
FORM = "unknown, unknown:SEED or unknown:SEED:BASE, with SEED 0 .. 2147483647 and BASE a shipped machine"
BASE = "c180_hoses"
WITHIN = 0.4
SECTIONS = ("valve", "hose", "swing", "boom", "stick")
DRAWN = (
    *("deadband_voltage", "minimum_resistance", "spool_bandwidth"),
    *("turbulent_resistance", "laminar_resistance", "inertance", "capacitance"),
    *("internal_leakage_resistance", "external_leakage_resistance", "damping"),
)
BY_DIRECTION = DRAWN[:2]
UNTOLD = (".holding_", ".compensator.")  # their C_R is not drawn
OVERLAP, MEASURED, EDGE, SPRING = "deadband_voltage", "curve.voltages", "minimum_resistance", "centring_force"
BELOW = 0.95  # of the lowest voltage at which a valve was measured, where an overlap would reach it


class Number(NamedTuple):
    """A number of the base's file as it stands there."""

    value: float
    unit: str


def is_unknown(name: str) -> bool:
    """Tell whether a name asks for a machine that is drawn."""
    return name.partition(":")[0] == WORD


def parts(name: str) -> tuple[int, str]:
    """Return seed and base of a name.

    Raises:
        MachineError: the seed is none.
    """
    _, _, tail = name.partition(":")
    text, _, base = tail.partition(":")
    number, name_like = text or "0", base.replace("_", "").isalnum() or not base
    if not (number.isdecimal() and int(number) < 2**31 and name_like) or is_unknown(base):
        raise MachineError(f"machine {name!r}: allowed: {FORM}")
    return int(number), base or BASE


def text(name: str, numbers: Mapping[str, Number]) -> str:
    """Return the machine file of a name.

    Args:
        name: for which `is_unknown`.
        numbers: of the base, by dotted key; of a row the first one.
    """
    seed, base = parts(name)
    lines = [
        f"based_on: {base}",
        f'name: "{name}"',
        f"description: Drawn within {100.0 * WITHIN:.0f} % of {base}, seed {seed}",
    ]
    above: list[str] = []
    for key, drawn in sorted(_drawn(seed, numbers).items()):
        *sections, last = key.split(".")
        common = sum(1 for k in range(len(sections)) if sections[: k + 1] == above[: k + 1])
        lines += [f"{'  ' * depth}{sections[depth]}:" for depth in range(common, len(sections))]
        above = sections
        quantity = f'{{value: {drawn.value!r}, unit: {drawn.unit}, source: "assumed: drawn, seed {seed}"}}'
        lines.append(f"{'  ' * len(sections)}{last}: {quantity}")
    return "\n".join(lines) + "\n"


def _drawn(seed: int, numbers: Mapping[str, Number]) -> dict[str, Number]:
    found = {}
    for key, number in _drawn_keys(numbers):
        share = np.random.default_rng([seed, zlib.crc32(key.encode())]).uniform(-WITHIN, WITHIN)
        found[key] = number._replace(value=number.value * (1.0 + float(share)))
    lowest = min((n.value for key, n in numbers.items() if key.endswith(MEASURED)), default=math.inf)
    widest = max((n.value / found[key].value for key, n in _drawn_keys(numbers) if EDGE in key), default=1.0)
    springs = {
        key: n._replace(value=n.value * math.sqrt(max(1.0, widest)))
        for key, n in numbers.items()
        if key.endswith(SPRING)
    }
    return springs | {
        key: n._replace(value=BELOW * lowest) if key.endswith(OVERLAP) and n.value >= lowest else n
        for key, n in found.items()
    }


def _drawn_keys(numbers: Mapping[str, Number]) -> Iterator[tuple[str, Number]]:
    for key, number in numbers.items():
        sections, _, last = key.rpartition(".")
        if last not in DRAWN or key.partition(".")[0] not in SECTIONS or any(part in key for part in UNTOLD):
            continue
        yield key, number
        other = f"{sections}.backward.{last}"
        if last in BY_DIRECTION and not sections.endswith("backward") and other not in numbers:
            yield other, number
