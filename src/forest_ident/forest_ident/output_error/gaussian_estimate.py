"""Mean and covariance of all parameters together: a Gaussian that every experiment narrows.

Parameters are correlated: a flow meter's gain and the valve's C_R are found as one product. So a fit takes
the mean and covariance of its parameters as prior. Its result moves the correlated others, too.

| symbol | name |
|---|---|
| m, S | mean and covariance; positive parameters by their logarithm |
| a, r | indices of what a fit is about, and of the rest |
| K | S_ra S_aa^-1 |

    m_r <- m_r + K (m_a' - m_a),  S_rr <- S_rr + K (S_aa' - S_aa) K',  S_ra <- K S_aa'
"""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from forest_description.types import Floats


class GaussianEstimate(NamedTuple):
    """Names with their mean and covariance."""

    names: tuple[str, ...] = ()
    mean: Floats = np.zeros(0)
    covariance: Floats = np.zeros((0, 0))
    slopes: Floats | None = None
    """Moves of the mean by one standard deviation of each stated number (names, stated); None: none."""

    def moves(self, names: tuple[str, ...], count: int) -> Floats:
        """Return the slopes of some names, 0 of those that are not known (names, stated)."""
        found = np.zeros((len(names), count))
        for place, name in enumerate(names):
            if self.slopes is not None and name in self.names:
                found[place] = self.slopes[self.names.index(name)]
        return found

    def of(self, name: str) -> tuple[float, float]:
        """Return mean and standard deviation of a name.

        Raises:
            ValueError: there is no such name.
        """
        place = self.names.index(name)
        return float(self.mean[place]), float(np.sqrt(max(self.covariance[place, place], 0.0)))

    def spread(self, name: str) -> float:
        """Return the standard deviation of a name, with what stated numbers add to it."""
        place = self.names.index(name)
        moves = np.zeros(1) if self.slopes is None else self.slopes[place]
        return math.sqrt(max(float(self.covariance[place, place] + moves @ moves), 0.0))

    def owed(self, name: str, to: Collection[str]) -> float:
        """Return the share of a name's variance, stated numbers counted, that goes if others were exact."""
        there = [place for place, other in enumerate(self.names) if other in to]
        shared = self.covariance[self.names.index(name), there]
        return (
            float(shared @ inverse(self.covariance[np.ix_(there, there)]) @ shared) / self.spread(name) ** 2
        )

    def value(self, name: str, positive: bool) -> float:
        """Return the mean of a name as a number; a positive one is kept by its logarithm."""
        mean, _ = self.of(name)
        return math.exp(min(mean, 500.0)) if positive else mean

    def without(self, *names: str) -> "GaussianEstimate":
        """Return the estimate of the others."""
        places = [place for place, other in enumerate(self.names) if other not in names]
        left = tuple(self.names[place] for place in places)
        slopes = None if self.slopes is None else self.slopes[places]
        return GaussianEstimate(left, self.mean[places], self.covariance[np.ix_(places, places)], slopes)

    def taken(self, later: "GaussianEstimate", names: Sequence[str]) -> "GaussianEstimate":
        """Return this estimate with some names, and all that are new, as a later one has them.

        The others stay: they are told better than by what moved them there. The new ones keep what they have
        of their errors: a motor's displacement has those of the flow meter that told it, and the next record
        must not take the two for two witnesses. With k' the others as the later one has them, k as they stay,
        and n the new ones, cov(n, k) = cov(n, k'): k' is the best that both records make of k, so what k lies
        off besides is independent of it.
        """
        kept = self.without(*names)
        new, count = later.without(*kept.names), len(kept.names)
        every = (*kept.names, *new.names)
        places = [later.names.index(name) for name in every]
        covariance = later.covariance[np.ix_(places, places)]
        covariance[:count, :count] = not_below(covariance[:count, :count], kept.covariance)
        slopes = None
        if later.slopes is not None:
            columns = later.slopes.shape[1]
            slopes = np.vstack([kept.moves(kept.names, columns), new.moves(new.names, columns)])
        return GaussianEstimate(every, np.concatenate([kept.mean, new.mean]), covariance, slopes)


EMPTY = GaussianEstimate()
CERTAIN = 2.0  # standard errors of the scatter's excess at which half of it counts
UNSEEN = 1e-13  # of the greatest information: less is rounding


def widened(known: GaussianEstimate, by: Mapping[str, float]) -> GaussianEstimate:
    """Return an estimate after independent errors were added to some names; by: standard deviations."""
    more = np.diag([by.get(name, 0.0) ** 2 for name in known.names])
    return known._replace(covariance=known.covariance + more.reshape(known.covariance.shape))


def prior_information(
    known: GaussianEstimate, names: tuple[str, ...], start: Floats, spread: Floats
) -> tuple[Floats, Floats]:
    """Return mean and information (inverse covariance) of some names before a fit.

    Args:
        known: estimate until then.
        names: of the fit.
        start: mean of those that have no estimate.
        spread: their standard deviation; inf: no information.
    """
    mean, information = start.astype(np.float64).copy(), np.zeros((len(names), len(names)))
    here = [place for place, name in enumerate(names) if name in known.names]
    there = [known.names.index(names[place]) for place in here]
    if here:
        mean[here] = known.mean[there]
        information[np.ix_(here, here)] = inverse(known.covariance[np.ix_(there, there)])
    for place, name in enumerate(names):
        if name not in known.names and np.isfinite(spread[place]):
            information[place, place] = spread[place] ** -2.0
    return mean, information


def updated(
    known: GaussianEstimate,
    names: tuple[str, ...],
    mean: Floats,
    covariance: Floats,
    slopes: Floats | None = None,
) -> GaussianEstimate:
    """Return the estimate after a fit whose prior was `prior_information`.

    Args:
        known: estimate until then.
        names: of the fit.
        mean: that it found.
        covariance: of it.
        slopes: of it, by stated number (names, stated).
    """
    count = 0 if slopes is None else slopes.shape[1]
    new = tuple(name for name in names if name not in known.names)
    size, old = len(known.names) + len(new), len(known.names)
    m, s = np.zeros(size), np.zeros((size, size))
    m[:old], s[:old, :old] = known.mean, known.covariance
    every = (*known.names, *new)
    shared = [every.index(name) for name in names if name in known.names]
    found = [every.index(name) for name in names]
    rest = [place for place in range(old) if place not in shared]
    stated = known.moves(every, count)
    if shared and rest:
        pairs = [names.index(every[place]) for place in shared]
        before = s[np.ix_(shared, shared)]
        gain = s[np.ix_(rest, shared)] @ inverse(before)
        m[rest] += gain @ (mean[pairs] - m[shared])
        if slopes is not None:
            stated[rest] += gain @ (slopes[pairs] - stated[shared])
        s[np.ix_(rest, rest)] += gain @ (covariance[np.ix_(pairs, pairs)] - before) @ gain.T
        cross = gain @ covariance[np.ix_(pairs, range(len(names)))]
        s[np.ix_(rest, found)] = cross
        s[np.ix_(found, rest)] = cross.T
    m[found] = mean
    s[np.ix_(found, found)] = covariance
    if slopes is not None:
        stated[found] = slopes
    return GaussianEstimate(every, m, 0.5 * (s + s.T), None if slopes is None else stated)


def covariance_of(information: Floats) -> Floats:
    """Return the covariance of an information matrix; a huge one in directions without information.

    A pseudo-inverse would give such a direction a variance of zero.
    """
    scale = np.sqrt(np.maximum(np.diag(information), UNSEEN))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    values = np.maximum(values, UNSEEN * np.max(values))
    return np.asarray((vectors / values) @ vectors.T / np.outer(scale, scale))


def not_below(least: Floats, covariance: Floats) -> Floats:
    """Return a covariance, but where another is greater, as that has it; rows have very different units."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh((covariance - least) / np.outer(scale, scale))
    return np.asarray(least + (vectors * np.maximum(values, 0.0)) @ vectors.T * np.outer(scale, scale))


def inverse(matrix: Floats) -> Floats:
    """Return the inverse of a covariance whose rows have very different units."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix / np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(scaled, rcond=1e-13, hermitian=True) / np.outer(scale, scale))


def condition_number(information: Floats) -> float:
    """Return the condition number of J with its columns brought to length 1: sqrt of that of D J'J D."""
    scale = np.sqrt(np.diag(information))
    if len(scale) == 0 or np.any(scale <= 0.0):
        return math.inf
    values = np.linalg.eigvalsh(information / np.outer(scale, scale))
    return math.sqrt(float(values[-1] / values[0])) if values[0] > 0.0 else math.inf


def inflation(scores: Floats, white: Floats) -> Floats:
    """Return the factor (1 or more) on each parameter's variance, since residuals are not white.

    For white residuals F = sum of scores^2 / sum of white is 1 +- sqrt(2/n), with n blocks of rows that
    contribute. Its excess d = F - 1 counts as d^3/(d^2 + 4 * 2/n): hardly where it may be chance, fully far
    from that. Where one or two blocks hold nearly all information of a parameter, the fit has made their
    scores small, and their scatter shows nothing.

    Args:
        scores: of the blocks, each its gradient by every parameter (blocks, parameters).
        white: variance that each block would add if residuals were white (blocks, parameters).
    """
    total, squares = np.sum(white, axis=0), np.sum(white**2, axis=0)
    blocks = np.maximum(total**2 / np.maximum(squares, 1e-300), 1.0)
    excess = np.maximum(np.sum(scores**2, axis=0) / np.maximum(total, 1e-300) - 1.0, 0.0)
    chance = CERTAIN**2 * 2.0 / blocks
    return np.asarray(1.0 + excess**3 / (excess**2 + chance), dtype=np.float64)
