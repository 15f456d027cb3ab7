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
damping; derivatives by forward differences, each a simulation. The covariance is the sandwich over blocks of
`BLOCK` rows, which stays right when residuals are not white; of a parameter that only a few blocks tell, as a
spool's bandwidth its few great steps, it is the usual one (`fit_statistics.trust`).

Thesis section 4.1.2. Differs: the thesis estimates each parameter by a linear least-squares fit of its own;
those are where this starts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_description.machine import MachineError
from forest_ident.belief import NOTHING, Belief, inverse, prior, updated
from forest_ident.fit_statistics import censor, condition_number, trust

Floats = NDArray[np.float64]
Columns = Mapping[str, Floats]

BLOCK = 200  # rows of one block of the sandwich
ITERATIONS = 7
CONVERGED = 0.1  # of the standard errors, that the last step moved


class Unknown(NamedTuple):
    """A parameter: dotted key (or name of an offset), start, prior, whether it is positive (logarithm)."""

    key: str
    start: float
    prior: float = math.inf  # standard deviation; of a positive one relative
    positive: bool = True
    difference: float = 1e-4  # for derivatives; of a positive one relative


class Channel(NamedTuple):
    """How a column is judged: noise, bounds of static errors, where readings are censored."""

    name: str
    noise: float
    offset: float = 0.0  # standard deviation of the static error b
    gain: float = 0.0  # standard deviation of g
    floor: float = 0.0  # smaller magnitudes read as this
    zero: bool = False  # negative values read as 0
    high: float = math.inf


class Fit(NamedTuple):
    """Where the fit ended."""

    values: dict[str, float]
    errors: dict[str, float]  # standard errors, in the parameters' units
    condition: float
    belief: Belief  # of everything, this fit included
    residuals: dict[str, Floats]  # standardised, censored rows left out as NaN
    predicted: dict[str, Floats]
    noise: dict[str, float]
    iterations: int


Model = Callable[[Mapping[str, float]], Columns]


def fit(
    model: Model,
    measured: Columns,
    channels: Sequence[Channel],
    unknowns: Sequence[Unknown],
    progress: Callable[[], None] = lambda: None,
    block: int = BLOCK,
    belief: Belief = NOTHING,
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
    """
    return _Problem(model, measured, channels, unknowns, progress, block, belief).solved()


class _Problem:
    """One fit under way; nuisances (b, g) follow the parameters in theta."""

    def __init__(
        self,
        model: Model,
        measured: Columns,
        channels: Sequence[Channel],
        unknowns: Sequence[Unknown],
        progress: Callable[[], None],
        block: int,
        belief: Belief,
    ) -> None:
        self._block, self._belief = block, belief
        self._model, self._channels, self._unknowns, self._progress = model, channels, unknowns, progress
        self._y = {c.name: np.asarray(measured[c.name], dtype=np.float64) for c in channels}
        self._nuisances = [(c.name, "b", c.offset) for c in channels if c.offset > 0.0]
        self._nuisances += [(c.name, "g", c.gain) for c in channels if c.gain > 0.0]
        start = [math.log(u.start) if u.positive else u.start for u in unknowns]
        spread = np.array([*(u.prior for u in unknowns), *(sd for _, _, sd in self._nuisances)])
        self._names = (*(u.key for u in unknowns), *(f"{name}.{kind}" for name, kind, _ in self._nuisances))
        begin = np.array([*start, *(0.0 for _ in self._nuisances)])
        self._mean, self._known = prior(belief, self._names, begin, spread)
        self._count = len(unknowns)
        # A logarithm that moves by more than a half leaves what the derivatives were taken for.
        bounds = [0.5 if u.positive else math.inf for u in unknowns]
        self._reach = np.array([*bounds, *(math.inf for _ in self._nuisances)])
        self._sigma = {c.name: c.noise for c in channels}

    def solved(self) -> Fit:
        theta = self._mean.copy()
        predicted = self._simulate(theta)
        damping, iterations = 1e-3, 0
        self._learn_noise(theta, predicted)
        while iterations < ITERATIONS:
            iterations += 1
            jacobian = self._derivatives(theta, predicted)
            theta, predicted, damping, moved = self._step(theta, predicted, jacobian, damping)
            self._learn_noise(theta, predicted)
            if moved < CONVERGED:
                break
        return self._finished(theta, predicted, iterations)

    def _values(self, theta: Floats) -> dict[str, float]:
        pairs = zip(self._unknowns, theta[: self._count].tolist(), strict=True)
        return {u.key: math.exp(t) if u.positive else t for u, t in pairs}

    def _simulate(self, theta: Floats) -> dict[str, Floats]:
        of = self._model(self._values(theta))
        self._progress()
        return {c.name: np.asarray(of[c.name], dtype=np.float64) for c in self._channels}

    def _derivatives(self, theta: Floats, predicted: Mapping[str, Floats]) -> list[dict[str, Floats]]:
        found = []
        for place, unknown in enumerate(self._unknowns):
            moved = theta.copy()
            moved[place] += unknown.difference
            after = self._simulate(moved)
            found.append(
                {name: (after[name] - column) / unknown.difference for name, column in predicted.items()}
            )
        return found

    def _said(self, theta: Floats, name: str, column: Floats) -> Floats:
        """Return (1 + g) yhat + b."""
        nuisance = {(n, kind): theta[self._count + i] for i, (n, kind, _) in enumerate(self._nuisances)}
        gain, offset = float(nuisance.get((name, "g"), 0.0)), float(nuisance.get((name, "b"), 0.0))
        return column * (1.0 + gain) + offset

    def _row(self, c: Channel, said: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Return residual/sigma, its derivative by what is said, and which rows are seen, not censored."""
        y, sigma = self._y[c.name], self._sigma[c.name]
        residual, slope = (y - said) / sigma, np.full(len(y), -1.0 / sigma)
        seen = np.isfinite(y) & (np.abs(y) < c.high) & np.isfinite(said)
        residual, slope = np.where(seen, residual, 0.0), np.where(seen, slope, 0.0)
        if c.floor > 0.0:
            low = np.abs(y) <= c.floor * (1.0 + 1e-9)
            censor(residual, slope, low, np.abs(said), c.floor, sigma, np.sign(said))
            seen &= ~low
        if c.zero:
            low = y <= 0.0
            censor(residual, slope, low, said, 0.0, sigma, np.ones(len(y)))
            seen &= ~low
        return residual, slope, seen

    def _learn_noise(self, theta: Floats, predicted: Mapping[str, Floats]) -> None:
        """Take as noise what is left, if that is more than the sensors' own."""
        for c in self._channels:
            said = self._said(theta, c.name, predicted[c.name])
            residual, _, seen = self._row(c, said)
            # Next to a bound only one side of the noise is seen.
            bound = 4.0 * c.noise + c.floor
            seen &= (np.abs(said) > bound) if c.floor > 0.0 else (said > bound) | (not c.zero)
            if seen.sum() > len(seen) // 100:
                rms = self._sigma[c.name] * float(np.sqrt(np.mean(residual[seen] ** 2)))
                self._sigma[c.name] = max(c.noise, rms)

    def _cost(self, theta: Floats, predicted: Mapping[str, Floats]) -> float:
        rows = (self._row(c, self._said(theta, c.name, predicted[c.name]))[0] for c in self._channels)
        away = theta - self._mean
        return sum(float(r @ r) for r in rows) + float(away @ self._known @ away)

    def _normal(
        self, theta: Floats, predicted: Mapping[str, Floats], jacobian: list[dict[str, Floats]]
    ) -> tuple[Floats, Floats]:
        """Return J'J and J'r."""
        size = len(theta)
        information, gradient = np.zeros((size, size)), np.zeros(size)
        for _, residual, j in self._rows(theta, predicted, jacobian):
            information += j.T @ j
            gradient += j.T @ residual
        return information, gradient

    def _rows(
        self, theta: Floats, predicted: Mapping[str, Floats], jacobian: list[dict[str, Floats]]
    ) -> Iterator[tuple[Channel, Floats, Floats]]:
        """Give each channel's residual/sigma and its derivatives, one column per theta."""
        for c in self._channels:
            column = predicted[c.name]
            residual, slope, _ = self._row(c, self._said(theta, c.name, column))
            j = np.zeros((len(column), len(theta)))
            for place, derivative in enumerate(jacobian):
                j[:, place] = slope * derivative[c.name]
            for place, (name, kind, _) in enumerate(self._nuisances):
                if name == c.name:
                    j[:, self._count + place] = slope * (column if kind == "g" else 1.0)
            yield c, residual, j

    def _covariance(
        self, theta: Floats, predicted: Mapping[str, Floats], jacobian: list[dict[str, Floats]]
    ) -> Floats:
        """Return the covariance of theta: the sandwich, as far as many blocks have a say in a parameter."""
        information, _ = self._normal(theta, predicted, jacobian)
        spread = inverse(information + self._known)
        count = max(len(y) for y in self._y.values()) // self._block + 1
        found, white = np.zeros((count, len(theta))), np.zeros((count, len(theta)))
        for _, residual, j in self._rows(theta, predicted, jacobian):
            influence, block = j @ spread, np.arange(len(residual)) // self._block
            np.add.at(found, block, influence * residual[:, np.newaxis])
            np.add.at(white, block, influence**2)
        beforehand = spread @ self._known @ spread
        covariance = found.T @ found + beforehand
        share = trust(white)
        variance = share * np.sum(found**2, axis=0) + (1.0 - share) * np.sum(white, axis=0)
        wanted = variance + np.diag(beforehand)
        scale = np.sqrt(wanted / np.maximum(np.diag(covariance), 1e-300))
        return np.asarray(covariance * np.outer(scale, scale), dtype=np.float64)

    def _step(
        self,
        theta: Floats,
        predicted: dict[str, Floats],
        jacobian: list[dict[str, Floats]],
        damping: float,
    ) -> tuple[Floats, dict[str, Floats], float, float]:
        """Return theta after a step that lowers the cost, what it predicts, damping, how far it moved."""
        information, gradient = self._normal(theta, predicted, jacobian)
        hessian, slope = information + self._known, gradient + self._known @ (theta - self._mean)
        before = self._cost(theta, predicted)
        for _ in range(8):
            damped = hessian + damping * np.diag(np.diag(hessian) + 1e-30)
            move = -np.linalg.solve(damped, slope)
            move = np.clip(move, -self._reach, self._reach)
            try:
                after = self._simulate(theta + move)
            except (MachineError, ValueError):
                damping = 10.0 * max(damping, 1e-3)
                continue
            if self._cost(theta + move, after) <= before:
                errors = np.sqrt(np.maximum(np.diag(inverse(hessian)), 1e-300))
                return theta + move, after, damping / 10.0, float(np.max(np.abs(move) / errors))
            damping = 10.0 * max(damping, 1e-3)
        return theta, predicted, damping, 0.0

    def _finished(self, theta: Floats, predicted: dict[str, Floats], iterations: int) -> Fit:
        jacobian = self._derivatives(theta, predicted)
        information, _ = self._normal(theta, predicted, jacobian)
        covariance = self._covariance(theta, predicted, jacobian)
        values, errors = self._values(theta), {}
        for place, u in enumerate(self._unknowns):
            error = math.sqrt(max(covariance[place, place], 0.0))
            errors[u.key] = error * values[u.key] if u.positive else error
        residuals = {}
        for c in self._channels:
            residual, _, seen = self._row(c, self._said(theta, c.name, predicted[c.name]))
            residuals[c.name] = np.where(seen, residual, np.nan)
        said = {name: self._said(theta, name, column) for name, column in predicted.items()}
        return Fit(
            values,
            errors,
            condition_number(information[: self._count, : self._count]),
            updated(self._belief, self._names, theta, covariance),
            residuals,
            said,
            dict(self._sigma),
            iterations,
        )
