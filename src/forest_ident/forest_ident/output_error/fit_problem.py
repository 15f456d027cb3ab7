"""Weighted residuals of an output-error fit, from channels, unknowns and measured columns.

Symbols as in `output_error`. Nuisances (b, g) follow the parameters in theta.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import scipy

from forest_description.types import Bools, Floats
from forest_ident.output_error.gaussian_estimate import (
    GaussianEstimate,
    covariance_of,
    inflation,
    prior_information,
)

Columns = Mapping[str, Floats]
Jacobian = Mapping[str, Floats]
"""Derivatives of the predicted columns by every parameter (parameters, rows)."""


LONGER = (1, 4)  # times a block: residuals may be correlated over more than one
FEWEST = 16  # blocks that show a scatter


FAR = 5.0  # times a sensor's noise: greater residuals are errors of the model


class Unknown(NamedTuple):
    """A parameter: dotted key (or name of an offset), start, prior, whether it is positive (logarithm)."""

    key: str
    start: float
    prior: float = math.inf  # standard deviation; of a positive one relative
    positive: bool = True
    difference: float = 1e-2
    """For derivatives; of a positive one relative. The curvature is 3 % of a derivative. A plant that sticks
    answers any difference with the chance of which step its friction lets go in: with 1e-3 that may be more
    than what is looked for."""
    own: bool = False  # of one record alone: it passes nothing of it on
    rounded: float = 0.0  # standard deviation by which the model rounds it
    begun: bool = False  # its start may be far off: the search begins with such alone
    like: tuple[str, str] | None = None  # another with its effect, but for -1 in a channel; that channel


class Channel(NamedTuple):
    """Errors of a column's sensor: noise, static errors, and where its readings are censored."""

    name: str
    noise: float
    offset: float = 0.0  # standard deviation of the static error b
    gain: float = 0.0  # standard deviation of g
    floor: float = 0.0  # smaller magnitudes read as this
    zero: bool = False  # negative values read as 0
    high: float = math.inf
    run: str = ""  # the only one with this b; without it, b is the same in all runs


class Fit(NamedTuple):
    """Result of a fit."""

    values: dict[str, float]
    errors: dict[str, float]  # standard errors, in the parameters' units
    condition: float
    posterior: GaussianEstimate  # of all parameters, this fit included
    residuals: dict[str, Floats]  # standardised, censored rows left out as NaN
    noise: dict[str, float]
    iterations: int
    stated_noise: dict[str, float]  # what wrong stated numbers may leave in each channel, in its unit
    converged: bool = True  # False: the search was broken off
    asked: Floats = np.zeros(0)
    """How far what is left of the record would move each stated number, in its standard deviations."""


class StatedEffect(NamedTuple):
    """What stated numbers do to a fit; each of them moved by its standard deviation."""

    slopes: Floats  # moves of theta (theta, stated)
    noise: dict[str, float]  # what they may leave in each channel, in its unit
    asked: Floats  # how far the record would move each, in standard deviations


class Problem:
    """Measured columns and unknowns; the noise of every channel is estimated along."""

    def __init__(
        self,
        measured: Columns,
        channels: Sequence[Channel],
        unknowns: Sequence[Unknown],
        block: int,
        prior: GaussianEstimate,
    ) -> None:
        """Lay out theta.

        Args:
            measured: columns by channel.
            channels: which count, and how.
            unknowns: what is estimated.
            block: rows within which residuals may be correlated.
            prior: what earlier fits found, of parameters and of the sensors' static errors.
        """
        self._block = block
        self._channels, self._unknowns = channels, unknowns
        self._y = {c.name: np.asarray(measured[c.name], dtype=np.float64) for c in channels}
        offsets = [c for c in channels if c.offset > 0.0]
        gains = [c for c in channels if c.gain > 0.0]
        self._nuisances = [*((c.name, "b") for c in offsets), *((c.name, "g") for c in gains)]
        everything = [
            *unknowns,
            *(
                Unknown(f"{c.name}.b{f'.{c.run}' if c.run else ''}", 0.0, c.offset, False, own=bool(c.run))
                for c in offsets
            ),
            *(Unknown(f"{c.name}.g", 0.0, c.gain, False) for c in gains),
        ]
        start = np.array([math.log(u.start) if u.positive else u.start for u in everything])
        spread = np.array([u.prior for u in everything])
        self.names, self.count = tuple(u.key for u in everything), len(unknowns)
        self.lasting = np.array([not u.own for u in everything])  # what is passed on
        self.mean, self.known = prior_information(prior, self.names, start, spread)
        self.rounded = np.array([u.rounded for u in everything])
        # Derivatives do not hold for a logarithm that moves by more than a half.
        self.reach = np.array([0.5 if u.positive else math.inf for u in everything])
        self.sigma = {c.name: c.noise for c in channels}

    def values(self, theta: Floats) -> dict[str, float]:
        """Return the parameters by key."""
        pairs = zip(self._unknowns, theta[: self.count].tolist(), strict=True)
        return {u.key: math.exp(t) if u.positive else t for u, t in pairs}

    def reading(self, theta: Floats, name: str, column: Floats) -> Floats:
        """Return (1 + g) yhat + b."""
        return column * (1.0 + self._static(theta, name, "g")) + self._static(theta, name, "b")

    def _static(self, theta: Floats, name: str, kind: str) -> float:
        """Return a channel's b or g, 0 if it has none."""
        places = (i for i, nuisance in enumerate(self._nuisances) if nuisance == (name, kind))
        return next((float(theta[self.count + i]) for i in places), 0.0)

    def row(self, c: Channel, reading: Floats) -> tuple[Floats, Floats, Bools]:
        """Return residual/sigma, its derivative by the predicted reading, and the rows not censored."""
        y, sigma = self._y[c.name], self.sigma[c.name]
        residual, slope = (y - reading) / sigma, np.full(len(y), -1.0 / sigma)
        seen = np.isfinite(y) & (np.abs(y) < c.high) & np.isfinite(reading)
        residual, slope = np.where(seen, residual, 0.0), np.where(seen, slope, 0.0)
        if c.floor > 0.0:
            low = np.abs(y) <= c.floor * (1.0 + 1e-9)
            _censor(residual, slope, low, np.abs(reading), c.floor, sigma, np.sign(reading))
            seen &= ~low
        if c.zero:
            low = y <= 0.0
            _censor(residual, slope, low, reading, 0.0, sigma, np.ones(len(y)))
            seen &= ~low
        return residual, slope, seen

    def update_noise(self, theta: Floats, predicted: Mapping[str, Floats]) -> None:
        """Set each channel's noise to the RMS of its residuals, if that is more than the sensor's own."""
        for c in self._channels:
            reading = self.reading(theta, c.name, predicted[c.name])
            residual, _, seen = self.row(c, reading)
            # Next to a bound only one side of the noise is seen.
            bound = 4.0 * c.noise + c.floor
            seen &= (np.abs(reading) > bound) if c.floor > 0.0 else (reading > bound) | (not c.zero)
            if seen.sum() > len(seen) // 100:
                rms = self.sigma[c.name] * float(np.sqrt(np.mean(residual[seen] ** 2)))
                self.sigma[c.name] = max(c.noise, rms)

    def cost(self, theta: Floats, predicted: Mapping[str, Floats]) -> float:
        """Return the sum of squares that is minimised."""
        rows = (self.row(c, self.reading(theta, c.name, predicted[c.name]))[0] for c in self._channels)
        away = theta - self.mean
        return sum(float(r @ r) for r in rows) + float(away @ self.known @ away)

    def normal(
        self, theta: Floats, predicted: Mapping[str, Floats], jacobian: Jacobian
    ) -> tuple[Floats, Floats]:
        """Return J'J and J'r."""
        information = np.zeros((len(theta), len(theta)))
        for _, _, j in self.rows(theta, predicted, jacobian):
            information += j.T @ j
        return information, self.gradient(theta, predicted, jacobian)

    def gradient(self, theta: Floats, predicted: Columns, jacobian: Jacobian) -> Floats:
        """Return J'r, which takes a fiftieth of the time of J'J."""
        found = np.zeros(len(theta))
        for c in self._channels:
            column = predicted[c.name]
            residual, slope, _ = self.row(c, self.reading(theta, c.name, column))
            pull = slope * residual
            found[: self.count] += (1.0 + self._static(theta, c.name, "g")) * (jacobian[c.name] @ pull)
            for place, (name, kind) in enumerate(self._nuisances):
                if name == c.name:
                    found[self.count + place] += float(pull @ column if kind == "g" else np.sum(pull))
        return found

    def residuals(self, theta: Floats, predicted: Columns) -> dict[str, Floats]:
        """Return residual/sigma of every channel; censored rows are NaN."""
        found = {}
        for c in self._channels:
            residual, _, seen = self.row(c, self.reading(theta, c.name, predicted[c.name]))
            found[c.name] = np.where(seen, residual, np.nan)
        return found

    def rows(
        self, theta: Floats, predicted: Mapping[str, Floats], jacobian: Jacobian
    ) -> Iterator[tuple[Channel, Floats, Floats]]:
        """Yield each channel's residual/sigma and its derivatives, one column per theta."""
        for c in self._channels:
            column = predicted[c.name]
            residual, slope, _ = self.row(c, self.reading(theta, c.name, column))
            j = np.zeros((len(theta), len(column)))  # a column of a sensor lies in one piece
            np.multiply(
                jacobian[c.name], slope * (1.0 + self._static(theta, c.name, "g")), out=j[: self.count]
            )
            for place, (name, kind) in enumerate(self._nuisances):
                if name == c.name:
                    j[self.count + place] = slope * (column if kind == "g" else 1.0)
            yield c, residual, j.T

    def covariance(
        self,
        theta: Floats,
        predicted: Columns,
        jacobian: Jacobian,
        normal: tuple[Floats, Floats],
        redrawn: Sequence[Columns] = (),
    ) -> Floats:
        """Return the covariance of theta: of white residuals, widened where they are not.

        The record's share counts times the scatter of its blocks (`inflation`), the mean of all parameters:
        H^-1 (F J'J + prior's information) H^-1. All are widened alike: widened one by one, flows and leakages
        that can only grow together would seem told apart by the next record.

        Args:
            theta: at the end of the fit.
            predicted: there.
            jacobian: there.
            normal: J'J and J'r there.
            redrawn: predicted with the noise of the model's inputs drawn once more.
        """
        information, gradient = normal
        spread = covariance_of(information + self.known)
        count = max(len(y) for y in self._y.values()) // self._block + 1
        found, white = np.zeros((count, len(theta))), np.zeros((count, len(theta)))
        for _, residual, j in self.rows(theta, predicted, jacobian):
            influence, firsts = spread @ j.T, np.arange(0, len(residual), self._block)
            found[: len(firsts)] += np.add.reduceat(influence * residual, firsts, axis=1).T
            white[: len(firsts)] += np.add.reduceat(influence**2, firsts, axis=1).T
        starts = [np.arange(0, count, longer) for longer in LONGER if longer == 1 or FEWEST * longer <= count]
        factors = [inflation(np.add.reduceat(found, at), np.add.reduceat(white, at)) for at in starts]
        factor = (
            max((float(np.mean(one[: self.count])) for one in factors), default=1.0) if self.count else 1.0
        )
        widened = spread + (factor - 1.0) * spread @ information @ spread
        moves = [spread @ (self.gradient(theta, after, jacobian) - gradient) for after in redrawn]
        of_inputs = np.mean([np.outer(move, move) for move in moves], axis=0) if moves else 0.0
        return np.asarray(widened + of_inputs, dtype=np.float64)

    def stated_effect(
        self, theta: Floats, predicted: Columns, jacobian: Jacobian, moved: Sequence[Columns], before: Floats
    ) -> StatedEffect:
        """Return what stated numbers do to a fit.

        A stated number t is not estimated. Where the cost is least, its gradient stays zero while t moves: so
        theta moves by T = H^-1 (K T_0 - J'J_t), and the residuals by F = J_t + J T. Let go all together,
        stated numbers would move by -(1 + F'F + D'K D)^-1 (F'r + D'K (theta - m)), with D = T - T_0.

        Args:
            theta: at the end of the fit.
            predicted: there.
            jacobian: there.
            moved: predicted with each stated number one standard deviation off.
            before: T_0, moves of the prior's mean m (theta, stated); K is the prior's information.
        """
        if not moved:
            return StatedEffect(before, dict.fromkeys(predicted, 0.0), np.zeros(0))
        rows = list(self.rows(theta, predicted, jacobian))
        changes = [self._changes(theta, moved, channel, residual) for channel, residual, _ in rows]
        information = sum((j.T @ j for _, _, j in rows), np.zeros((len(theta), len(theta))))
        pulls = sum((j.T @ c for (_, _, j), c in zip(rows, changes, strict=True)), np.zeros(before.shape))
        slopes = covariance_of(information + self.known) @ (self.known @ before - pulls)
        away = slopes - before
        curvature = np.eye(len(moved)) + away.T @ self.known @ away
        pull, noise = away.T @ self.known @ (theta - self.mean), {}
        for (channel, residual, j), change in zip(rows, changes, strict=True):
            left = change + j @ slopes
            curvature, pull = curvature + left.T @ left, pull + left.T @ residual
            squares = np.sum(left**2, axis=1)[residual != 0.0]
            rms = math.sqrt(float(np.mean(squares)) if len(squares) else 0.0)
            noise[channel.name] = self.sigma[channel.name] * rms
        return StatedEffect(slopes, noise, np.asarray(-np.linalg.solve(curvature, pull)))

    def _changes(self, theta: Floats, moved: Sequence[Columns], c: Channel, residual: Floats) -> Floats:
        """Return how a channel's residuals change by each stated number (rows, stated)."""
        after = [self.row(c, self.reading(theta, c.name, m[c.name]))[0] for m in moved]
        return np.array(after).reshape(len(moved), len(residual)).T - residual[:, np.newaxis]


def _censor(
    residual: Floats,
    slope: Floats,
    rows: Bools,
    reading: Floats,
    bound: float,
    sigma: float,
    sign: Floats,
) -> None:
    """Set the censored rows to sqrt(-2 ln P(reading is below the bound)) and its derivative."""
    z = (bound - reading[rows]) / sigma
    logarithm = scipy.special.log_ndtr(z)
    size = np.sqrt(np.maximum(-2.0 * logarithm, 1e-300))
    density = np.exp(-0.5 * z * z - 0.5 * math.log(2.0 * math.pi) - logarithm)
    residual[rows] = size
    slope[rows] = np.where(size > 1e-12, density / (sigma * np.maximum(size, 1e-12)), 0.0) * sign[rows]
