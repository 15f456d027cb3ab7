"""What a changed constant does: which figures it moves by more than chance does.

Figures of a loop that cycles, or has play, differ by chance. Chance is what changes without meaning give: a
constant changed by millionths, several times. One more may lie outside what they gave, so that the range
counts thrice: of nine runs it is 3 standard deviations wide, and a figure is then let off by 4.5.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from forest_study.ablation.constants import Number
from forest_study.ablation.trials import Figures

COUNTS = 0.05  # of a figure, beyond what chance gives: an effect
TOLD = 2  # effects of a change, the greatest
HEAD = "| constant | value | at half | at twice |\n|---|---|---|---|"
SMALL = (", s", ", m", ", m/s")  # figures in these units are of the order of a tenth, others of one


class Chance(NamedTuple):
    """What a figure is without any change that has a meaning."""

    least: float
    most: float

    def beyond(self, value: float, name: str) -> float:
        """Return how far a value is beyond chance, as a share of the figure."""
        scale = max(self.most, 0.1 if name.endswith(SMALL) else 1.0)
        return max(value - self.most, self.least - value, 0.0) / scale


def chance(found: Sequence[Figures]) -> dict[str, Chance]:
    """Return what each figure is by chance: its range, widened on either side by what it is wide."""
    usual = {}
    for name in found[0]:
        values = [one[name] for one in found]
        least, most = min(values), max(values)
        usual[name] = Chance(least - (most - least), most + (most - least))
    return usual


def effect(figures: Figures | None, usual: dict[str, Chance]) -> float:
    """Return the greatest of a change's effects."""
    if figures is None:
        return math.inf
    return max(of.beyond(figures[name], name) for name, of in usual.items())


def told(figures: Figures | None, usual: dict[str, Chance], same: Figures) -> str:
    """Return the greatest effects of a change in words; same: figures without it."""
    if figures is None:
        return "control fails"
    if figures == same:
        return "none"
    shares = {name: of.beyond(figures[name], name) for name, of in usual.items()}
    greatest = sorted((name for name in shares if shares[name] > COUNTS), key=shares.__getitem__)[::-1]
    return "; ".join(_change(name, same[name], figures[name]) for name in greatest[:TOLD]) or "little"


def _change(name: str, before: float, after: float) -> str:
    what, _, unit = name.rpartition(", ")
    what, unit = (name, "") if not what or unit[:1].isdigit() else (what, f" {unit}")
    digits = 2 if name.endswith(SMALL) else 1 if unit else 0
    return f"{what} {before:.{digits}f} → {after:.{digits}f}{unit}"


def line(name: str, value: Number, half: str, twice: str) -> str:
    """Return a constant's line of the table."""
    values = value if isinstance(value, tuple) else (value,)
    shown = ", ".join(f"{one:.4g}" for one in (values if len(set(values)) > 1 else values[:1]))
    return f"| `{name}` | {shown} | {half} | {twice} |"
