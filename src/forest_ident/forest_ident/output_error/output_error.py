"""Output error: the parameters with which the simulator, driven by the same voltages, reads what was read.

    minimise  sum over channels k and rows n of  ((y_kn - b_k - (1 + g_k) yhat_kn(theta)) / sigma_k)^2
              + sum over what is known beforehand of ((theta_i - m_i) / s_i)^2

| symbol | name |
|---|---|
| y, yhat | read and predicted columns |
| theta | parameters; those that are positive by their logarithm |
| b, g | static errors of the sensors, within their accuracy: estimated along, with that as prior |
| sigma | noise of a channel, as the machine file says, or what is left if that is more |
| m, s | estimate and standard error from earlier experiments |

Readings at a meter's floor, or at a transducer's zero, are censored: what is said of them is only that the
true value is below, so they count with the logarithm of that probability. Gauss-Newton with Marquardt's
damping; derivatives by forward differences, each a simulation. The covariance is the usual one, of white
residuals, with every variance widened to that of the sandwich over blocks of `BLOCK` rows where the scatter
of the blocks shows that residuals are not white (`fit_statistics.inflation`). What the noise of the model's
own measured inputs does to the estimates shows in no residual; it is tried, by drawing that noise once more.

Thesis section 4.1.2. Differs: the thesis estimates each parameter by a linear least-squares fit of its own;
those are where this starts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from forest_description.machine import MachineError
from forest_description.types import Floats
from forest_ident.output_error.fit_problem import Channel, Columns, Fit, Jacobian, Problem, Unknown
from forest_ident.output_error.fit_statistics import condition_number
from forest_ident.output_error.gaussian_estimate import NOTHING, Belief, inverse, updated

__all__ = ["Channel", "Fit", "Model", "Unknown", "fit"]


BLOCK = 200  # rows of one block of the sandwich
ITERATIONS = 20
DAMPING = 1e-6  # to begin with: parameters that hang together move along what they hardly tell, too
CONVERGED = 0.1  # of the standard errors, that the last step moved
STALE = (
    300.0  # differences (3 %) that a parameter is away from where derivatives were taken, to take them anew
)
SLOW = 0.3  # of the last step; a step that is longer wants new derivatives, too

Model = Callable[[Mapping[str, float]], Columns]


def fit(
    model: Model,
    measured: Columns,
    channels: Sequence[Channel],
    unknowns: Sequence[Unknown],
    progress: Callable[[], None] = lambda: None,
    block: int = BLOCK,
    belief: Belief = NOTHING,
    redrawn: Sequence[Model] = (),
) -> Fit:
    """Return the parameters that explain the measured columns best.

    Args:
        model: parameters by key to predicted columns; a simulation.
        measured: columns by channel.
        channels: which count, and how.
        unknowns: what is estimated.
        progress: called after every simulation.
        block: rows within which residuals may hang together.
        belief: what earlier fits found, of parameters and of the sensors' static errors.
        redrawn: the model again, each time with the noise of what it was fed once more.
    """
    problem = Problem(measured, channels, unknowns, block, belief)
    return _Search(model, problem, unknowns, channels, progress, redrawn).fit(belief)


class _Search:
    """Gauss-Newton on a problem. Derivatives, a simulation each, are kept as long as steps grow shorter."""

    def __init__(
        self,
        model: Model,
        problem: Problem,
        unknowns: Sequence[Unknown],
        channels: Sequence[Channel],
        progress: Callable[[], None],
        redrawn: Sequence[Model],
    ) -> None:
        self._redrawn = redrawn
        self._model, self._problem, self._progress = model, problem, progress
        self._unknowns, self._channels = unknowns, channels

    def fit(self, belief: Belief) -> Fit:
        """Return the end of the search; ``belief`` as in `fit`."""
        problem, theta, damping, last = self._problem, self._problem.mean.copy(), DAMPING, math.inf
        predicted = self._simulate(self._model, theta)
        problem.learn_noise(theta, predicted)
        jacobian, taken, fresh, iterations = self._derivatives(theta, predicted), theta, True, 0
        while iterations < ITERATIONS:
            iterations += 1
            theta, predicted, damping, moved = self._step(theta, predicted, jacobian, damping)
            problem.learn_noise(theta, predicted)
            stale = self._away(theta, taken) > STALE
            if not stale and (CONVERGED > moved > 0.0 or (fresh and moved == 0.0)):
                break
            fresh = stale or moved > SLOW * last or moved == 0.0
            last = math.inf if fresh else moved
            if fresh:
                jacobian, taken = self._derivatives(theta, predicted), theta
        return self._finished(theta, predicted, jacobian, iterations, belief)

    def _away(self, theta: Floats, taken: Floats) -> float:
        """Return how far parameters are from where derivatives were taken, in their differences."""
        moves = np.abs(theta - taken)[: len(self._unknowns)]
        return max((m / u.difference for m, u in zip(moves, self._unknowns, strict=True)), default=0.0)

    def _simulate(self, model: Model, theta: Floats) -> dict[str, Floats]:
        of = model(self._problem.values(theta))
        self._progress()
        return {c.name: np.asarray(of[c.name], dtype=np.float64) for c in self._channels}

    def _derivatives(self, theta: Floats, predicted: Mapping[str, Floats]) -> list[dict[str, Floats]]:
        found = []
        for place, unknown in enumerate(self._unknowns):
            moved = theta.copy()
            moved[place] += unknown.difference
            after = self._simulate(self._model, moved)
            found.append(
                {name: (after[name] - column) / unknown.difference for name, column in predicted.items()}
            )
        return found

    def _step(
        self,
        theta: Floats,
        predicted: dict[str, Floats],
        jacobian: Jacobian,
        damping: float,
    ) -> tuple[Floats, dict[str, Floats], float, float]:
        """Return theta after a step that lowers the cost, what it predicts, damping, how far it moved."""
        information, gradient = self._problem.normal(theta, predicted, jacobian)
        hessian = information + self._problem.known
        slope = gradient + self._problem.known @ (theta - self._problem.mean)
        before = self._problem.cost(theta, predicted)
        for _ in range(8):
            damped = hessian + damping * np.diag(np.diag(hessian) + 1e-30)
            move = -np.linalg.solve(damped, slope)
            move = np.clip(move, -self._problem.reach, self._problem.reach)
            try:
                after = self._simulate(self._model, theta + move)
            except (MachineError, ValueError):
                damping = 10.0 * max(damping, 1e-3)
                continue
            if self._problem.cost(theta + move, after) <= before:
                errors = np.sqrt(np.maximum(np.diag(inverse(hessian)), 1e-300))
                return theta + move, after, damping / 10.0, float(np.max(np.abs(move) / errors))
            damping = 10.0 * max(damping, 1e-3)
        return theta, predicted, damping, 0.0

    def _finished(
        self,
        theta: Floats,
        predicted: dict[str, Floats],
        jacobian: Jacobian,
        iterations: int,
        belief: Belief,
    ) -> Fit:
        problem = self._problem
        information, _ = self._problem.normal(theta, predicted, jacobian)
        inputs = [self._simulate(model, theta) for model in self._redrawn]
        covariance = problem.covariance(theta, predicted, jacobian, inputs)
        values, errors = self._problem.values(theta), {}
        for place, u in enumerate(self._unknowns):
            error = math.sqrt(max(covariance[place, place], 0.0))
            errors[u.key] = error * values[u.key] if u.positive else error
        residuals = {}
        for c in self._channels:
            residual, _, seen = problem.row(c, problem.said(theta, c.name, predicted[c.name]))
            residuals[c.name] = np.where(seen, residual, np.nan)
        said = {name: problem.said(theta, name, column) for name, column in predicted.items()}
        return Fit(
            values=values,
            errors=errors,
            condition=condition_number((information + problem.known)[: problem.count, : problem.count]),
            belief=updated(belief, problem.names, theta, covariance),
            residuals=residuals,
            predicted=said,
            noise=dict(problem.sigma),
            iterations=iterations,
        )
