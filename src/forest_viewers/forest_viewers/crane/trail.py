"""Where the tip was and where it was told to be, over the last seconds.

The commanded trail is the integral of the commanded velocity. It begins at the tip when a motion
begins, and ends with it; so the distance between the two trails is what the tip is off by.
"""

from typing import NamedTuple

from forest_description.types import Vec3

SPAN = 10.0  # [s] that the trails are long
SPACING = 0.05  # [s] between their points
LONGEST_GAP = 0.1  # [s] between two commands of one motion
STILL = 1e-4  # [m/s] of a command that is none


class Point(NamedTuple):
    """A place at a time."""

    time: float  # [s]
    place: Vec3  # [m]


class Trail(NamedTuple):
    """What is remembered; times by the messages' stamps."""

    tip: tuple[Point, ...] = ()
    command: tuple[Point, ...] = ()
    target: Point | None = None  # of the motion under way


def with_tip(trail: Trail, time: float, tip: Vec3) -> Trail:
    """Return the trail with the tip's place [m] at a time [s]; what is older than `SPAN` is gone."""
    if trail.tip and trail.tip[-1].time > time:
        trail = Trail()  # the clock went back: another run
    return trail._replace(tip=_extended(trail.tip, Point(time, tip)), command=_young(trail.command, time))


def with_command(trail: Trail, time: float, velocity: Vec3) -> Trail:
    """Return the trail with a commanded velocity [m/s] at a time [s], once the tip is known."""
    if not trail.tip or max(map(abs, velocity)) < STILL:
        return trail._replace(target=None)
    before = trail.target
    if before is None or not 0.0 <= time - before.time < LONGEST_GAP:
        before = Point(time, trail.tip[-1].place)
    dt = time - before.time
    x, y, z = (p + dt * v for p, v in zip(before.place, velocity, strict=True))
    target = Point(time, (x, y, z))
    return trail._replace(target=target, command=_extended(trail.command, target))


def _extended(points: tuple[Point, ...], new: Point) -> tuple[Point, ...]:
    if points and new.time - points[-1].time < SPACING:
        return points
    return (*_young(points, new.time), new)


def _young(points: tuple[Point, ...], now: float) -> tuple[Point, ...]:
    first = next((i for i, point in enumerate(points) if now - point.time <= SPAN), len(points))
    return points[first:]
