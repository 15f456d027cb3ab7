"""The figures of a track run: every measure of every lap, over the rows in which its profile moves."""

import math
from typing import NamedTuple

import numpy as np

from forest_control.taught.tip_path import Profile, TipPath, distance_from
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.measures import deviation, ideal, line_of, time_lost

SATURATED = 0.999  # of the rated voltage


class Lap(NamedTuple):
    """A lap's start [s], its path and its profile."""

    start: float
    path: TipPath
    profile: Profile

    @property
    def rows(self) -> range:
        """The rows in which the profile moves, first and last included."""
        end = math.ceil((self.start + self.profile.duration) / PERIOD) + 1
        return range(round(self.start / PERIOD), end)


class Drawn(NamedTuple):
    """A lap as its runs are held against it."""

    lap: Lap
    line: Floats  # [M, 3] m, the path as drawn
    ideal: Floats  # [N, 3] m, where the ideal point is in each of its rows


class Score(NamedTuple):
    """How well a lap was tracked, or all of them; measures: `measures`."""

    governed_rms_mm: float
    governed_max_mm: float
    cross_track_rms_mm: float
    cross_track_max_mm: float
    wish_rms_mm: float
    wish_max_mm: float
    time_lost_s: float
    end_mm: float  # true tip from the path's end, once the rest after the lap is over
    velocity_rms: float  # [m/s] against the governed reference
    duration_s: float  # of the profile
    saturated_s: float


class _Away(NamedTuple):
    """How far a tip was off in the rows of a lap."""

    rows: range
    governed: Floats  # [N] m
    cross: Floats  # [N] m
    wish: Floats  # [N] m
    lost: float  # [s]
    end: float  # [m]


def drawn(lap: Lap) -> Drawn:
    """Return what a lap's runs are held against."""
    times = PERIOD * np.array(lap.rows) - lap.start
    return Drawn(lap, line_of(lap.path), ideal(lap.path, lap.profile, times))


def scores_of(
    laps: tuple[Drawn, ...], moved: Trajectory, machine: Machine
) -> tuple[tuple[Score, ...], Score]:
    """Return the score of every lap, and of all together; the governed reference starts with the first."""
    governed = moved.tip_error()
    governed = np.linalg.norm(governed - governed[laps[0].lap.rows[0]], axis=1)
    ends = [other.lap.rows[0] for other in laps[1:]] + [len(moved.tip)]
    parts = [_away(one, end, governed, moved.tip) for one, end in zip(laps, ends, strict=True)]
    rated = np.array([machine.valve_of(axis).rated_voltage for axis in range(3)])
    return tuple(_score([part], moved, rated) for part in parts), _score(parts, moved, rated)


def _away(one: Drawn, end: int, governed: Floats, tips: Floats) -> _Away:
    """Return how far tips [N, 3] m were off in a lap whose rest lasts up to a row."""
    rows, lap = one.lap.rows, one.lap
    whole = np.arange(rows[0], end)
    times = np.array([PERIOD * row - lap.start for row in range(rows[0], end)])
    return _Away(
        rows=rows,
        governed=governed[rows],
        cross=distance_from(one.line, tips[rows]),
        wish=np.linalg.norm(tips[rows] - one.ideal, axis=1),
        lost=time_lost(lap.path, lap.profile, times, tips[whole]),
        end=math.dist(tips[end - 1], lap.path.at(lap.path.length)),
    )


def _score(parts: list[_Away], moved: Trajectory, rated: Floats) -> Score:
    """Return the score of some laps: times are added, the greatest end counts."""
    rows = np.concatenate([part.rows for part in parts])
    governed, cross, wish = (
        deviation(np.concatenate([getattr(part, name) for part in parts]))
        for name in ("governed", "cross", "wish")
    )
    velocity = np.gradient(moved.tip, PERIOD, axis=0) - moved.tip_wish
    saturated = np.any(np.abs(moved.voltages[rows]) >= SATURATED * rated, axis=1)
    return Score(
        governed_rms_mm=governed.rms_mm,
        governed_max_mm=governed.max_mm,
        cross_track_rms_mm=cross.rms_mm,
        cross_track_max_mm=cross.max_mm,
        wish_rms_mm=wish.rms_mm,
        wish_max_mm=wish.max_mm,
        time_lost_s=sum(part.lost for part in parts),
        end_mm=1e3 * max(part.end for part in parts),
        velocity_rms=float(np.sqrt(np.mean(np.sum(velocity[rows] ** 2, axis=1)))),
        duration_s=PERIOD * (len(rows) - 1),
        saturated_s=PERIOD * float(saturated.sum()),
    )
