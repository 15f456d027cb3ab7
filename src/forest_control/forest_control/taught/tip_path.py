"""A way of the tip: straight from corner to corner, smooth in between; and how fast it may be gone.

| symbol | name | unit |
|---|---|---|
| s | way along the path | m |
| v | speed along it | m/s |
| a | its acceleration on ramps | m/s^2 |

A profile is the fastest that speed, ramps, bends and the velocity limits allow: v(s) is bounded at every
place, and v^2 may change by at most 2 a per metre. A path of waypoints stops at both ends, at corners, and at
a waypoint that is said twice; in between it is the cubic spline through its waypoints.
"""

import bisect
import math
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from forest_description.types import Floats, Vec3

STEP = 1e-3  # [m] between the places of a profile: below what resolvers tell
SHORTEST = 1e-6  # [m] between two waypoints; nearer ones are one, where the tip stops
LONGEST = 200.0  # [m] of a path: a longer one has another unit
CORNER = math.radians(25.0)  # [rad] a sharper turn is a corner; chosen, not measured
BEND = 1.5  # [m/s^2] across the way in a bend, at the most; chosen, not measured
NEIGHBOURS = 4  # [1] points of a line that are looked at: two ways may meet in a sharp corner
BASE = 0.02  # [m] over which a bend is measured: more than the noise of waypoints


class PathError(ValueError):
    """A path is not usable; the message says why."""


class TipPath(NamedTuple):
    """A way of the tip in the base frame."""

    name: str
    length: float  # [m]
    at: Callable[[float], Vec3]  # place [m] at a way s
    stops: tuple[float, ...]  # [m] ways at which the tip stops, both ends included


class Profile(NamedTuple):
    """Motion along a path: ways and speeds at rising times."""

    time: Floats  # [N] s
    way: Floats  # [N] m
    speed: Floats  # [N] m/s

    @property
    def duration(self) -> float:
        """From first to last motion [s]."""
        return float(self.time[-1])

    def way_at(self, time: float) -> float:
        """Return s [m] at a time [s]."""
        return float(self.ways_at(np.array([time]))[0])

    def ways_at(self, times: Floats) -> Floats:
        """Return s [N] m at times [N] s; the acceleration is constant between two rows."""
        k = np.clip(np.searchsorted(self.time, times, side="right") - 1, 0, len(self.time) - 2)
        span, since = self.time[k + 1] - self.time[k], times - self.time[k]
        slope = (self.speed[k + 1] - self.speed[k]) / span
        ways: Floats = self.way[k] + (self.speed[k] + 0.5 * slope * since) * since
        ways[times <= 0.0], ways[times >= self.time[-1]] = 0.0, self.way[-1]
        return ways


def polyline(name: str, points: list[Vec3]) -> TipPath:
    """Return the way from point to point [m]: straight from corner to corner, smooth in between.

    Raises:
        PathError: there is no way, or it is too long.
    """
    ways, table, stops = curve(name, points)
    return TipPath(name, float(ways[-1]), _along(ways.tolist(), table.tolist()), stops)


def _along(ways: list[float], places: list[Vec3]) -> Callable[[float], Vec3]:
    """Return the place [m] at a way, straight between rows; a plan asks for ten thousands, one by one."""

    def at(s: float) -> Vec3:
        k = max(bisect.bisect_right(ways, s) - 1, 0)
        here = places[k]
        if s <= ways[k] or k == len(ways) - 1:
            return here[0], here[1], here[2]
        there, since, span = places[k + 1], s - ways[k], ways[k + 1] - ways[k]
        return (
            (there[0] - here[0]) / span * since + here[0],
            (there[1] - here[1]) / span * since + here[1],
            (there[2] - here[2]) / span * since + here[2],
        )

    return at


def curve(name: str, points: list[Vec3]) -> tuple[Floats, Floats, tuple[float, ...]]:
    """Return ways [N] m, the places [N, 3] m there, straight in between, and the ways of the stops [m].

    Raises:
        PathError: there is no way, or it is too long.
    """
    stretches = _stretches(points)
    if not stretches:
        raise PathError(f"{name}: a path needs two or more points that are not all the same")
    if sum(math.dist(a, b) for stretch in stretches for a, b in pairwise(stretch)) > LONGEST:
        raise PathError(f"{name}: the path is longer than {LONGEST:g} m")
    table, ends = np.array(stretches[0][:1]), [0]
    for stretch in stretches:
        table = np.vstack([table, _smooth(stretch)[1:]])
        ends.append(len(table) - 1)
    ways = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(table, axis=0), axis=1))])
    return ways, table, tuple(ways[ends].tolist())


def _stretches(points: list[Vec3]) -> list[list[Vec3]]:
    """Return the points [m] from stop to stop: both ends, corners, and points that are said twice."""
    stretches: list[list[Vec3]] = []
    stops = True
    for here, there in pairwise(points):
        if math.dist(here, there) < SHORTEST:
            stops = True
            continue
        if stops or _turn(stretches[-1][-2], here, there) > CORNER:
            stretches.append([here])
        stretches[-1].append(there)
        stops = False
    return stretches


def _turn(a: Vec3, b: Vec3, c: Vec3) -> float:
    """Return the angle [rad] by which the way from a over b to c turns at b."""
    before, after = np.subtract(b, a), np.subtract(c, b)
    size = float(np.linalg.norm(before) * np.linalg.norm(after))
    return math.acos(max(-1.0, min(1.0, float(before @ after) / size))) if size > 0.0 else 0.0


def load_splines() -> None:
    """Load the parts of scipy that paths need: in a callback that holds up whoever is waited for."""
    _ = scipy.interpolate, scipy.spatial


def _smooth(stretch: list[Vec3]) -> Floats:
    """Return points [N, 3] m, close together, on the cubic spline through the points of a stretch."""
    table = np.array(stretch)
    if len(table) == 2:
        return table
    ways = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(table, axis=0), axis=1))])
    within = [np.linspace(a, b, math.ceil((b - a) / STEP) + 1)[1:] for a, b in pairwise(ways.tolist())]
    smooth: Floats = scipy.interpolate.CubicSpline(ways, table)(np.concatenate([[0.0], *within]))
    return smooth


def reverse(path: TipPath) -> TipPath:
    """Return a path from its end to its start."""
    stops = tuple(path.length - s for s in reversed(path.stops))
    return TipPath(path.name, path.length, lambda s: path.at(path.length - s), stops)


def is_closed(path: TipPath) -> bool:
    """Tell whether a path ends where it starts."""
    return math.dist(path.at(0.0), path.at(path.length)) < SHORTEST


class Line(NamedTuple):
    """A line, straight from point to point, as distances are taken from it."""

    tree: "scipy.spatial.cKDTree"  # of its points; named in quotes, for its import takes long
    corners: Floats  # [3, M] m
    pieces: Floats  # [3, M - 1] m, from each point to the next
    sizes: Floats  # [M - 1] m^2 of the pieces


def line_through(points: Floats) -> Line:
    """Return the line through points [M, 3] m, which must be close together: see `distances_from`."""
    fresh = np.linalg.norm(np.diff(points, axis=0), axis=1) > 0.0
    points = points[np.concatenate([[True], fresh])]
    tree = scipy.spatial.cKDTree(points, balanced_tree=False)  # evenly spaced points need no medians
    corners = np.ascontiguousarray(points.T)
    pieces = np.diff(corners, axis=1) if len(points) > 1 else np.zeros((3, 1))
    return Line(tree, corners, pieces, np.maximum(np.sum(pieces**2, axis=0), np.finfo(float).tiny))


def distances_from(line: Line, places: Floats) -> Floats:
    """Return how far places [N, 3] m are from a line: [N] m; only pieces at its nearest points count."""
    found = line.tree.query(places, k=range(1, min(NEIGHBOURS, line.tree.n) + 1))[1]
    nearest = np.ascontiguousarray(found.T)
    tips, last = np.ascontiguousarray(places.T), line.pieces.shape[1] - 1
    square: Floats = np.full(len(places), np.inf)
    for start in np.clip(np.concatenate([nearest - 1, nearest]), 0, last):
        piece, since = line.pieces.take(start, axis=1), tips - line.corners.take(start, axis=1)
        share = np.einsum("ij,ij->j", since, piece) / line.sizes.take(start)
        since -= np.clip(share, 0.0, 1.0) * piece
        square = np.minimum(square, np.einsum("ij,ij->j", since, since))
    away: Floats = np.sqrt(square)
    return away


def cross_track_distance(points: Floats, places: Floats) -> Floats:
    """Return how far places [N, 3] m are from the line through points [M, 3] m: [N] m."""
    return distances_from(line_through(points), places)


def fastest(
    path: TipPath, speed: float, acceleration: float, limit: Callable[[Vec3, Vec3], float]
) -> Profile:
    """Return the fastest profile that stands at the path's stops.

    Args:
        path: the path.
        speed: wished speed [m/s].
        acceleration: of the ramps [m/s^2].
        limit: greatest speed [m/s] at a place [m] in a direction (a unit vector).
    """
    return timed(*bounded(path, speed, limit, STEP), acceleration)


def bounded(
    path: TipPath, speed: float, limit: Callable[[Vec3, Vec3], float], step: float
) -> tuple[Floats, Floats]:
    """Return ways [N] m, at most a step [m] apart, and v^2 [N] m^2/s^2 that is allowed there; 0 at stops."""
    ways = np.unique(np.concatenate([np.linspace(a, b, max(3, math.ceil((b - a) / step) + 1))
                                     for a, b in pairwise(path.stops)]))  # fmt: skip
    square = np.array(
        [min(speed, _bend(path, s), limit(path.at(s), _direction(path, s))) ** 2 for s in ways.tolist()]
    )
    square[np.isin(ways, path.stops)] = 0.0
    return ways, square


def timed(ways: Floats, square: Floats, acceleration: float) -> Profile:
    """Return the fastest profile from stop to stop below v^2 at ways [m], with ramps [m/s^2] at both ends."""
    square = square.copy()
    gain = 2.0 * acceleration * np.diff(ways)
    for k in range(1, len(ways)):
        square[k] = min(square[k], square[k - 1] + gain[k - 1])
    v = np.sqrt(braked(ways, square, acceleration))
    time = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(ways) / (v[1:] + v[:-1]))])
    return Profile(time, ways, v)


def braked(ways: Floats, square: Floats, acceleration: float) -> Floats:
    """Return v^2 from which a ramp [m/s^2] still obeys what is allowed further on."""
    square = square.copy()
    gain = 2.0 * acceleration * np.diff(ways)
    for k in range(len(ways) - 2, -1, -1):
        square[k] = min(square[k], square[k + 1] + gain[k])
    return square


def _direction(path: TipPath, s: float) -> Vec3:
    """Return the unit vector along the path."""
    a, b = path.at(max(0.0, s - 0.5 * STEP)), path.at(min(path.length, s + 0.5 * STEP))
    size = math.dist(a, b) or 1.0
    return (b[0] - a[0]) / size, (b[1] - a[1]) / size, (b[2] - a[2]) / size


def _bend(path: TipPath, s: float) -> float:
    """Return the speed [m/s] that the bend of the path allows at s."""
    k = bisect.bisect_right(path.stops, s)
    if k == 0 or k == len(path.stops):
        return math.inf
    base = min(BASE, s - path.stops[k - 1], path.stops[k] - s)
    turn = _turn(path.at(s - base), path.at(s), path.at(s + base))
    return math.sqrt(BEND * base / turn) if turn > 1e-3 else math.inf
