"""Paths of the tip, and how fast it may go along them.

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
import csv
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from forest_description.types import Floats, Vec3

STEP = 1e-3  # [m] of the profile
NAMES = ("sweep", "radial", "vertical", "circle_h", "circle_v")
CENTRE: Vec3 = (5.9, 0.0, 0.8)  # [m] of both circles, radius 1 m
SHORTEST = 1e-6  # [m] between two waypoints; nearer ones are one, where the tip stops
LONGEST = 200.0  # [m]
CORNER = math.radians(25.0)  # a sharper turn is a corner
BEND, BASE = 1.5, 0.02  # [m/s^2] across the way in a bend, at the most; [m] over which a bend is measured


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
        """Return s [m]; the acceleration is constant between two rows."""
        if time <= 0.0 or time >= self.time[-1]:
            return 0.0 if time <= 0.0 else float(self.way[-1])
        k = int(np.searchsorted(self.time, time, side="right")) - 1
        span, since = self.time[k + 1] - self.time[k], time - self.time[k]
        slope = (self.speed[k + 1] - self.speed[k]) / span
        return float(self.way[k] + (self.speed[k] + 0.5 * slope * since) * since)


def path_named(name: str) -> TipPath:
    """Return one of the five paths, or that of a CSV file of waypoints with the columns x, y, z [m].

    Raises:
        PathError: the file cannot be read, or holds no path.
    """
    if name == "sweep":
        return polyline(name, [(5.6, -2.5, 1.0), (5.6, 2.5, 1.0)])
    if name == "radial":
        return polyline(name, [(4.7, 0.0, 0.5), (7.2, 0.0, 0.5)])
    if name == "vertical":
        return polyline(name, [(6.0, 0.0, -0.5), (6.0, 0.0, 2.0)])
    if name in ("circle_h", "circle_v"):
        return _circle(name)
    return polyline(Path(name).stem, _waypoints(Path(name)))


def polyline(name: str, points: list[Vec3]) -> TipPath:
    """Return the way from point to point [m]: straight from corner to corner, smooth in between."""
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

    def at(s: float) -> Vec3:
        x, y, z = (float(np.interp(s, ways, table[:, i])) for i in range(3))
        return x, y, z

    return TipPath(name, float(ways[-1]), at, tuple(ways[ends].tolist()))


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


def _smooth(stretch: list[Vec3]) -> Floats:
    """Return points [N, 3] m, close together, on the cubic spline through the points of a stretch."""
    table = np.array(stretch)
    if len(table) == 2:
        return table
    ways = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(table, axis=0), axis=1))])
    within = [np.linspace(a, b, math.ceil((b - a) / STEP) + 1)[1:] for a, b in pairwise(ways.tolist())]
    smooth: Floats = CubicSpline(ways, table)(np.concatenate([[0.0], *within]))
    return smooth


def reverse(path: TipPath) -> TipPath:
    """Return a path from its end to its start."""
    stops = tuple(path.length - s for s in reversed(path.stops))
    return TipPath(path.name, path.length, lambda s: path.at(path.length - s), stops)


def is_closed(path: TipPath) -> bool:
    """Tell whether a path ends where it starts."""
    return math.dist(path.at(0.0), path.at(path.length)) < SHORTEST


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
    ways = np.unique(np.concatenate([np.linspace(a, b, max(3, math.ceil((b - a) / STEP) + 1))
                                     for a, b in pairwise(path.stops)]))  # fmt: skip
    square = np.array(
        [min(speed, _bend(path, s), limit(path.at(s), _direction(path, s))) ** 2 for s in ways.tolist()]
    )
    square[np.isin(ways, path.stops)] = 0.0
    gain = 2.0 * acceleration * np.diff(ways)
    for k in range(1, len(ways)):
        square[k] = min(square[k], square[k - 1] + gain[k - 1])
    for k in range(len(ways) - 2, -1, -1):
        square[k] = min(square[k], square[k + 1] + gain[k])
    v = np.sqrt(square)
    time = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(ways) / (v[1:] + v[:-1]))])
    return Profile(time, ways, v)


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


def _circle(name: str) -> TipPath:
    x, y, z = CENTRE
    if name == "circle_h":
        return TipPath(
            name, 2.0 * math.pi, lambda s: (x - math.cos(s), y + math.sin(s), z), (0.0, 2.0 * math.pi)
        )
    return TipPath(name, 2.0 * math.pi, lambda s: (x - math.cos(s), y, z + math.sin(s)), (0.0, 2.0 * math.pi))


def _waypoints(file: Path) -> list[Vec3]:
    try:
        with file.open(newline="", encoding="utf-8-sig") as text:
            rows = [row for row in csv.reader(text) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        known = ", ".join(NAMES)
        raise PathError(f"{file}: no path of this name ({known}), nor a readable file: {error}") from error
    if not rows or tuple(cell.strip() for cell in rows[0]) != ("x", "y", "z"):
        raise PathError(f"{file}: the header must be x,y,z")
    points = []
    for line, row in enumerate(rows[1:], start=2):
        try:
            x, y, z = map(float, row)
        except ValueError as error:
            raise PathError(f"{file}:{line}: not three numbers x, y, z [m]") from error
        if not all(map(math.isfinite, (x, y, z))):
            raise PathError(f"{file}:{line}: not three finite numbers x, y, z [m]")
        points.append((x, y, z))
    return points
