"""An operator who leads the governed reference along a path: the path is kept, and the time gives.

A profile is a row of places, one a period. Its clock runs on while the reference follows; where a limit holds
the reference back, the clock waits, so that it is ahead of the reference by no more than the joystick takes.
The velocity that is asked for has the profile's speed by its clock, the path's direction where the reference
will be when the levers reach it, and a part that leads the reference back to the path beside it.

| symbol | name | unit |
|---|---|---|
| clock | how much of the profile is asked for | periods |
| beside | where the profile was beside the reference | periods |
| r | the reference: the integral of what the controller says that it aims at, from the path's start | m |
| w | way of the profile in a period; at both ends and at corners it vanishes | m |

All here stays in the subset of Python that `forest_compile` translates.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from forest_control.operator.levers import REST, Levers, levers_for_tip_velocity
from forest_description.geometry.vectors import dot, minus, norm
from forest_description.types import Vec3
from forest_msgs_py.types import PERIOD

SPLITTER = 2.0**29 + 1.0  # double to single precision: 53 bits to 24
BACK = 3.0  # [1/s] speed per distance beside the path: as of position mode
AHEAD = 1.5  # [1] times the joystick's period, by which the clock may be ahead beyond the latency
STILL = 1e-7  # [m] of w: less is rest; a ramp's first period has 6e-6 m
QUICKEST = 8.0  # [1] periods by which the place beside the reference may move in one


class Guide(NamedTuple):
    """What is remembered between two periods."""

    clock: float
    beside: float
    place: Vec3  # r [m]


class Hand(NamedTuple):
    """What is between an operator and the controller."""

    speed: float  # [m/s] of the tip at full deflection
    latency: float = 0.0  # [periods] of the reference behind the levers
    every: int = 1  # [periods] between two words of the joystick
    steps: float = 0.0  # of the joystick's converter on each side; 0: single precision, as in its message


def levers_for(velocity: Vec3, hand: Hand) -> Levers:
    """Return the levers of a joystick's message that ask for a tip velocity [m/s]."""
    exact = levers_for_tip_velocity(velocity, hand.speed)
    return Levers(
        _converted(exact.swing, hand.steps),
        _converted(exact.boom, hand.steps),
        _converted(exact.stick, hand.steps),
    )


def _converted(deflection: float, steps: float) -> float:
    """Return what a joystick says of a deflection."""
    within = max(-1.0, min(1.0, deflection))
    if steps > 0.0:
        within = int(within * steps + math.copysign(0.5, within)) / steps
    shifted = SPLITTER * within  # Veltkamp: what is left has the bits of single precision
    return shifted - (shifted - within)


def place_at(places: Sequence[float], at: float, last: int) -> Vec3:
    """Return the profile's place [m] at a clock, straight between two periods.

    Args:
        places: x, y, z of each period, one after the other [m].
        at: the clock [periods].
        last: number of the last period.
    """
    k = int(max(0.0, min(at, last - 1.0)))
    share = max(0.0, min(at - k, 1.0))
    return (
        places[3 * k] + share * (places[3 * k + 3] - places[3 * k]),
        places[3 * k + 1] + share * (places[3 * k + 4] - places[3 * k + 1]),
        places[3 * k + 2] + share * (places[3 * k + 5] - places[3 * k + 2]),
    )


def asked(guide: Guide, hand: Hand, places: Sequence[float], last: int) -> Vec3:
    """Return the tip velocity [m/s] that the operator wishes in this period."""
    size = norm(_step(places, guide.clock, last))
    if size < STILL:
        return 0.0, 0.0, 0.0
    along = _step(places, min(guide.clock, guide.beside + hand.latency), last)
    if norm(along) < STILL:
        along = _step(places, guide.clock, last)
    length = norm(along)
    e, speed = minus(place_at(places, guide.beside, last), guide.place), size / (PERIOD * length)
    behind = dot(e, along) / (length * length)
    return (
        speed * along[0] + BACK * (e[0] - behind * along[0]),
        speed * along[1] + BACK * (e[1] - behind * along[1]),
        speed * along[2] + BACK * (e[2] - behind * along[2]),
    )


def answered(
    guide: Guide, said: Levers, velocity: Vec3, hand: Hand, places: Sequence[float], last: int
) -> Guide:
    """Return the guide a period later.

    Args:
        guide: before.
        said: the levers over the period; centred ones let the clock run on, for nothing waits for them.
        velocity: of the governed reference over the period [m/s].
        hand: joystick and operator.
        places: of the profile.
        last: number of the last period.
    """
    r = (
        guide.place[0] + PERIOD * velocity[0],
        guide.place[1] + PERIOD * velocity[1],
        guide.place[2] + PERIOD * velocity[2],
    )
    along, away = _step(places, guide.beside, last), minus(r, place_at(places, guide.beside, last))
    square = dot(along, along)
    if square < STILL * STILL:
        beside = guide.beside + 1.0
    else:
        ahead = dot(away, along) / square
        beside = guide.beside + max(0.0, min(ahead, QUICKEST))
    after = guide.clock + 1.0
    if said == REST:
        return Guide(after, after, r)
    beside = min(beside, after)
    return Guide(max(guide.clock, min(after, beside + hand.latency + AHEAD * hand.every)), beside, r)


def _step(places: Sequence[float], at: float, last: int) -> Vec3:
    """Return the profile's way [m] in the period from a clock on."""
    return minus(place_at(places, at + 1.0, last), place_at(places, at, last))
