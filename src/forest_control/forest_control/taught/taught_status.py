"""What is told of taught work: numbers on `cycle/status`, words on /diagnostics."""

import math
from typing import NamedTuple

from forest_control.taught.plan import Hold
from forest_control.taught.player import Phase, State
from forest_description.types import Vec3


class Status(NamedTuple):
    """The values of `cycle/status`."""

    phase: int
    segment: int = 0  # from 1; 0: none
    segments: int = 0
    way: float = 0.0  # [m]
    length: float = 0.0  # [m]
    away: float = 0.0  # [m]


def status_of(state: State, tip: Vec3 | None) -> Status:
    """Return where a player is, its tip being at a place [m]."""
    if not state.steps or state.at >= len(state.steps):
        last = state.steps[-1].number if state.steps else 0
        return Status(state.phase, last, last)
    number, numbers = state.steps[state.at].number, state.steps[-1].number
    place = state.back or state.place
    if place is None or tip is None:
        return Status(state.phase, number, numbers)
    away = math.dist(place.leg.path.at(place.way), tip)
    return Status(state.phase, number, numbers, place.way, place.leg.path.length, away)


def segment_of(state: State) -> str:
    """Return the name of the segment that a player is in, or ""."""
    return state.steps[state.at].name if state.at < len(state.steps) else ""


def waiting(state: State) -> str:
    """Return what a player waits for, or ""."""
    if state.phase == Phase.WAITING:
        return "waiting for a held deadman and centred sticks"
    if state.phase == Phase.PAUSED:
        return f"paused: {state.cause}"
    step = state.steps[state.at] if state.phase == Phase.HOLDING else None
    return step.text if isinstance(step, Hold) else ""
