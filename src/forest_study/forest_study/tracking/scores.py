"""The figures of a track run: every measure of every lap, over the rows in which its profile moves.

Rows are told by the profiles' clock, which waits where a limit holds the reference back; the ideal point goes
on from the lap's first row without waiting.
"""

import math
from typing import NamedTuple

import numpy as np

from forest_control.taught.tip_path import Line, Profile, TipPath, distances_from, line_through
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.closed_loop.compiled_loop import Led
from forest_study.measures import deviation, ideal, line_of, squares, time_lost

SATURATED = 0.999  # of the rated voltage


class Lap(NamedTuple):
    """A lap's start [s] by the profiles' clock, its path and its profile."""

    start: float
    path: TipPath
    profile: Profile

    def rows(self, clock: Floats) -> range:
        """Return the rows in which the profile moves, first and last included.

        Args:
            clock: of the profiles, by row [N] periods.
        """
        begin, end = self.start / PERIOD, (self.start + self.profile.duration) / PERIOD
        return range(int(np.searchsorted(clock, round(begin))), int(np.searchsorted(clock, end)) + 1)


class Drawn(NamedTuple):
    """A lap as its runs are held against it."""

    lap: Lap
    line: Floats  # [M, 3] m, the path as drawn
    near: Line  # the same, as distances are taken from it
    ideal: Floats  # [N, 3] m, where the ideal point is from period to period; at last at the end

    def ideal_in(self, rows: range) -> Floats:
        """Return where the ideal point is in the rows of a run that takes its own time [M, 3] m."""
        found: Floats = self.ideal[np.minimum(np.arange(len(rows)), len(self.ideal) - 1)]
        return found


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
    duration_s: float  # of the run's motion
    saturated_s: float


class _Away(NamedTuple):
    """How far a tip was off in the rows of a lap."""

    rows: slice
    governed: Floats  # [N] m
    cross: Floats  # [N] m
    wish: Floats  # [N] m
    lost: float  # [s]
    end: float  # [m]


def drawn(lap: Lap) -> Drawn:
    """Return what a lap's runs are held against."""
    first = round(lap.start / PERIOD)
    end = math.ceil((lap.start + lap.profile.duration) / PERIOD) + 1
    times = PERIOD * np.arange(first, end, dtype=np.float64) - lap.start
    line = line_of(lap.path)
    return Drawn(lap, line, line_through(line), ideal(lap.path, lap.profile, times))


def scores_of(laps: tuple[Drawn, ...], led: Led, machine: Machine) -> tuple[tuple[Score, ...], Score]:
    """Return the score of every lap, and of all together; the governed reference starts with the first."""
    moved = led.moved
    rows = [one.lap.rows(led.clock) for one in laps]
    governed = moved.tip_error()
    governed = np.sqrt(squares(governed - governed[rows[0][0]]))
    ends = [other[0] for other in rows[1:]] + [len(moved.tip)]
    each = zip(laps, rows, ends, strict=True)
    parts = [_away(one, within, end, governed, moved.tip) for one, within, end in each]
    rated = np.array([machine.valve_of(axis).rated_voltage for axis in range(3)])
    each_lap = tuple(_score([part], moved, rated) for part in parts)
    return each_lap, each_lap[0] if len(parts) == 1 else _score(parts, moved, rated)


def _away(one: Drawn, rows: range, end: int, governed: Floats, tips: Floats) -> _Away:
    """Return how far tips [N, 3] m were off in the rows of a lap whose rest lasts up to a row."""
    lap, moving = one.lap, slice(rows.start, rows.stop)  # numpy would go through a range number by number
    times = PERIOD * np.arange(end - rows.start, dtype=np.float64)
    return _Away(
        rows=moving,
        governed=governed[moving],
        cross=distances_from(one.near, tips[moving]),
        wish=np.sqrt(squares(tips[moving] - one.ideal_in(rows))),
        lost=time_lost(lap.path, lap.profile, times, tips[rows.start : end]),
        end=math.dist(tips[end - 1], lap.path.at(lap.path.length)),
    )


def _score(parts: list[_Away], moved: Trajectory, rated: Floats) -> Score:
    """Return the score of some laps: times are added, the greatest end counts."""
    rows = np.concatenate([np.arange(part.rows.start, part.rows.stop) for part in parts])
    governed, cross, wish = (
        deviation(np.concatenate([getattr(part, name) for part in parts]))
        for name in ("governed", "cross", "wish")
    )
    velocity = np.gradient(moved.tip, PERIOD, axis=0) - moved.tip_wish
    swing, boom, stick = (np.abs(moved.voltages[rows]) >= SATURATED * rated).T
    return Score(
        governed_rms_mm=governed.rms_mm,
        governed_max_mm=governed.max_mm,
        cross_track_rms_mm=cross.rms_mm,
        cross_track_max_mm=cross.max_mm,
        wish_rms_mm=wish.rms_mm,
        wish_max_mm=wish.max_mm,
        time_lost_s=sum(part.lost for part in parts),
        end_mm=1e3 * max(part.end for part in parts),
        velocity_rms=float(np.sqrt(np.mean(squares(velocity[rows])))),
        duration_s=PERIOD * (len(rows) - 1),
        saturated_s=PERIOD * float((swing | boom | stick).sum()),
    )
