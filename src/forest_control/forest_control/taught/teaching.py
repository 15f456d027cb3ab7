"""Teaching: where the tip was driven becomes a path of few waypoints, which a person can edit.

A moving mean takes out most of the resolvers' noise. Then waypoints are chosen, the worst first: the place
that is furthest from the path through those that there are, until none is further than `TOLERANCE`. The path
that is measured so is the very path that will be gone, corners and all.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from forest_control.taught.cycle import Path
from forest_control.taught.cycle_file import FASTEST, SLOWEST
from forest_control.taught.tip_path import PathError, cross_track_distance, curve
from forest_description.types import Floats, Vec3

MOST = 120_000  # [1] samples of a path: ten minutes at 200 Hz; what is driven later is no part of it
HALF = 10  # [1] samples on either side of a mean: 0.05 s, in which a driven tip hardly turns
SPACING = 0.005  # [m] between the places that are kept: finer than the path need be
TOLERANCE = 0.002  # [m] of what was driven from the path: below what the tip's control reaches
APART = 0.02  # [m] of waypoints, at the least: nearer, they would tell of noise
DENSE = 0.002  # [m] between the places of a path from which distances are measured: straight in between
SHORTEST = 0.05  # [m] of a path that is worth it: less is a tip that stands
MOVING = 0.02  # [m/s] of the tip, from which the time counts for the path's speed


class Teaching:
    """A path that is being driven."""

    def __init__(self) -> None:
        self._tips: list[Vec3] = []
        self._times: list[float] = []

    def add(self, tip: Vec3, time: float) -> None:
        """Take in where the tip is [m] at a rising time [s]."""
        if len(self._tips) < MOST:
            self._tips.append(tip)
            self._times.append(time)

    def path(self, name: str) -> Path:
        """Return the path that was driven, at its mean speed.

        Raises:
            PathError: the tip hardly moved.
        """
        tips = _smoothed(np.array(self._tips).reshape(-1, 3))
        steps, dt = np.linalg.norm(np.diff(tips, axis=0), axis=1), np.diff(self._times)
        samples, moving = _thinned(tips), float(dt[steps > MOVING * dt].sum())
        length = sum(math.dist(a, b) for a, b in pairwise(samples))
        if length < SHORTEST or moving <= 0.0:
            raise PathError(f"{name}: the tip moved by {length:.2f} m; allowed: {SHORTEST:g} m or more")
        speed = max(SLOWEST, min(FASTEST, length / moving))
        return Path(name, reduced(samples), round(speed, 3))


def reduced(samples: Sequence[Vec3]) -> tuple[Vec3, ...]:
    """Return few of some samples [m]: the path through them is within `TOLERANCE` of all.

    It is not where that would take waypoints nearer than `APART`, as in a turn of some centimetres.
    """
    table = np.array(samples)
    ways = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(table, axis=0), axis=1))])
    chosen = [0, len(samples) - 1]
    while True:
        free = np.abs(ways - ways[chosen][:, None]).min(axis=0) > APART
        away = np.where(free, distances([samples[k] for k in chosen], table), 0.0)
        worst = int(np.argmax(away))
        if away[worst] <= TOLERANCE:
            return tuple(samples[k] for k in chosen)
        chosen = sorted([*chosen, worst])


def distances(points: Sequence[Vec3], places: Floats) -> Floats:
    """Return how far places [N, 3] m are from the path through points [m]: [N] m."""
    ways, table, _ = curve("taught", list(points))
    dense = np.linspace(0.0, ways[-1], math.ceil(ways[-1] / DENSE) + 1)
    on_path = np.column_stack([np.interp(dense, ways, table[:, i]) for i in range(3)])
    return cross_track_distance(on_path, places)


def _smoothed(tips: Floats) -> Floats:
    """Return the moving mean of tips [N, 3] m; at the ends it is of one side."""
    sums = np.vstack([np.zeros(3), np.cumsum(tips, axis=0)])
    places = np.arange(len(tips))
    first, end = np.maximum(places - HALF, 0), np.minimum(places + HALF + 1, len(tips))
    mean: Floats = (sums[end] - sums[first]) / (end - first)[:, None]
    return mean


def _thinned(tips: Floats) -> list[Vec3]:
    """Return the first of some tips, those that are `SPACING` further on, and the last."""
    kept: list[Vec3] = []
    for x, y, z in tips.tolist():
        if not kept or math.dist((x, y, z), kept[-1]) >= SPACING:
            kept.append((x, y, z))
    if len(kept) > 1:
        x, y, z = tips[-1].tolist()
        kept[-1] = x, y, z
    return kept
