"""What an output-error fit compares: channels, unknowns, and the weighted residuals between them.

Symbols as in `output_error`. Nuisances (b, g) follow the parameters in theta.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from forest_description.types import Bools, Floats
from forest_ident.output_error.fit_statistics import censor, inflation
from forest_ident.output_error.gaussian_estimate import Belief, prior, spread_of

Columns = Mapping[str, Floats]
Jacobian = Sequence[Mapping[str, Floats]]
"""Derivatives of the predicted columns, one entry per parameter."""


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
    run: str = ""  # of which alone b is; a unit's own b is the same in all of them


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


class Problem:
    """Measured columns and what is sought; the noise of every channel is learned on the way."""

    def __init__(
        self,
        measured: Columns,
        channels: Sequence[Channel],
        unknowns: Sequence[Unknown],
        block: int,
        belief: Belief,
    ) -> None:
        """Lay out theta.

        Args:
            measured: columns by channel.
            channels: which count, and how.
            unknowns: what is estimated.
            block: rows within which residuals may hang together.
            belief: what earlier fits found, of parameters and of the sensors' static errors.
        """
        self._block = block
        self._channels, self._unknowns = channels, unknowns
        self._y = {c.name: np.asarray(measured[c.name], dtype=np.float64) for c in channels}
        self._nuisances = [(c.name, "b", c.offset) for c in channels if c.offset > 0.0]
        self._nuisances += [(c.name, "g", c.gain) for c in channels if c.gain > 0.0]
        start = [math.log(u.start) if u.positive else u.start for u in unknowns]
        spread = np.array([*(u.prior for u in unknowns), *(sd for _, _, sd in self._nuisances)])
        runs = {c.name: f".{c.run}" if c.run else "" for c in channels}
        nuisances = (f"{name}.{kind}{runs[name] if kind == 'b' else ''}" for name, kind, _ in self._nuisances)
        self.names = (*(u.key for u in unknowns), *nuisances)
        begin = np.array([*start, *(0.0 for _ in self._nuisances)])
        self.mean, self.known = prior(belief, self.names, begin, spread)
        self.count = len(unknowns)
        # A logarithm that moves by more than a half leaves what the derivatives were taken for.
        bounds = [0.5 if u.positive else math.inf for u in unknowns]
        self.reach = np.array([*bounds, *(math.inf for _ in self._nuisances)])
        self.sigma = {c.name: c.noise for c in channels}

    def values(self, theta: Floats) -> dict[str, float]:
        """Return the parameters by key."""
        pairs = zip(self._unknowns, theta[: self.count].tolist(), strict=True)
        return {u.key: math.exp(t) if u.positive else t for u, t in pairs}

    def said(self, theta: Floats, name: str, column: Floats) -> Floats:
        """Return (1 + g) yhat + b."""
        return column * (1.0 + self._static(theta, name, "g")) + self._static(theta, name, "b")

    def _static(self, theta: Floats, name: str, kind: str) -> float:
        """Return a channel's b or g, 0 if it has none."""
        places = (i for i, (n, k, _) in enumerate(self._nuisances) if (n, k) == (name, kind))
        return next((float(theta[self.count + i]) for i in places), 0.0)

    def row(self, c: Channel, said: Floats) -> tuple[Floats, Floats, Bools]:
        """Return residual/sigma, its derivative by what is said, and which rows are seen, not censored."""
        y, sigma = self._y[c.name], self.sigma[c.name]
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

    def learn_noise(self, theta: Floats, predicted: Mapping[str, Floats]) -> None:
        """Take as noise what is left, if that is more than the sensors' own."""
        for c in self._channels:
            said = self.said(theta, c.name, predicted[c.name])
            residual, _, seen = self.row(c, said)
            # Next to a bound only one side of the noise is seen.
            bound = 4.0 * c.noise + c.floor
            seen &= (np.abs(said) > bound) if c.floor > 0.0 else (said > bound) | (not c.zero)
            if seen.sum() > len(seen) // 100:
                rms = self.sigma[c.name] * float(np.sqrt(np.mean(residual[seen] ** 2)))
                self.sigma[c.name] = max(c.noise, rms)

    def cost(self, theta: Floats, predicted: Mapping[str, Floats]) -> float:
        """Return the sum of squares that is minimised."""
        rows = (self.row(c, self.said(theta, c.name, predicted[c.name]))[0] for c in self._channels)
        away = theta - self.mean
        return sum(float(r @ r) for r in rows) + float(away @ self.known @ away)

    def normal(
        self, theta: Floats, predicted: Mapping[str, Floats], jacobian: Jacobian
    ) -> tuple[Floats, Floats]:
        """Return J'J and J'r."""
        size = len(theta)
        information, gradient = np.zeros((size, size)), np.zeros(size)
        for _, residual, j in self._rows(theta, predicted, jacobian):
            information += j.T @ j
            gradient += j.T @ residual
        return information, gradient

    def _rows(
        self, theta: Floats, predicted: Mapping[str, Floats], jacobian: Jacobian
    ) -> Iterator[tuple[Channel, Floats, Floats]]:
        """Give each channel's residual/sigma and its derivatives, one column per theta."""
        for c in self._channels:
            column = predicted[c.name]
            residual, slope, _ = self.row(c, self.said(theta, c.name, column))
            j = np.zeros((len(column), len(theta)))
            shown = slope * (1.0 + self._static(theta, c.name, "g"))
            for place, derivative in enumerate(jacobian):
                j[:, place] = shown * derivative[c.name]
            for place, (name, kind, _) in enumerate(self._nuisances):
                if name == c.name:
                    j[:, self.count + place] = slope * (column if kind == "g" else 1.0)
            yield c, residual, j

    def covariance(
        self, theta: Floats, predicted: Columns, jacobian: Jacobian, redrawn: Sequence[Columns] = ()
    ) -> Floats:
        """Return the covariance of theta: of white residuals, widened as far as the blocks' scatter asks for.

        A sandwich of some ten blocks knows the variances, but no correlations of as many parameters: as prior
        of the next fit it would claim to know some of their sums and differences far too well.

        Args:
            theta: at the end of the fit.
            predicted: there.
            jacobian: there.
            redrawn: predicted with the noise of the model's inputs once more: how far that moves theta.
        """
        information, gradient = self.normal(theta, predicted, jacobian)
        spread = spread_of(information + self.known)
        count = max(len(y) for y in self._y.values()) // self._block + 1
        found, white = np.zeros((count, len(theta))), np.zeros((count, len(theta)))
        for _, residual, j in self._rows(theta, predicted, jacobian):
            influence, firsts = j @ spread, np.arange(0, len(residual), self._block)
            found[: len(firsts)] += np.add.reduceat(influence * residual[:, np.newaxis], firsts)
            white[: len(firsts)] += np.add.reduceat(influence**2, firsts)
        beforehand = np.diag(spread @ self.known @ spread)
        wanted = beforehand + inflation(found, white) * np.sum(white, axis=0)
        scale = np.sqrt(np.maximum(wanted / np.maximum(np.diag(spread), 1e-300), 1.0))
        moves = [spread @ (self.normal(theta, after, jacobian)[1] - gradient) for after in redrawn]
        fed = np.mean([np.outer(move, move) for move in moves], axis=0) if moves else 0.0
        return np.asarray(spread * np.outer(scale, scale) + fed, dtype=np.float64)
