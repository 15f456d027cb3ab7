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

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from forest_description.config.parameter import MachineError
from forest_description.types import Floats
from forest_ident.output_error.fit_problem import FAR, Channel, Columns, Fit, Jacobian, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import (
    EMPTY,
    GaussianEstimate,
    condition_number,
    covariance_of,
    inverse,
    updated,
)

BLOCK = 200  # rows of one block of the sandwich
ITERATIONS = 20
DAMPING = 1e-6  # at the start: so small that correlated parameters may move together
TRIES = 8  # of one step, each with more damping
CONVERGED = 0.1  # of the standard errors, that the last step moved what other records feel, too
STALE = 0.03  # of a positive parameter, from where derivatives were taken, to take them again
SLOW = 0.3  # of the last step; after a longer step derivatives are taken again, too
LITTLE = 0.03  # by which a step lowers the cost at least, if the search is to go on: 1 is a standard error
REFUSED = 0.05  # share of the cost, or of the rows, that derivatives promise where a search got stuck
USELESS = 0.01  # share of the cost, the same, where the model does not explain the record

Model = Callable[[Mapping[str, float]], Columns]


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
    """
    problem = Problem(measured=measured, channels=channels, unknowns=unknowns, block=block, prior=prior)
    return _Search(model, rough or model, problem, unknowns, channels, progress).fit(prior, redrawn, stated)


def damped_step(
    hessian: Floats, slope: Floats, damping: float, least: float, reach: Floats | float
) -> Floats:
    """Return Marquardt's step: -(H + d diag(H + least))^-1 slope, clipped to the reach.

    Args:
        hessian: H, J'J and the prior's information.
        slope: gradient of half the cost.
        damping: d.
        least: added to the diagonal, for directions without information.
        reach: of each parameter, at most.
    """
    damped = hessian + damping * np.diag(np.diag(hessian) + least)
    return np.clip(-np.linalg.solve(damped, slope), -reach, reach)


class _End(NamedTuple):
    """Where a search has ended."""

    theta: Floats
    predicted: dict[str, Floats]
    jacobian: list[dict[str, Floats]]
    iterations: int
    converged: bool


class _Search:
    """Gauss-Newton on a problem. Derivatives, a simulation each, are kept as long as steps grow shorter."""

    def __init__(
        self,
        model: Model,
        rough: Model,
        problem: Problem,
        unknowns: Sequence[Unknown],
        channels: Sequence[Channel],
        progress: Callable[[], None],
    ) -> None:
        self._model, self._rough, self._problem, self._progress = model, rough, problem, progress
        self._unknowns, self._channels = unknowns, channels

    def fit(
        self, prior: GaussianEstimate, redrawn: Sequence[Model], stated: Sequence[Mapping[str, float]]
    ) -> Fit:
        """Return the end of the search; arguments as `fit`."""
        return self._told(self._searched(), prior, redrawn, stated)

    def _searched(self) -> _End:
        """Return where the cost falls no further."""
        problem, theta, damping, last = self._problem, self._problem.mean.copy(), DAMPING, math.inf
        predicted = self._simulate(self._model, theta)
        problem.update_noise(theta, predicted)
        jacobian, taken, fresh, iterations = self._derivatives(theta, predicted), theta, True, 0
        converged = False
        while not converged and iterations < ITERATIONS:
            iterations += 1
            theta, predicted, damping, moved, fall = self._step(theta, predicted, jacobian, damping)
            problem.update_noise(theta, predicted)
            stale = self._distance(theta, taken) > STALE
            ended = CONVERGED > moved > 0.0 or (fresh and fall < LITTLE)
            converged = (ended and not stale) or (moved > 0.0 and fall < self._useless(theta, predicted))
            fresh = stale or moved > SLOW * last or moved == 0.0
            last = math.inf if fresh else moved
            if fresh and not converged:
                jacobian, taken = self._derivatives(theta, predicted), theta
        return _End(theta, predicted, jacobian, iterations, converged)

    def _told(
        self,
        end: _End,
        prior: GaussianEstimate,
        redrawn: Sequence[Model],
        stated: Sequence[Mapping[str, float]],
    ) -> Fit:
        """Return values and uncertainties at the end of the search."""
        problem, theta, predicted, jacobian = self._problem, end.theta, end.predicted, end.jacobian
        base = self._base(theta, predicted)

        def after(model: Model, number: Mapping[str, float]) -> Columns:
            moved = self._simulate(model, theta, number)
            return {name: column + (moved[name] - base[name]) for name, column in predicted.items()}

        inputs = [after(model, MappingProxyType({})) for model in redrawn]
        untaken = self._untaken(theta, predicted, jacobian)
        covariance = problem.covariance(theta, predicted, jacobian, inputs) + np.outer(untaken, untaken)
        values = problem.values(theta)
        others = [after(self._rough, number) if number else predicted for number in stated]
        before = prior.moves(problem.names, len(stated))
        slopes, stated_noise = problem.stated_effect(theta, predicted, jacobian, others, before)
        sds = np.sqrt(np.maximum(np.diag(covariance), 0.0))[: problem.count].tolist()
        pairs = zip(self._unknowns, sds, strict=True)
        information = problem.normal(theta, predicted, jacobian)[0] + problem.known
        usual = max(problem.cost(theta, predicted), sum(len(column) for column in predicted.values()))
        refused = float(untaken @ information @ untaken) > REFUSED * usual
        return Fit(
            values=values,
            errors={u.key: sd * values[u.key] if u.positive else sd for u, sd in pairs},
            condition=condition_number(information[: problem.count, : problem.count]),
            posterior=updated(prior, problem.names, theta, covariance, slopes),
            residuals=problem.residuals(theta, predicted),
            noise=dict(problem.sigma),
            iterations=end.iterations,
            stated_noise=stated_noise,
            converged=end.converged and not refused,
        )

    def _untaken(self, theta: Floats, predicted: dict[str, Floats], jacobian: Jacobian) -> Floats:
        """Return the step that derivatives still ask for: where chance refuses it, it counts as an error."""
        information, gradient = self._problem.normal(theta, predicted, jacobian)
        known = self._problem.known
        return -covariance_of(information + known) @ (gradient + known @ (theta - self._problem.mean))

    def _distance(self, theta: Floats, taken: Floats) -> float:
        """Return how far positive parameters are from where derivatives were taken; others act linearly."""
        moves = np.abs(theta - taken)[: len(self._unknowns)].tolist()
        return max((m for m, u in zip(moves, self._unknowns, strict=True) if u.positive), default=0.0)

    def _simulate(
        self, model: Model, theta: Floats, stated: Mapping[str, float] = MappingProxyType({})
    ) -> dict[str, Floats]:
        columns = model({**self._problem.values(theta), **stated})
        self._progress()
        return {c.name: np.asarray(columns[c.name], dtype=np.float64) for c in self._channels}

    def _base(self, theta: Floats, predicted: dict[str, Floats]) -> dict[str, Floats]:
        """Return what the rough model predicts: changes are counted from there."""
        return predicted if self._rough is self._model else self._simulate(self._rough, theta)

    def _useless(self, theta: Floats, predicted: dict[str, Floats]) -> float:
        """Return how little of the cost is not worth a step more, where the record is not explained."""
        far = any(self._problem.sigma[c.name] > FAR * c.noise for c in self._channels)
        return USELESS * self._problem.cost(theta, predicted) if far else 0.0

    def _derivatives(self, theta: Floats, predicted: dict[str, Floats]) -> list[dict[str, Floats]]:
        found, base = [], self._base(theta, predicted)
        for place, unknown in enumerate(self._unknowns):
            after, difference = self._moved(theta, place, unknown.difference)
            found.append({name: (after[name] - column) / difference for name, column in base.items()})
        return found

    def _moved(self, theta: Floats, place: int, difference: float) -> tuple[dict[str, Floats], float]:
        """Return what a moved parameter predicts, and its move: downwards where no machine is above."""
        moved = theta.copy()
        moved[place] += difference
        try:
            return self._simulate(self._rough, moved), difference
        except MachineError:
            moved[place] -= 2.0 * difference
            return self._simulate(self._rough, moved), -difference

    def _step(
        self,
        theta: Floats,
        predicted: dict[str, Floats],
        jacobian: Jacobian,
        damping: float,
    ) -> tuple[Floats, dict[str, Floats], float, float, float]:
        """Return theta after a step that lowers the cost, what it predicts, damping, its move and fall."""
        problem = self._problem
        information, gradient = problem.normal(theta, predicted, jacobian)
        hessian = information + problem.known
        slope = gradient + problem.known @ (theta - problem.mean)
        before = problem.cost(theta, predicted)
        for _ in range(TRIES):
            move = damped_step(hessian, slope, damping, 1e-30, problem.reach)
            try:
                after = self._simulate(self._model, theta + move)
                fall = before - problem.cost(theta + move, after)
            except (MachineError, ValueError):
                fall = -math.inf
            if fall >= 0.0:
                errors = np.sqrt(np.maximum(np.diag(inverse(hessian)), 1e-300))
                moved = float(np.max((np.abs(move) / errors)[problem.lasting], initial=1e-300))
                return theta + move, after, damping / 10.0, moved, fall
            damping = 10.0 * max(damping, 1e-3)
        return theta, predicted, damping, 0.0, 0.0
