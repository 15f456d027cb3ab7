"""What the crane will do of a cycle, from where its tip is: legs, and steps of the grapple.

Every place of every leg is tried beforehand: what is out of reach, beyond a joint's limit, singular or
within a wall is refused, and the sentence names the segment. A leg is told how fast the tip may be at each
place, so that no limit need act. Where one acts after all, the tip is slower, and stays on the path.

| symbol | name | unit |
|---|---|---|
| s | way along a leg | m |
| v^2 | allowed there, with room to brake for what follows | m^2/s^2 |
"""

import math
from typing import NamedTuple

import numpy as np

from forest_control.config.controller_settings import Parameters
from forest_control.limits.velocity_scaling import velocity_scaling
from forest_control.limits.workspace import wall_scaling
from forest_control.pipeline.motion_limits import velocity_limits_at
from forest_control.taught.cycle import Cycle, Grapple, Path, Segment
from forest_control.taught.tip_path import PathError, TipPath, bounded, braked, polyline, timed
from forest_description.derived.limits import start_tip
from forest_description.geometry.kinematics import inverse_kinematics, is_singular, joint_rates
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3

STEP = 0.01  # [m] between the places that are tried: a crane's limits change little on it
RAMP = 0.5  # [m/s^2] with which a leg begins and ends; chosen, as of the tracked paths
RESERVE = 0.98  # [1] of the velocity limits that is planned with, so that no scaling acts
CRAWL = 0.01  # [m/s] where limits leave less, the tip would not get on; chosen
THERE = 0.02  # [m] from a leg's start: nearer, the tip is led onto it without a leg of its own
FAST = 100.0  # [m/s] more than any wall leaves
WHOLE = 1.0 - 1e-9  # [1] of a speed that no limit scales: rounding
HALVINGS = 10  # [1] of an interval of speeds: to a thousandth of it


class Leg(NamedTuple):
    """A way of the tip, with the speed that is allowed at each place."""

    number: int  # of its segment, from 1
    name: str  # of its segment
    path: TipPath
    ways: Floats  # [N] s
    square: Floats  # [N] v^2

    def speed_at(self, s: float) -> float:
        """Return v [m/s] that is allowed at a way s [m]."""
        return math.sqrt(float(np.interp(s, self.ways, self.square)))

    @property
    def duration(self) -> float:
        """How long the leg takes from rest to rest, if no limit acts [s]."""
        return timed(self.ways, self.square, RAMP).duration


class Hold(NamedTuple):
    """A step of the grapple, while the tip stands."""

    number: int  # of its segment, from 1
    name: str
    grapple: Grapple

    @property
    def text(self) -> str:
        """What is done, and what ends it."""
        _, action, time = self.grapple
        wait = f"for {time:g} s" if time else "until a person confirms"
        return f"{self.name}: grapple {action}, {wait}"


Step = Leg | Hold


def planned(cycle: Cycle, start: Vec3, p: Parameters) -> tuple[Step, ...]:
    """Return the steps of a cycle for a tip that is at a place [m]; none where it is there already.

    Raises:
        PathError: the tip cannot go there; the sentence names the segment.
    """
    if not cycle.segments:
        raise PathError(f"cycle {cycle.name!r}: no segment; allowed: one at the least")
    steps: list[Step] = []
    here = start
    for number, segment in enumerate(cycle.segments, start=1):
        if isinstance(segment, Grapple):
            steps.append(Hold(number, segment.name, segment))
            continue
        for points in _ways(segment, here):
            steps.append(leg(number, segment.name, points, segment.speed, p))
            here = points[-1]
    return tuple(steps)


def assumed_start(cycle: Cycle, machine: Machine) -> Vec3:
    """Return where the tip is taken to be beforehand [m]: at a first path's start, else the machine's."""
    first = cycle.segments[0] if cycle.segments else None
    return first.points[0] if isinstance(first, Path) else start_tip(machine)


def _ways(segment: Segment, here: Vec3) -> list[list[Vec3]]:
    """Return the waypoints [m] of a segment's legs from a place [m]: to its start, and along it."""
    assert not isinstance(segment, Grapple)
    points = list(segment.points) if isinstance(segment, Path) else [segment.tip]
    ways = [points] if len(points) > 1 else []
    return [[here, points[0]], *ways] if math.dist(here, points[0]) > THERE else ways


def leg(number: int, name: str, points: list[Vec3], speed: float, p: Parameters) -> Leg:
    """Return the leg of a segment through points [m] at a speed [m/s].

    Raises:
        PathError: the tip cannot go there.
    """
    path = polyline(f"segment {name!r}", points)

    def limit(place: Vec3, along: Vec3) -> float:
        allowed = RESERVE * greatest_speed(path.name, place, along, speed / RESERVE, p)
        return min(allowed, _between_walls(path.name, place, along, p))

    ways, square = bounded(path, speed, limit, STEP)
    return Leg(number, name, path, ways, braked(ways, square, RAMP))


def greatest_speed(name: str, place: Vec3, along: Vec3, most: float, p: Parameters) -> float:
    """Return the speed [m/s], up to the most that is asked for, at which no velocity limit acts.

    A limit that is near acts before it is reached, because its corner is rounded. So the limits are asked at
    the speed itself, which is halved in between until they leave all of it.

    Args:
        name: of the path, for messages.
        place: of the tip [m].
        along: direction, a unit vector.
        most: asked for [m/s].
        p: the controller's parameters.

    Raises:
        PathError: none, because the place is out of reach, or a joint at its limit; it names the path.
    """
    try:
        angles = inverse_kinematics(place, p.links)
    except ValueError as error:
        raise PathError(f"{name}: {error}") from error

    def factor(speed: float) -> float:
        rates = joint_rates(angles, (speed * along[0], speed * along[1], speed * along[2]), p.links)
        return velocity_scaling(angles, rates, velocity_limits_at(angles, rates, p)).factor

    least = 0.0 if is_singular(angles, p.links) else factor(most)
    if least <= 0.0:
        raise PathError(f"{name}: at {_shown(place)} m a joint is at its limit")
    if least >= WHOLE:
        return most
    low, high = 0.0, least * most  # what is left of more is more than what may be asked for
    if factor(high) >= WHOLE:
        return high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if factor(middle) >= WHOLE else (low, middle)
    return low


def _between_walls(name: str, place: Vec3, along: Vec3, p: Parameters) -> float:
    """Return the speed [m/s] at which no wall takes the tip aside.

    Raises:
        PathError: the tip would hardly move.
    """
    left = FAST * wall_scaling(place, (FAST * along[0], FAST * along[1], FAST * along[2]), p.workspace)
    if left < CRAWL:
        raise PathError(f"{name}: at {_shown(place)} m a wall of the work area is in the way")
    return left


def _shown(place: Vec3) -> tuple[float, ...]:
    return tuple(round(x, 3) for x in place)
