"""The standard task of the boom-tip studies, as legs from place to place.

Two logs, red and blue, go from the ground into the bunk and back: the seven carries and ways of Manner et al.
(Silva Fennica 51(2), 1717, table 1), of which the eighth, the way back to the red log, was left out there,
too. A trial begins with the open grapple at the red log.

Each carry or way goes up until it clears the stakes, across, and down; within the bunk a hop suffices.
"""

import math
from itertools import pairwise
from typing import NamedTuple

from forest_description.types import Vec3
from forest_study.log_work.site import Site

HOP = 0.7  # [m] above both places of a way within the bunk, on a crane that reaches 8 m; assumed
GRASP, RELEASE = 1.5, 0.8  # [s] in which a grapple of the class closes and opens; assumed
LOADING, WITHIN, UNLOADING = "loading", "within the bunk", "unloading"
UP, ACROSS, DOWN, HOLD = "up", "across", "down", "grapple"


class Leg(NamedTuple):
    """A way of the grip to a place, and what the grapple does there."""

    goal: Vec3  # [m]
    part: str  # of a carry: `UP`, `ACROSS` or `DOWN`
    number: int  # of the carry or way, 1 to 7
    loaded: bool
    act: str = ""  # "grasp" or "release" at its end, none on the way


PHASES = {1: LOADING, 2: LOADING, 3: LOADING, 4: WITHIN, 5: UNLOADING, 6: UNLOADING, 7: UNLOADING}


def start(site: Site) -> Vec3:
    """Return where the grip is when a trial begins [m]."""
    return site.places["red on the ground"]


def legs(site: Site) -> tuple[Leg, ...]:
    """Return the task; its first act grasps the red log where the grip is."""
    g, b = "on the ground", "in the bunk"
    stations = (
        f"red {g}",
        f"red {b}",
        f"blue {g}",
        f"blue {b}",
        f"red {b}",
        f"red {g}",
        f"blue {b}",
        f"blue {g}",
    )
    found = [Leg(start(site), DOWN, 1, loaded=False, act="grasp")]
    for number, (begin, end) in enumerate(pairwise(stations), start=1):
        here, there = site.places[begin], site.places[end]
        hop = begin.endswith(b) and end.endswith(b)
        height = max(here[2], there[2]) + HOP * site.scale if hop else site.clear
        loaded = number % 2 == 1
        found += [
            Leg((here[0], here[1], height), UP, number, loaded),
            Leg((there[0], there[1], height), ACROSS, number, loaded),
            Leg(there, DOWN, number, loaded, act="release" if loaded else "grasp"),
        ]
    return tuple(found)


def shortest(site: Site) -> float:
    """Return the grip's shortest way through every leg's end [m]: straight, or along a spiral."""
    way, here = 0.0, start(site)
    for leg in legs(site):
        way += _length(here, leg.goal)
        here = leg.goal
    return way


def _length(a: Vec3, b: Vec3) -> float:
    """Return a leg's way [m]: a crane that turns while it reaches goes along a spiral."""
    turn = abs(math.atan2(b[1], b[0]) - math.atan2(a[1], a[0]))
    r, s = math.hypot(a[0], a[1]), math.hypot(b[0], b[1])
    straight = math.dist(a, b)
    return min(straight, math.hypot(0.5 * (r + s) * turn, s - r, b[2] - a[2])) if turn < 1.0 else straight
