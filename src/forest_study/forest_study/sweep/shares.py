"""How much of a figure's variance each factor makes.

A Sobol design tells the first-order and the total index of each range (Saltelli et al. 2010, by scipy),
averaged over the combinations of the lists. Any other design tells the correlation ratio of each factor: the
variance of the means of its levels, over the whole. A range has `BINS` levels of equal counts; chance alone
makes (levels - 1) / (runs - 1) of it.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy  # its `stats` takes a second to load: only where it is used

from forest_description.types import Floats
from forest_study.sweep.study import Study
from forest_study.sweep.workers import Row

BINS = 10  # levels of a range
ABOUT = ("number", "combination", "point", "seed", "error")  # columns that are neither factor nor figure


class Share(NamedTuple):
    """What a factor makes of a figure's variance."""

    first: float  # alone: first-order index, or correlation ratio
    total: float | None  # with all others that it acts together with; None: the design cannot tell


def figure_names(study: Study, rows: Sequence[Row]) -> list[str]:
    """Return the names of the figures, in the order of the rows' columns."""
    other = {*ABOUT, *study.lists, *study.ranges}
    return [name for name in rows[0] if name not in other]


def shares(study: Study, rows: Sequence[Row], figure: str) -> dict[str, Share]:
    """Return each factor's share in a figure, where it can be told.

    Args:
        study: whose rows they are.
        rows: all of them, in the order of their numbers.
        figure: name of a column.
    """
    values = np.array([np.nan if row[figure] is None else row[figure] for row in rows], dtype=np.float64)
    if study.design == "sobol":
        return _sobol(study, values)
    return {name: Share(_ratio(_levels(study, name, rows), values), None) for name in _factors(study)}


def _factors(study: Study) -> list[str]:
    return [*study.lists, *study.ranges]


def _sobol(study: Study, values: Floats) -> dict[str, Share]:
    """Return the indices of ranges; no run may be missing: the design stands and falls with its pairs."""
    by_point = values.reshape(-1, len(study.ranges) + 2, study.points, len(study.seeds)).mean(axis=3)
    if np.isnan(by_point).any():
        return {}
    first, total = [], []
    for one in by_point:
        twice = np.stack([one, one], axis=1)  # of a single figure of one range scipy 1.17 makes a TypeError
        parts = {"f_A": twice[0], "f_B": twice[1], "f_AB": twice[2:]}
        found = scipy.stats.sobol_indices(func=parts, n=study.points)
        first.append(np.atleast_1d(found.first_order[0]))
        total.append(np.atleast_1d(found.total_order[0]))
    pairs = zip(np.mean(first, axis=0).tolist(), np.mean(total, axis=0).tolist(), strict=True)
    return {name: Share(*pair) for name, pair in zip(study.ranges, pairs, strict=True)}


def _levels(study: Study, name: str, rows: Sequence[Row]) -> list[Any]:
    """Return each row's level of a factor."""
    if name in study.lists:
        return [str(row[name]) for row in rows]
    order = np.argsort(np.argsort([row[name] for row in rows], kind="stable"), kind="stable")
    levels: list[Any] = (order * min(BINS, len(rows)) // len(rows)).tolist()
    return levels


def _ratio(levels: Sequence[Any], values: Floats) -> float:
    """Return the variance of the levels' means over the variance of values, which may be missing (NaN)."""
    known = ~np.isnan(values)
    held, own = values[known], np.unique(np.array(levels)[known], return_inverse=True)[1]
    spread = float(np.var(held)) if len(held) else 0.0
    if spread <= 0.0:
        return 0.0
    counts = np.bincount(own)
    means = np.bincount(own, held) / counts
    return float(np.sum(counts * (means - held.mean()) ** 2) / (len(held) * spread))
