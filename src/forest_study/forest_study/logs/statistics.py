"""Means and paired differences of runs, with their intervals.

Persons are paired: a seed is the same person with the same chances in every mode. A difference is a ratio of
times, so its mean and interval are those of the logarithm (Student's t over persons).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy  # its `stats` takes a second to load: only where it is used

CONFIDENCE = 0.95


class Mean(NamedTuple):
    """A mean, and half of its interval; NaN for less than two values."""

    value: float
    half: float


class Difference(NamedTuple):
    """How much less one mode takes than another, as a share of the other."""

    saved: float
    low: float
    high: float
    p: float  # of no difference, two-sided
    pairs: int


def mean(values: Sequence[float]) -> Mean:
    """Return a mean with its interval."""
    x = np.asarray(values, dtype=np.float64)
    if len(x) < 2:
        return Mean(float(x.mean()) if len(x) else math.nan, math.nan)
    return Mean(float(x.mean()), _half(x))


def difference(ours: Sequence[float], theirs: Sequence[float]) -> Difference:
    """Return what is saved against the other mode.

    Args:
        ours: times, a person each.
        theirs: of the same persons in the other mode.
    """
    ratio = np.log(np.asarray(ours) / np.asarray(theirs))
    if len(ratio) < 2:
        saved = 1.0 - math.exp(float(ratio[0])) if len(ratio) else math.nan
        return Difference(saved, math.nan, math.nan, math.nan, len(ratio))
    middle, half = float(ratio.mean()), _half(ratio)
    p = float(scipy.stats.ttest_1samp(ratio, 0.0).pvalue) if ratio.any() else 1.0
    return Difference(
        1.0 - math.exp(middle), 1.0 - math.exp(middle + half), 1.0 - math.exp(middle - half), p, len(ratio)
    )


def _half(x: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> float:
    """Return half of the interval of a mean."""
    t = float(scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, len(x) - 1))
    return t * float(x.std(ddof=1)) / math.sqrt(len(x))
