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
from collections.abc import Callable, Collection, Mapping, Sequence
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
SHARE = 0.25  # of a standard error, the same: what hardly acts may move far
SLOW = 0.3  # of the last step; after a longer step derivatives are taken again, too
LITTLE = 0.03  # by which a step lowers the cost at least, if the search is to go on: 1 is a standard error
REFUSED = 0.05  # share of the cost, or of the rows, that derivatives promise where a search got stuck
DRAWS = 2  # of the inputs' noise, after which there are more only if these count
COUNTS = 0.2  # of a standard error: the least that counts
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


class _Changes(NamedTuple):
    """How predictions change around a point, by the rough model."""

    taken: Floats  # theta of the point
    jacobian: list[dict[str, Floats]]
    stated: list[Columns]  # by a standard deviation of each stated number; empty ones are not felt
    inputs: list[Columns]  # by the noise of the model's inputs, drawn once more


class _Place(NamedTuple):
    """Where a step has led."""

    theta: Floats
    predicted: dict[str, Floats]
    damping: float  # of the next step
    moved: float  # greatest move of what is passed on, in standard errors, stated numbers counted
    fall: float  # of the cost
    errors: Floats  # standard errors of theta


class _End(NamedTuple):
    """Where a search has ended."""

    theta: Floats
    predicted: dict[str, Floats]
    changes: _Changes
    iterations: int
    converged: bool


class _Search:
    """Gauss-Newton on a problem: by the rough model while steps are long, by the exact one at the end.

    Derivatives, a simulation each, are kept as long as steps grow shorter.
    """

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
        self._unknowns, self._channels, self._every = unknowns, channels, range(len(unknowns))

    def fit(
        self, prior: GaussianEstimate, redrawn: Sequence[Model], stated: Sequence[Mapping[str, float]]
    ) -> Fit:
        """Return the end of the search; arguments as `fit`."""
        before = prior.moves(self._problem.names, len(stated))
        return self._told(self._searched(redrawn, stated, before), prior, before)

    def _searched(
        self, redrawn: Sequence[Model], stated: Sequence[Mapping[str, float]], before: Floats
    ) -> _End:
        """Return where the cost falls no further."""
        at, base, iterations = self._approached()
        changes = self._changes(at, base, redrawn, stated)
        moves = self._stated_effect(at.theta, at.predicted, changes, before)[0]
        least = np.hypot(np.sqrt(np.sum(moves**2, axis=1)), self._problem.rounded)
        last, fresh, converged = math.inf, True, False
        while not converged and iterations < ITERATIONS:
            iterations += 1
            at = self._step(self._model, at, changes.jacobian, least)
            stale = self._is_stale(at, changes.taken)
            ended = CONVERGED > at.moved > 0.0 or ((at.moved > 0.0 or fresh) and at.fall < LITTLE)
            converged = (ended and not stale) or (at.moved > 0.0 and at.fall < self._useless(at))
            fresh = stale or at.moved > SLOW * last or at.moved == 0.0
            last = math.inf if fresh else at.moved
            if fresh and not converged:
                jacobian = self._derivatives(at, self._base(at), self._every)
                changes = changes._replace(jacobian=jacobian, taken=at.theta)
        return _End(at.theta, at.predicted, changes, iterations, converged)

    def _approached(self) -> tuple[_Place, dict[str, Floats], int]:
        """Return where steps of the rough model in what begins far off lead.

        With it: what the rough model predicts there, and the number of steps.
        """
        begun = [place for place in self._every if self._unknowns[place].begun]
        at, steps = self._place(self._rough, self._problem.mean), 0
        taken, jacobian = at.theta, self._derivatives(at, at.predicted, begun)
        while begun and steps < ITERATIONS:
            at, steps = self._step(self._rough, at, jacobian, 0.0), steps + 1
            if at.fall < USELESS * self._problem.cost(at.theta, at.predicted):
                break
            if self._is_stale(at, taken):
                taken, jacobian = at.theta, self._derivatives(at, at.predicted, begun)
        if self._rough is self._model:
            return at, at.predicted, steps
        return self._place(self._model, at.theta), at.predicted, steps

    def _place(self, model: Model, theta: Floats) -> _Place:
        """Return a place where a search begins."""
        predicted = self._simulate(model, theta)
        self._problem.update_noise(theta, predicted)
        return _Place(theta, predicted, DAMPING, 0.0, 0.0, np.zeros(len(theta)))

    def _changes(
        self,
        at: _Place,
        base: dict[str, Floats],
        redrawn: Sequence[Model],
        stated: Sequence[Mapping[str, float]],
    ) -> _Changes:
        """Return the changes of predictions around a place."""

        def change(model: Model, number: Mapping[str, float]) -> Columns:
            moved = self._simulate(model, at.theta, number)
            return {name: moved[name] - column for name, column in base.items()}

        jacobian = self._derivatives(at, base, self._every)
        inputs = [change(model, {}) for model in redrawn[:DRAWS]]
        if inputs and self._count(at, jacobian, inputs):
            inputs += [change(model, {}) for model in redrawn[DRAWS:]]
        return _Changes(at.theta, jacobian, [change(self._rough, n) if n else {} for n in stated], inputs)

    def _count(self, at: _Place, jacobian: Jacobian, inputs: Sequence[Columns]) -> bool:
        """Tell whether draws of the inputs' noise move what is passed on so far that more are worth it."""
        after = [_after(at.predicted, one) for one in inputs]
        moves, errors = self._problem.moves_of_inputs(at.theta, at.predicted, jacobian, after)
        return bool(np.any((np.abs(moves) > COUNTS * errors)[:, self._problem.lasting]))

    def _stated_effect(
        self, theta: Floats, predicted: dict[str, Floats], changes: _Changes, before: Floats
    ) -> tuple[Floats, dict[str, float]]:
        """Return how stated numbers move theta, and what they may leave in each channel."""
        moved = [_after(predicted, change) for change in changes.stated]
        return self._problem.stated_effect(theta, predicted, changes.jacobian, moved, before)

    def _told(self, end: _End, prior: GaussianEstimate, before: Floats) -> Fit:
        """Return values and uncertainties at the end of the search."""
        problem, theta, predicted, jacobian = self._problem, end.theta, end.predicted, end.changes.jacobian
        inputs = [_after(predicted, change) for change in end.changes.inputs]
        untaken = self._untaken(theta, predicted, jacobian)
        covariance = problem.covariance(theta, predicted, jacobian, inputs) + np.outer(untaken, untaken)
        values = problem.values(theta)
        slopes, stated_noise = self._stated_effect(theta, predicted, end.changes, before)
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

    def _is_stale(self, at: _Place, taken: Floats) -> bool:
        """Tell whether a positive parameter is far from where derivatives were taken; others act linearly."""
        moves = np.abs(at.theta - taken) > np.maximum(STALE, SHARE * at.errors)
        return any(move and u.positive for move, u in zip(moves.tolist(), self._unknowns, strict=False))

    def _simulate(
        self, model: Model, theta: Floats, stated: Mapping[str, float] = MappingProxyType({})
    ) -> dict[str, Floats]:
        columns = model({**self._problem.values(theta), **stated})
        self._progress()
        return {c.name: np.asarray(columns[c.name], dtype=np.float64) for c in self._channels}

    def _base(self, at: _Place) -> dict[str, Floats]:
        """Return what the rough model predicts: changes are counted from there."""
        return at.predicted if self._rough is self._model else self._simulate(self._rough, at.theta)

    def _useless(self, at: _Place) -> float:
        """Return how little of the cost is not worth a step more, where the record is not explained."""
        far = any(self._problem.sigma[c.name] > FAR * c.noise for c in self._channels)
        return USELESS * self._problem.cost(at.theta, at.predicted) if far else 0.0

    def _derivatives(
        self, at: _Place, base: dict[str, Floats], places: Collection[int]
    ) -> list[dict[str, Floats]]:
        """Return derivatives at a place, 0 by what is not asked for.

        Args:
            at: the place, as the exact model has it if a parameter that the model rounds is asked for.
            base: predictions of the rough model there.
            places: of the parameters.
        """
        found = []
        for place, unknown in enumerate(self._unknowns):
            model, before = (self._model, at.predicted) if unknown.rounded else (self._rough, base)
            after, difference = before, 1.0
            if place in places:
                after, difference = self._moved(model, at.theta, place)
            found.append({name: (after[name] - column) / difference for name, column in before.items()})
        return found

    def _moved(self, model: Model, theta: Floats, place: int) -> tuple[dict[str, Floats], float]:
        """Return what a moved parameter predicts, and its move: downwards where no machine is above."""
        moved, difference = theta.copy(), self._unknowns[place].difference
        moved[place] += difference
        try:
            return self._simulate(model, moved), difference
        except MachineError:
            moved[place] -= 2.0 * difference
            return self._simulate(model, moved), -difference

    def _step(self, model: Model, at: _Place, jacobian: Jacobian, least: Floats | float) -> _Place:
        """Return where a step leads that lowers the cost, or the same place.

        Args:
            model: that predicts.
            at: from where.
            jacobian: derivatives.
            least: standard deviations of theta that stated numbers and rounding add.
        """
        problem, theta, damping = self._problem, at.theta, at.damping
        information, gradient = problem.normal(theta, at.predicted, jacobian)
        hessian = information + problem.known
        slope = gradient + problem.known @ (theta - problem.mean)
        errors = np.hypot(np.sqrt(np.maximum(np.diag(inverse(hessian)), 1e-300)), least)
        before = problem.cost(theta, at.predicted)
        for _ in range(TRIES):
            move = damped_step(hessian, slope, damping, 1e-30, problem.reach)
            moved = float(np.max((np.abs(move) / errors)[problem.lasting], initial=1e-300))
            try:
                after = self._simulate(model, theta + move)
                fall = before - problem.cost(theta + move, after)
            except (MachineError, ValueError):
                fall = -math.inf
            if fall >= 0.0:
                problem.update_noise(theta + move, after)
                return _Place(theta + move, after, damping / 10.0, moved, fall, errors)
            if moved < CONVERGED:  # chance refuses what is not worth another try
                return at._replace(moved=moved, fall=0.0, errors=errors)
            damping = 10.0 * max(damping, 1e-3)
        return at._replace(damping=damping, moved=0.0, fall=0.0, errors=errors)


def _after(predicted: Columns, change: Columns) -> Columns:
    """Return predictions after a change; without one as they are."""
    return {name: column + change[name] if change else column for name, column in predicted.items()}
