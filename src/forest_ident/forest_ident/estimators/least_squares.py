"""Linear least squares: estimate, standard errors and condition number.

    y = X theta + e,  theta = (X'X)^-1 X'y

The covariance does not assume white residuals: (X'X)^-1 (sum over blocks of s_b s_b') (X'X)^-1 with the
blocks' scores s_b = sum of x_n e_n (a sandwich). Thesis section 4.1.2.2.
"""

from typing import NamedTuple

import numpy as np

from forest_description.types import Floats


class LinearFit(NamedTuple):
    """Result of a linear fit."""

    values: Floats  # [p]
    errors: Floats  # [p] standard errors
    condition: float  # of X with columns of length 1
    residuals: Floats  # [N]
    covariance: Floats  # [p, p]

    @property
    def first(self) -> tuple[float, float]:
        """The first parameter and its standard error."""
        return float(self.values[0]), float(self.errors[0])


def solve(columns: list[Floats], y: Floats, block: int = 200) -> LinearFit:
    """Return theta for y = sum of columns times theta. Thesis section 4.1.2.2.

    Args:
        columns: of X, p of N rows.
        y: N rows.
        block: rows within which residuals may be correlated.
    """
    x = np.column_stack(columns)
    scale = np.linalg.norm(x, axis=0)
    scale[scale == 0.0] = 1.0
    scaled = x / scale
    theta, _, _, singular = np.linalg.lstsq(scaled, y, rcond=None)
    residuals = y - scaled @ theta
    inverse = np.linalg.pinv(scaled.T @ scaled, hermitian=True)
    count = len(y) // block + 1
    scores = np.zeros((count, x.shape[1]))
    np.add.at(scores, np.arange(len(y)) // block, scaled * residuals[:, np.newaxis])
    spare = max(count - x.shape[1], 1)
    covariance = inverse @ (scores.T @ scores) @ inverse * count / spare
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0.0 else float("inf")
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0)) / scale
    return LinearFit(theta / scale, errors, condition, residuals, covariance / np.outer(scale, scale))
