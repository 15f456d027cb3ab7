"""Walls around the workspace: ground, cab, boxes. The tip slides along them.

Of a tip velocity only what is too fast towards a wall is taken away. The tip slides along a wall,
brakes smoothly before it arrives, and can always leave, also from within.

| symbol | name | unit |
|---|---|---|
| p, x' | position and velocity of the tip, base frame | m, m/s |
| d | distance to a wall, negative within | m |
| n | unit vector away from it | |
| k | approach rate: allowed speed towards a wall per distance | 1/s |

Taken away is max(0, -x'.n - max(0, k d)) n. Between several walls this is repeated. What then
remains too fast, in a corner, stops the tip.
"""

import math
from typing import NamedTuple

from forest_description.geometry.vectors import dot
from forest_description.types import Vec3

NOTHING = 0  # [1] kind of a `Wall` that fills a free place: it is far from everything
PLANE = 1  # [1] kind of a `Wall`: ground, side of `stay_inside`
BOX = 2  # [1] kind of a `Wall`: upright, parallel to the base frame
CYLINDER = 3  # [1] kind of a `Wall`: upright
MOST = 12  # [1] walls: machine code needs a fixed number; twice the sides of `stay_inside`
PASSES = 20  # [1] over all walls before the tip is stopped, as in a corner; chosen, not measured
NEGLIGIBLE_SPEED = 1e-6  # [m/s] of the tip towards a limit that counts as none: rounding


class Wall(NamedTuple):
    """What the tip keeps out of.

    A plane: p.n >= c, n in `first`, c in `radius`. A box between the corners `first` and `second`.
    An upright cylinder about `first` (x, y) of `radius`, from the z of `first` to that of `second`.
    """

    kind: int
    first: Vec3  # [m]
    second: Vec3  # [m]
    radius: float  # [m]


class Workspace(NamedTuple):
    """All walls."""

    walls: tuple[Wall, ...]  # `MOST`
    approach: float  # k [1/s]
    number: int  # of them that are something


NO_WALL = Wall(NOTHING, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)
OPEN = Workspace((NO_WALL,) * MOST, 1.0, 0)


class Clearance(NamedTuple):
    """Where a wall is, seen from the tip."""

    distance: float  # d [m]
    away: Vec3  # n


def clearance(p: Vec3, wall: Wall) -> Clearance:
    """Return distance and direction of a wall from a point [m]."""
    if wall.kind == PLANE:
        n = wall.first
        return Clearance(dot(p, n) - wall.radius, n)
    if wall.kind == BOX:
        return _box(p, wall.first, wall.second)
    if wall.kind == CYLINDER:
        return _cylinder(p, wall)
    return Clearance(math.inf, (0.0, 0.0, 1.0))


def _box(p: Vec3, low: Vec3, high: Vec3) -> Clearance:
    x, y, z = _beyond(p[0], low[0], high[0]), _beyond(p[1], low[1], high[1]), _beyond(p[2], low[2], high[2])
    outside = math.sqrt(x * x + y * y + z * z)
    if outside > 0.0:
        return Clearance(outside, (x / outside, y / outside, z / outside))
    nearest, away = -math.inf, (0.0, 0.0, 1.0)
    for i in range(3):
        for k in range(2):
            side = 2.0 * k - 1.0
            depth = low[i] - p[i] if side < 0.0 else p[i] - high[i]
            if depth > nearest:
                nearest = depth
                away = side * (i == 0), side * (i == 1), side * (i == 2)
    return Clearance(nearest, away)


def _cylinder(p: Vec3, wall: Wall) -> Clearance:
    x, y = p[0] - wall.first[0], p[1] - wall.first[1]
    across = math.sqrt(x * x + y * y)
    e_x, e_y = (x / across, y / across) if across > 0.0 else (1.0, 0.0)
    radial, axial = across - wall.radius, _beyond(p[2], wall.first[2], wall.second[2])
    if radial > 0.0:
        outside = math.sqrt(radial * radial + axial * axial)
        return Clearance(outside, (radial / outside * e_x, radial / outside * e_y, axial / outside))
    if axial != 0.0:
        return Clearance(abs(axial), (0.0, 0.0, math.copysign(1.0, axial)))
    below, above = wall.first[2] - p[2], p[2] - wall.second[2]
    if radial >= max(below, above):
        return Clearance(radial, (e_x, e_y, 0.0))
    return Clearance(max(below, above), (0.0, 0.0, 1.0 if above >= below else -1.0))


def slide(p: Vec3, velocity: Vec3, w: Workspace) -> Vec3:
    """Return what the walls leave of a tip velocity [m/s] at a tip position [m]."""
    v = velocity
    for _ in range(PASSES):
        worst = 0.0
        for i in range(w.number):
            near = clearance(p, w.walls[i])
            excess = _excess(near, v, w.approach)
            if excess > 0.0:
                worst = max(worst, excess)
                v = (
                    v[0] + excess * near.away[0],
                    v[1] + excess * near.away[1],
                    v[2] + excess * near.away[2],
                )
        if worst <= NEGLIGIBLE_SPEED:
            return v
    return 0.0, 0.0, 0.0


def wall_scaling(p: Vec3, velocity: Vec3, w: Workspace) -> float:
    """Return the factor 0..1 by which a tip velocity [m/s] must shrink as a whole: for levers of joints."""
    factor = 1.0
    for i in range(w.number):
        near = clearance(p, w.walls[i])
        inward = -dot(velocity, near.away)
        if inward > NEGLIGIBLE_SPEED:
            factor = min(factor, max(0.0, w.approach * near.distance) / inward)
    return factor


def _excess(near: Clearance, v: Vec3, approach: float) -> float:
    return -dot(v, near.away) - max(0.0, approach * near.distance)


def _beyond(x: float, low: float, high: float) -> float:
    """Return how far x lies outside an interval, with its side's sign."""
    return x - low if x < low else max(0.0, x - high)
