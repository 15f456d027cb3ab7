"""A program's joint trajectory becomes a leg of the tip: its path is kept, and the time gives.

A trajectory tells angles of swing, boom and stick at times, as for ros2_control's
`joint_trajectory_controller`. Between two points the joints go on straight lines; on Hermite's cubic, where
both points tell rates. Below its straight stick the crane has one pose for each place of the tip: so the
tip's path is the joints' path. The tip goes along it as fast as the trajectory asks for, and slower where the
crane can not. A pose that is held for a time is a stop of the path; how long is not kept.

| symbol | name | unit |
|---|---|---|
| t, q, v | time of a point, its joint angles, their rates | s, rad, rad/s |
| h, u | time between two points; share of it that has passed | s, 1 |
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from forest_control.config.controller_settings import Parameters
from forest_control.servo.link_bending import link_angles
from forest_control.taught.plan import RAMP, THERE, Leg, leg
from forest_control.taught.tip_path import PathError, braked
from forest_description.geometry.kinematics import inverse_kinematics, tip_position
from forest_description.types import AXES, Floats, Vec3

NAME = "joint trajectory"
FASTEST = 3.0  # [m/s] of the tip: as of the levers; what the crane can is planned anyway
MOST = 10_000  # [1] points of a trajectory; more are another unit of time
LONGEST = 3600.0  # [s] of a trajectory; a longer one has other units
GREATEST_WAY = 1000.0  # [m] of the tip, if the joints' turns added up; a path has 200 m at most
SPACING = 0.01  # [m] between the places that are kept, about: the spline through them is the path


class TrajectoryPoint(NamedTuple):
    """Where the joints shall be at a time."""

    time: float  # t [s] from the trajectory's start
    angles: Vec3  # q, swing, boom, stick
    rates: Vec3 | None = None  # v; None: not told


class TrajectoryRow(NamedTuple):
    """A point as a message has it: values in the order of the message's joint names."""

    time: float
    positions: Sequence[float]
    velocities: Sequence[float]


def trajectory_points(names: Sequence[str], rows: Sequence[TrajectoryRow]) -> tuple[TrajectoryPoint, ...]:
    """Return the points of a message.

    Raises:
        PathError: it is no trajectory of this crane; the sentence says what is allowed.
    """
    if sorted(names) != sorted(AXES):
        raise PathError(f"{NAME}: joints {', '.join(names) or 'none'}; allowed: {', '.join(AXES)}")
    if not 1 <= len(rows) <= MOST:
        raise PathError(f"{NAME}: {len(rows)} points; allowed: 1 to {MOST}")
    place = [list(names).index(axis) for axis in AXES]
    points = tuple(_point(k, row, place) for k, row in enumerate(rows))
    for k, (before, after) in enumerate(pairwise(points), start=1):
        if after.time <= before.time:
            raise PathError(f"{NAME}: point {k} at {after.time:g} s; allowed: after {before.time:g} s")
    return points


def _point(k: int, row: TrajectoryRow, place: Sequence[int]) -> TrajectoryPoint:
    if not 0.0 <= row.time <= LONGEST:
        raise PathError(f"{NAME}: point {k} at {row.time:g} s; allowed: 0 to {LONGEST:g}")
    angles = _ordered(f"point {k}: positions", row.positions, place)
    return TrajectoryPoint(
        row.time,
        angles,
        _ordered(f"point {k}: velocities", row.velocities, place) if row.velocities else None,
    )


def _ordered(what: str, values: Sequence[float], place: Sequence[int]) -> Vec3:
    """Return three values as swing, boom, stick."""
    if len(values) != len(AXES) or not all(map(math.isfinite, values)):
        raise PathError(f"{NAME}: {what} {list(values)}; allowed: {len(AXES)} finite numbers")
    one, two, three = (float(values[i]) for i in place)
    return one, two, three


def trajectory_leg(points: Sequence[TrajectoryPoint], here: Vec3, p: Parameters) -> Leg:
    """Return the leg that a trajectory asks for from where the tip is [m].

    A first point at time 0 must be where the tip is. A later one is reached from there. The angles are of
    the joints, as in `/joint_states`: links that bend hang below them, without a load.

    Raises:
        PathError: the tip is elsewhere, hardly moves, or cannot go there; the sentence says where.
    """
    points = [
        point._replace(angles=link_angles(point.angles, math.nan, p.speed_limits, p.coordinated.arm))
        for point in points
    ]
    if points[0].time > 0.0:
        points = [TrajectoryPoint(0.0, inverse_kinematics(here, p.links)), *points]
    away = math.dist(tip_position(points[0].angles, p.links), here)
    if away > THERE:
        raise PathError(
            f"{NAME}: begins {away:.2f} m from the tip; allowed: {THERE:g} m, or a later first point"
        )
    times, places = _sampled(points, p)
    planned = leg(1, NAME, [(x, y, z) for x, y, z in places.tolist()], FASTEST, p)
    ways = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    # The path's length is that of its spline, longer than the chords' by a hair.
    asked = np.interp(planned.ways, ways * (planned.path.length / ways[-1]), np.gradient(ways, times))
    return planned._replace(square=braked(planned.ways, np.minimum(planned.square, asked**2), RAMP))


def _sampled(points: Sequence[TrajectoryPoint], p: Parameters) -> tuple[Floats, Floats]:
    """Return rising times [N] s, and the tip's places [N, 3] m then, some `SPACING` apart.

    Raises:
        PathError: these would be too many.
    """
    reach = p.links.base_offset + p.links.boom + p.links.stick
    ways = [reach * _turn(before, after) for before, after in pairwise(points)]
    if not sum(ways) <= GREATEST_WAY:
        raise PathError(
            f"{NAME}: some {sum(ways):g} m of the tip; allowed: {GREATEST_WAY:g} m, angles in rad"
        )
    times, places = [points[0].time], [tip_position(points[0].angles, p.links)]
    for (before, after), way in zip(pairwise(points), ways, strict=True):
        count = max(1, math.ceil(way / SPACING))
        for k in range(1, count + 1):
            times.append(before.time + (after.time - before.time) * k / count)
            places.append(tip_position(_between(before, after, k / count), p.links))
    return np.array(times), np.array(places)


def _turn(before: TrajectoryPoint, after: TrajectoryPoint) -> float:
    """Return the greatest turn of a joint between two points [rad]."""
    return max(abs(b - a) for a, b in zip(before.angles, after.angles, strict=True))


def _between(before: TrajectoryPoint, after: TrajectoryPoint, u: float) -> Vec3:
    """Return the joint angles [rad] when a share u of the time between two points has passed."""
    h = after.time - before.time
    if before.rates is None or after.rates is None:
        one, two, three = (a + u * (b - a) for a, b in zip(before.angles, after.angles, strict=True))
        return one, two, three
    ends = scipy.interpolate.CubicHermiteSpline(
        [0.0, h], [before.angles, after.angles], [before.rates, after.rates]
    )
    one, two, three = ends(u * h).tolist()
    return one, two, three
