"""How far a tip was from where it should be: four measures, of which none is told alone.

| measure | distance of the true tip | what it cannot see |
|---|---|---|
| governed | to the reference behind every limit | a reference off the path; lateness; static errors |
| cross-track | to the nearest place of the path as drawn | lateness; a path that is not gone to its end |
| wish | to the ideal point at its time, before every limit | nothing: a delay counts with its way |

The time lost is how much later than the ideal point the tip has all of the path but `NEAR` behind it. The
governed reference starts where the tip is at the first motion: its error begins with 0.
Cross-track and wish subtract nothing: a tip that is a centimetre off when it sets out is a centimetre off.

A person draws no path beforehand. For a hand the wish is the integral of the tip velocity that its levers ask
for at each moment, before every ramp, delay and limit, from where the tip is at first; the path as drawn is
the line that the wish leaves. Its time lost is what the limits took: a second at a factor f costs 1 - f.
"""

import math
from typing import NamedTuple

import numpy as np

from forest_control.taught.tip_path import Profile, TipPath
from forest_description.types import Floats

STEP = 1e-3  # [m] between the points of a path as a line: an arc of 0.1 m is 1 um beside it
NEAR = 0.01  # [m] of way to a path's end, from which the tip counts as there: profiles end in no speed
SLIP = 0.05  # [m] by which the place beside the tip may move in a period, at the most
COARSE = 25  # [1] periods between the rows that are looked at far from a path's end


class Deviation(NamedTuple):
    """How far a tip was off."""

    rms_mm: float
    max_mm: float


def deviation(away: Floats) -> Deviation:
    """Return RMS and greatest of distances [N] m."""
    return Deviation(1e3 * float(np.sqrt(np.mean(away**2))), 1e3 * float(away.max()))


def squares(vectors: Floats) -> Floats:
    """Return the square of each vector's size [N], of rows [N, 3]; numpy's norm takes four times as long."""
    x, y, z = vectors.T
    found: Floats = x * x + y * y + z * z
    return found


def line_of(path: TipPath) -> Floats:
    """Return a path as points [M, 3] m, `STEP` apart at the most; its corners are among them."""
    spaced = np.linspace(0.0, path.length, math.ceil(path.length / STEP) + 1)
    return np.array([path.at(s) for s in np.union1d(spaced, path.stops).tolist()])


def ideal(path: TipPath, profile: Profile, times: Floats) -> Floats:
    """Return where a profile is on its path at times [N] s: [N, 3] m."""
    return np.array([path.at(s) for s in profile.ways_at(times).tolist()])


def time_lost(path: TipPath, profile: Profile, times: Floats, tips: Floats) -> float:
    """Return how much later than its profile a tip has a path behind it, for good [s].

    A tip that is early has lost less than nothing. If it does not get there, the time that it has lost by the
    last row counts: it would lose more.

    Args:
        path: as drawn.
        profile: of the ideal point.
        times: rising, since the profile's start [N] s.
        tips: places of the tip then [N, 3] m.
    """
    begin, end = path.stops[-2], path.stops[-1]
    there = end - min(NEAR, 0.5 * (end - begin))
    last = times >= np.interp(begin, profile.way, profile.time)  # rows of the path's last stretch
    times, tips = times[last], tips[last]
    rough = _ways_beside(path, (begin, end), begin, tips[::COARSE], COARSE * SLIP)
    early = np.flatnonzero(rough < there)
    first, way = (COARSE * int(early[-1]), float(rough[early[-1]])) if len(early) else (0, begin)
    times, ways = times[first:], _ways_beside(path, (begin, end), way, tips[first:], SLIP)
    short = np.flatnonzero(ways < there)
    if len(short) == 0:
        return float(times[0] - np.interp(there, profile.way, profile.time))
    k = int(short[-1])
    if k == len(ways) - 1:
        return float(times[k] - np.interp(ways[k], profile.way, profile.time))
    share = (there - ways[k]) / (ways[k + 1] - ways[k])
    passed = times[k] + share * (times[k + 1] - times[k])
    return float(passed - np.interp(there, profile.way, profile.time))


def _ways_beside(
    path: TipPath, stretch: tuple[float, float], way: float, tips: Floats, slip: float
) -> Floats:
    """Return the ways [N] m at which a stretch of a path is beside tips [N, 3] m that go along it.

    It is followed from a way [m] on, by at most a slip [m] a row, so that a circle's end is not taken for its
    start. One of Newton's steps a row is enough, as for the player of taught work.
    """
    (begin, end), at, half, found = stretch, path.at, 0.5 * STEP, []
    for x, y, z in tips.tolist():
        a, b = max(begin, way - half), min(end, way + half)
        (x_a, y_a, z_a), (x_b, y_b, z_b) = at(a), at(b)
        ahead = (x - x_a) * (x_b - x_a) + (y - y_a) * (y_b - y_a) + (z - z_a) * (z_b - z_a)
        way = max(begin, min(end, way + max(-slip, min(slip, a - way + ahead / (b - a)))))
        found.append(way)
    return np.array(found)
