"""Are a channel's residuals white, at the rate at which its sensor was sampled?

A sensor that is slower than the record repeats its readings, and the repeated rows are left out (NaN). Lags
count the sensor's own samples, not the record's rows.
"""

from typing import NamedTuple

import numpy as np

from forest_description.types import Bools, Floats

LAGS = 40


class ResidualTest(NamedTuple):
    """What is left of a channel after a fit."""

    channel: str
    noise: float  # [unit] RMS of its residuals
    times: float  # over the sensor's own noise
    samples: int
    correlation: float | None  # at the sensor's lag 1


def stride(good: Bools) -> int:
    """Return after how many rows a sensor has its next sample."""
    apart = np.diff(np.flatnonzero(good))
    return int(np.median(apart)) if len(apart) else 1


def autocorrelation(residual: Floats, lags: int = LAGS) -> Floats | None:
    """Return the autocorrelation at the sensor's lags 1 .. n over the finite rows; None for too few rows."""
    good = np.isfinite(residual)
    if good.sum() < 10 * lags:
        return None
    step = stride(good)
    r = np.where(good, residual - np.mean(residual[good]), 0.0)
    rows = [k * step for k in range(1, lags + 1) if k * step < len(r)]
    pairs = np.array([good[:-k] @ good[k:].astype(float) for k in rows])
    products = np.array([r[:-k] @ r[k:] for k in rows])
    power = float(r @ r) / float(good.sum())
    return np.asarray(products / np.maximum(pairs, 1.0) / max(power, 1e-300), dtype=np.float64)
