"""What output error needs of statistics: censored readings, whose scatter counts, condition numbers.

| symbol | name |
|---|---|
| z | bound less what is said of a reading, over sigma |
| blocks | of rows within which residuals may hang together |
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import log_ndtr

from forest_description.types import Bools, Floats

CERTAIN = 2.0  # standard errors of the scatter's excess at which half of it is believed


def inflation(scores: Floats, white: Floats) -> Floats:
    """Return the factor (1 or more) on each parameter's variance, since residuals are not white.

    F = sum of scores^2 / sum of white is 1 +- sqrt(2/n) for white residuals, n blocks that have a say. Its
    excess d = F - 1 counts as d^3/(d^2 + 4 * 2/n): chance is not believed, what is far from it is. Where one
    or two blocks hold nearly all that is known of a parameter, the fit has made just their scores small, and
    their scatter says nothing.

    Args:
        scores: of the blocks, each its pull on every parameter (blocks, parameters).
        white: variance that each block would add if residuals were white (blocks, parameters).
    """
    total, squares = np.sum(white, axis=0), np.sum(white**2, axis=0)
    blocks = np.maximum(total**2 / np.maximum(squares, 1e-300), 1.0)
    excess = np.maximum(np.sum(scores**2, axis=0) / np.maximum(total, 1e-300) - 1.0, 0.0)
    chance = CERTAIN**2 * 2.0 / blocks
    return np.asarray(1.0 + excess**3 / (excess**2 + chance), dtype=np.float64)


def censor(
    residual: Floats,
    slope: Floats,
    rows: Bools,
    said: Floats,
    bound: float,
    sigma: float,
    sign: Floats,
) -> None:
    """Put sqrt(-2 ln P(reading is below the bound)) into the rows that are censored."""
    z = (bound - said[rows]) / sigma
    logarithm = log_ndtr(z)
    size = np.sqrt(np.maximum(-2.0 * logarithm, 1e-300))
    density = np.exp(-0.5 * z * z - 0.5 * math.log(2.0 * math.pi) - logarithm)
    residual[rows] = size
    slope[rows] = np.where(size > 1e-12, density / (sigma * np.maximum(size, 1e-12)), 0.0) * sign[rows]


def condition_number(information: Floats) -> float:
    """Return the condition number of J with its columns brought to length 1: sqrt of that of D J'J D."""
    scale = np.sqrt(np.diag(information))
    if len(scale) == 0 or np.any(scale <= 0.0):
        return math.inf
    values = np.linalg.eigvalsh(information / np.outer(scale, scale))
    return math.sqrt(float(values[-1] / values[0])) if values[0] > 0.0 else math.inf
