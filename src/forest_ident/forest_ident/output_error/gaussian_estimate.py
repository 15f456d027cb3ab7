"""What is known of all parameters together: a Gaussian that every experiment narrows.

Parameters hang together: a flow meter's gain and the valve's C_R are found as one product. So a fit takes
what is known of its parameters with their covariance, and what it finds moves the others, too, by as much as
they hang together with it.

| symbol | name |
|---|---|
| m, S | mean and covariance; positive parameters by their logarithm |
| a, r | indices of what a fit is about, and of the rest |
| K | S_ra S_aa^-1 |

    m_r <- m_r + K (m_a' - m_a),  S_rr <- S_rr + K (S_aa' - S_aa) K',  S_ra <- K S_aa'
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from forest_description.types import Floats


class Belief(NamedTuple):
    """Names with their mean and covariance."""

    names: tuple[str, ...] = ()
    mean: Floats = np.zeros(0)
    covariance: Floats = np.zeros((0, 0))

    def of(self, name: str) -> tuple[float, float]:
        """Return mean and standard deviation of a name.

        Raises:
            KeyError: nothing is known of it.
        """
        if name not in self.names:
            raise KeyError(name)
        place = self.names.index(name)
        return float(self.mean[place]), float(np.sqrt(max(self.covariance[place, place], 0.0)))


NOTHING = Belief()
UNSEEN = 1e-13  # of the greatest information: less is the arithmetic's


def widened(belief: Belief, by: Mapping[str, float]) -> Belief:
    """Return what is left of a belief when chance moved some of its names; by: standard deviations."""
    more = np.diag([by.get(name, 0.0) ** 2 for name in belief.names])
    return belief._replace(covariance=belief.covariance + more.reshape(belief.covariance.shape))


def prior(belief: Belief, names: tuple[str, ...], start: Floats, spread: Floats) -> tuple[Floats, Floats]:
    """Return mean and information (inverse covariance) of some names before a fit.

    Args:
        belief: until now.
        names: of the fit.
        start: mean of what is not known yet.
        spread: its standard deviation; inf: nothing is known.
    """
    mean, information = start.astype(np.float64).copy(), np.zeros((len(names), len(names)))
    here = [place for place, name in enumerate(names) if name in belief.names]
    there = [belief.names.index(names[place]) for place in here]
    if here:
        mean[here] = belief.mean[there]
        information[np.ix_(here, here)] = inverse(belief.covariance[np.ix_(there, there)])
    for place, name in enumerate(names):
        if name not in belief.names and np.isfinite(spread[place]):
            information[place, place] = spread[place] ** -2.0
    return mean, information


def updated(belief: Belief, names: tuple[str, ...], mean: Floats, covariance: Floats) -> Belief:
    """Return what is known after a fit that had `prior` as its prior.

    Args:
        belief: until now.
        names: of the fit.
        mean: that it found.
        covariance: of it.
    """
    new = tuple(name for name in names if name not in belief.names)
    size, old = len(belief.names) + len(new), len(belief.names)
    m, s = np.zeros(size), np.zeros((size, size))
    m[:old], s[:old, :old] = belief.mean, belief.covariance
    every = (*belief.names, *new)
    known = [every.index(name) for name in names if name in belief.names]
    found = [every.index(name) for name in names]
    rest = [place for place in range(old) if place not in known]
    if known and rest:
        pairs = [names.index(every[place]) for place in known]
        before = s[np.ix_(known, known)]
        gain = s[np.ix_(rest, known)] @ inverse(before)
        m[rest] += gain @ (mean[pairs] - m[known])
        s[np.ix_(rest, rest)] += gain @ (covariance[np.ix_(pairs, pairs)] - before) @ gain.T
        cross = gain @ covariance[np.ix_(pairs, range(len(names)))]
        s[np.ix_(rest, found)] = cross
        s[np.ix_(found, rest)] = cross.T
    m[found] = mean
    s[np.ix_(found, found)] = covariance
    return Belief(every, m, 0.5 * (s + s.T))


def spread_of(information: Floats) -> Floats:
    """Return the covariance that belongs to an information matrix; where that is empty, a huge one.

    A pseudo-inverse says of a direction that the data do not see at all that its variance is zero.
    """
    scale = np.sqrt(np.maximum(np.diag(information), UNSEEN))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    values = np.maximum(values, UNSEEN * np.max(values))
    return np.asarray((vectors / values) @ vectors.T / np.outer(scale, scale))


def inverse(matrix: Floats) -> Floats:
    """Return the inverse of a covariance whose rows have very different units."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix / np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(scaled, rcond=1e-13, hermitian=True) / np.outer(scale, scale))
