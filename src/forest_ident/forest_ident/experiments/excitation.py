"""The scripted operator of the experiments: one axis or several go to and fro under a programme of voltages.

A programme is rows of (duration, level at its start, level at its end) per axis, played over and over; the
sign is the way the axis goes at the moment. An axis that passes a soft limit turns round. So nothing has to
be known about how far a voltage moves it, and nothing runs into a stop.

| symbol | name | unit |
|---|---|---|
| way | +1 positive, -1 negative direction | 1 |
| level | voltage along the way, straight from the row's start to its end | V |

Pure: `step` is what a node calls at every sample and what an offline run calls every 5 ms.
"""

from __future__ import annotations

from typing import NamedTuple

from forest_description.types import Vec3


class Row(NamedTuple):
    """A piece of a programme."""

    duration: float  # [s]
    start: float  # [V]
    end: float  # [V]


class Track(NamedTuple):
    """What one axis does: its programme, and the joint angles [rad] between which it goes to and fro.

    With ``alternate`` each run of the programme goes the other way.
    """

    rows: tuple[Row, ...]
    low: float
    high: float
    alternate: bool = False


class Programme(NamedTuple):
    """What the axes do; None: it stands. Rest is the time at zero before, and after the end [s]."""

    tracks: tuple[Track | None, Track | None, Track | None]
    duration: float  # [s]
    rest: float = 1.0


class State(NamedTuple):
    """Where the operator is: time since the start [s]; way and place in the programme of each axis."""

    time: float
    ways: Vec3
    rows: tuple[int, int, int]
    since: Vec3  # [s] in the row


START = State(0.0, (1.0, 1.0, 1.0), (0, 0, 0), (0.0, 0.0, 0.0))


def step(state: State, angles: Vec3, p: Programme, dt: float) -> tuple[State, Vec3]:
    """Return the state after, and the voltages [V] over, the next period.

    Args:
        state: now.
        angles: joint angles as measured [rad]; one that is not a number stops its axis.
        p: the programme.
        dt: the period [s].
    """
    working = p.rest <= state.time + 1e-9 < p.duration - p.rest
    ways, rows, since, volts = list(state.ways), list(state.rows), list(state.since), [0.0, 0.0, 0.0]
    for axis in range(3):
        track = p.tracks[axis]
        if track is None or not working:
            continue
        angle = angles[axis]
        if angle > track.high:
            ways[axis] = -1.0
        elif angle < track.low:
            ways[axis] = 1.0
        row = track.rows[rows[axis]]
        if angle == angle:  # not NaN
            volts[axis] = ways[axis] * _level(row, since[axis])
        since[axis] += dt
        if since[axis] > row.duration - 1e-9:
            since[axis], rows[axis] = 0.0, (rows[axis] + 1) % len(track.rows)
            if rows[axis] == 0 and track.alternate:
                ways[axis] = -ways[axis]
    after = State(state.time + dt, _triple(ways), (rows[0], rows[1], rows[2]), _triple(since))
    return after, _triple(volts)


def _level(row: Row, since: float) -> float:
    return row.start + (row.end - row.start) * min(since / row.duration, 1.0)


def _triple(values: list[float]) -> Vec3:
    return values[0], values[1], values[2]


def stairs(levels: tuple[float, ...], hold: float) -> tuple[Row, ...]:
    """Return steps that hold each level [V] for a time [s]."""
    return tuple(Row(hold, level, level) for level in levels)
