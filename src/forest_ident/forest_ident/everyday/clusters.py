"""Covariance of a fit whose residuals hang together within a segment, and not between segments.

    D_s = (H - H_s)^-1 g_s,   V = (S-1)/S sum over s of (D_s - mean)(D_s - mean)' + H^-1 K H^-1

| symbol | name |
|---|---|
| H_s, g_s | J'J and J'r of segment s |
| H, K | sum of the H_s, and the prior's information K |
| D_s | move of theta when s is left out |
| S | number of segments |
| S_i | those that tell of parameter i: (sum of w)^2 / sum of w^2, w their shares of its information |

The jackknife (CR3 of MacKinnon and White) does not trust a fit to a segment that alone tells of a parameter,
and widens where models miss. A parameter's standard error is widened to Student's interval of S_i - 1 degrees
of freedom. The noise that weighs the channels drops out.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from forest_description.types import Floats
from forest_ident.estimators.parameter_estimate import NORMAL_95
from forest_ident.output_error.fit_problem import Columns, Jacobian, Problem
from forest_ident.output_error.gaussian_estimate import covariance_of

LEAST = 2.0  # segments that tell of a parameter, as its interval counts them


class Normal(NamedTuple):
    """Information and gradient by segment."""

    information: Floats  # H_s (segments, theta, theta)
    gradient: Floats  # g_s (segments, theta)


def normal(
    problem: Problem, theta: Floats, predicted: Columns, jacobian: Jacobian, starts: Sequence[int]
) -> Normal:
    """Return what each segment tells; starts: the first row of each."""
    size = len(theta)
    information, gradient = np.zeros((len(starts), size, size)), np.zeros((len(starts), size))
    for _, residual, j in problem.rows(theta, predicted, jacobian):
        edges = [*starts, len(residual)]
        for place, (first, last) in enumerate(pairwise(edges)):
            own = j[first:last]
            information[place] += own.T @ own
            gradient[place] += own.T @ residual[first:last]
    return Normal(information, gradient)


class Untaken(NamedTuple):
    """The step that derivatives still ask for."""

    step: Floats
    promise: float  # fall of the cost


def untaken(told: Normal, known: Floats, away: Floats) -> Untaken:
    """Return what is left of a search; arguments as `errors`."""
    total = np.sum(told.information, axis=0) + known
    step = -covariance_of(total) @ (np.sum(told.gradient, axis=0) + away)
    return Untaken(step, float(step @ total @ step))


def errors(told: Normal, known: Floats, away: Floats) -> Floats:
    """Return the standard error of each theta, of which 1.96 are its 95 % interval.

    The step that derivatives still ask for counts as an error.

    Args:
        told: by segment.
        known: the prior's information K.
        away: K (theta - m), the prior's part of the gradient.
    """
    total, count = np.sum(told.information, axis=0) + known, len(told.gradient)
    spread = covariance_of(total)
    moves = np.array(
        [covariance_of(total - own) @ pull for own, pull in zip(told.information, told.gradient, strict=True)]
    )
    scattered = moves - np.mean(moves, axis=0)
    scatter = (count - 1.0) / count * np.sum(scattered**2, axis=0)
    variance = scatter + np.diag(spread @ known @ spread) + untaken(told, known, away).step ** 2
    shares = np.array([np.diag(spread @ own @ spread) for own in told.information])
    telling = np.sum(shares, axis=0) ** 2 / np.maximum(np.sum(shares**2, axis=0), 1e-300)
    student = scipy.stats.t.ppf(0.975, np.maximum(telling, LEAST) - 1.0)
    return np.asarray(np.sqrt(variance) * student / NORMAL_95)
