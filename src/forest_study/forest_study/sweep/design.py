"""The cases of a study: each combination of its lists, at each sampled point of its ranges, with each seed.

A Latin hypercube has every range's n-th part once. Sobol's design is Saltelli's: two samples A and B of a
scrambled Sobol sequence, and for every range A with B's column (Saltelli et al. 2010), n (k + 2) points.
Equal files give equal cases.
"""

import itertools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import scipy  # its `stats` takes a second to load: only where it is used

from forest_description.types import Floats
from forest_study.sweep.study import Study

SEED = 0  # of the samples


class Run(NamedTuple):
    """One run of a study."""

    number: int
    combination: int  # of the lists
    point: int  # of the ranges' sample
    seed: int
    varied: dict[str, Any]  # values by key


def combinations(study: Study) -> list[dict[str, Any]]:
    """Return each combination of the lists."""
    return [
        dict(zip(study.lists, values, strict=True)) for values in itertools.product(*study.lists.values())
    ]


def points(study: Study) -> Floats:
    """Return the sampled points [N, number of ranges], SI: of a Sobol design A, B, then each A_B."""
    count = len(study.ranges)
    if count == 0:
        return np.zeros((1, 0))
    if study.design == "latin_hypercube":
        sample = scipy.stats.qmc.LatinHypercube(count, seed=SEED).random(study.points)
    else:
        a, b = np.split(scipy.stats.qmc.Sobol(2 * count, seed=SEED).random(study.points), 2, axis=1)
        mixed = [np.where(np.arange(count) == k, b, a) for k in range(count)]
        sample = np.concatenate([a, b, *mixed])
    low, high = np.array(list(study.ranges.values())).T
    scaled: Floats = low + (high - low) * sample
    return scaled


def runs(study: Study) -> Iterator[Run]:
    """Yield each run, in the order of combination, point and seed."""
    sample = points(study).tolist()
    number = itertools.count()
    for (c, combination), (p, point) in itertools.product(enumerate(combinations(study)), enumerate(sample)):
        varied = {**combination, **dict(zip(study.ranges, point, strict=True))}
        for seed in study.seeds:
            yield Run(next(number), c, p, seed, varied)


def size(study: Study) -> int:
    """Return the number of runs."""
    return len(combinations(study)) * len(points(study)) * len(study.seeds)
