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

import math
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


class AxisState(NamedTuple):
    """Place of an axis in its programme."""

    way: float = 1.0
    row: int = 0
    since: float = 0.0  # [s] in the row


class State(NamedTuple):
    """Time since the start [s], and the axes' places in their programmes."""

    time: float
    axes: tuple[AxisState, AxisState, AxisState]


START = State(0.0, (AxisState(), AxisState(), AxisState()))


def step(state: State, angles: Vec3, p: Programme, dt: float) -> tuple[State, Vec3]:
    """Return the state after, and the voltages [V] over, the next period.

    Args:
        state: now.
        angles: joint angles as measured [rad]; one that is not a number stops its axis.
        p: the programme.
        dt: the period [s].
    """
    working = p.rest <= state.time + 1e-9 < p.duration - p.rest
    swing, boom, stick = (
        _step_axis(axis, track, angle, dt) if working and track is not None else (axis, 0.0)
        for axis, track, angle in zip(state.axes, p.tracks, angles, strict=True)
    )
    after = State(state.time + dt, (swing[0], boom[0], stick[0]))
    return after, (swing[1], boom[1], stick[1])


def _step_axis(state: AxisState, track: Track, angle: float, dt: float) -> tuple[AxisState, float]:
    way, row, since = state.way, track.rows[state.row], state.since + dt
    if angle > track.high:
        way = -1.0
    elif angle < track.low:
        way = 1.0
    volts = 0.0 if math.isnan(angle) else way * _level(row, state.since)
    if since <= row.duration - 1e-9:
        return AxisState(way, state.row, since), volts
    following = (state.row + 1) % len(track.rows)
    turned = following == 0 and track.alternate
    return AxisState(-way if turned else way, following), volts


def _level(row: Row, since: float) -> float:
    return row.start + (row.end - row.start) * min(since / row.duration, 1.0)


def stairs(levels: tuple[float, ...], hold: float) -> tuple[Row, ...]:
    """Return steps that hold each level [V] for a time [s]."""
    return tuple(Row(hold, level, level) for level in levels)
