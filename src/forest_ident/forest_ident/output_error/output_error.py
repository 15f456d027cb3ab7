"""Estimate parameters by output error: the simulator, driven by the same voltages, shall read the same.

    minimise  sum over channels k and rows n of  ((y_kn - b_k - (1 + g_k) yhat_kn(theta)) / sigma_k)^2
              + sum over the prior of ((theta_i - m_i) / s_i)^2

| symbol | name |
|---|---|
| y, yhat | read and predicted columns |
| theta | parameters; those that are positive by their logarithm |
| b, g | static errors of the sensors, within their accuracy: estimated along, with that as prior |
| sigma | noise of a channel: the machine file's, or the RMS of its residuals if that is more |
| m, s | estimate and standard error from earlier experiments |

Readings at a meter's floor, or at a transducer's zero, are censored: they only show that the true value is
below. They count with the logarithm of that probability (`fit_problem`). Gauss-Newton with Marquardt's
damping is kept on purpose: scipy's least_squares knows neither censored rows nor noise that is estimated
along, and takes a simulation per parameter for each step. Here derivatives are kept while steps shrink.

The covariance is that of white residuals. Where the scatter over blocks of `BLOCK` rows shows that they are
not white, the record's share is widened, for all parameters alike (`Problem.covariance`).
Derivatives and other changes may come from a rougher model, which takes half the time: a search ends where
the exact model's residuals are at right angles to them, that is within some hundredths of a standard error.
The noise of the model's own measured inputs shows in no residual: it is drawn again, and its effect added.

Thesis section 4.1.2. Differs: the thesis estimates each parameter by a linear least-squares fit of its own;
those are where this starts.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from forest_description.types import Floats
from forest_ident.output_error.fit_problem import Channel, Columns, Fit, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import (
    EMPTY,
    GaussianEstimate,
    condition_number,
    covariance_of,
    updated,
)
from forest_ident.output_error.search import End, Model, Search, after

BLOCK = 200  # rows of one block of the sandwich
REFUSED = 0.05  # share of the cost, or of the rows, that derivatives promise where a search got stuck


def fit(
    model: Model,
    measured: Columns,
    channels: Sequence[Channel],
    unknowns: Sequence[Unknown],
    progress: Callable[[], None] = lambda: None,
    block: int = BLOCK,
    prior: GaussianEstimate = EMPTY,
    redrawn: Sequence[Model] = (),
    stated: Sequence[Mapping[str, float]] = (),
    rough: Model | None = None,
    near: bool = False,
) -> Fit:
    """Return the parameters that explain the measured columns best.

    Args:
        model: parameters by key to predicted columns; a simulation.
        measured: columns by channel.
        channels: which count, and how.
        unknowns: what is estimated.
        progress: called after every simulation.
        block: rows within which residuals may be correlated.
        prior: what earlier fits found, of parameters and of the sensors' static errors.
        redrawn: the rough model again, each time with the noise of its inputs drawn once more.
        stated: parameters that are not estimated, each moved by its standard deviation, by key.
        rough: a quicker model, whose changes are near those of the model; without it the model itself.
        near: whether derivatives must be those next to the end (`search.NEAR`).
    """
    problem = Problem(measured=measured, channels=channels, unknowns=unknowns, block=block, prior=prior)
    before = prior.moves(problem.names, len(stated))
    search = Search(model, rough or model, problem, unknowns, channels, progress, redrawn, stated, near)
    return _told(problem, unknowns, search.end(before), prior, before)


def _told(
    problem: Problem, unknowns: Sequence[Unknown], end: End, prior: GaussianEstimate, before: Floats
) -> Fit:
    """Return values and uncertainties at the end of a search."""
    theta, predicted, jacobian = end.at.theta, end.at.predicted, end.jacobian
    inputs, stated = (
        [after(predicted, one) for one in effects] for effects in (end.effects.inputs, end.effects.stated)
    )
    normal = information, gradient = problem.normal(theta, predicted, jacobian)
    hessian = information + problem.known
    # The step that derivatives still ask for: where chance refuses it, it counts as an error.
    untaken = -covariance_of(hessian) @ (gradient + problem.known @ (theta - problem.mean))
    covariance = problem.covariance(theta, predicted, jacobian, normal, inputs) + np.outer(untaken, untaken)
    values = problem.values(theta)
    told = problem.stated_effect(theta, predicted, jacobian, stated, before)
    sds = np.sqrt(np.maximum(np.diag(covariance), 0.0))[: problem.count].tolist()
    pairs = zip(unknowns, sds, strict=True)
    usual = max(problem.cost(theta, predicted), sum(len(column) for column in predicted.values()))
    refused = float(untaken @ hessian @ untaken) > REFUSED * usual
    return Fit(
        values=values,
        errors={u.key: sd * values[u.key] if u.positive else sd for u, sd in pairs},
        condition=condition_number(hessian[: problem.count, : problem.count]),
        posterior=updated(prior, problem.names, theta, covariance, told.slopes if stated else None),
        residuals=problem.residuals(theta, predicted),
        noise=dict(problem.sigma),
        iterations=end.iterations,
        stated_noise=told.noise,
        converged=end.converged and not refused,
        asked=told.asked,
    )
