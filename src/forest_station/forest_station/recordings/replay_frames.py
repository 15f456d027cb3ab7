"""A window of a bag as frames: every signal's newest value at each time, as a live crane sends them.

===========  ===============================================================================================
symbol       meaning
===========  ===============================================================================================
grid         times k / rate [s since the bag's first message], k whole: windows meet without a seam
row          a frame's values [n]: of each topic its newest message at that time; NaN before the first
===========  ===============================================================================================

Only those messages are decoded that are the newest at some time of the grid, so a second costs about the
same whether it is shown at 1 or at 30 frames.
"""

import math
from bisect import bisect_left
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_bag.read.timeseries import series_of
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.raw_messages import RawMessage
from forest_msgs_py.types import NS_PER_S
from forest_station.recordings.replay_bag import LARGEST_MESSAGE, ReplayBag

FRAME = 2  # first byte of a frame
MOST_FRAMES = 1800  # in a window: 60 s of 30 a second, 7 MB of 1000 signals
LONGEST_WINDOW = 600.0  # s
HIGHEST_RATE = 200.0  # Hz


class Window(NamedTuple):
    """Times k / rate for first <= k < end."""

    first: int
    end: int
    rate: float

    @property
    def times(self) -> NDArray[np.float64]:
        """Times of the frames [s since the bag's first message]."""
        return np.arange(self.first, self.end) / self.rate


def window(start: float, end: float, rate: float) -> Window:
    """Return the frames from start until before end.

    Args:
        start: [s] since the bag's first message.
        end: [s].
        rate: of the frames [Hz].

    Raises:
        BagError: the numbers make no window, or one that is too large.
    """
    if not 0.0 < rate <= HIGHEST_RATE:
        raise BagError(f"rate is {rate:g} Hz; allowed: above 0, at most {HIGHEST_RATE:g} Hz")
    if not (0.0 <= start < 1e9 and start <= end <= start + LONGEST_WINDOW):
        limit = f"start of 0 s or more, end at most {LONGEST_WINDOW:g} s later"
        raise BagError(f"start is {start:g} s, end is {end:g} s; allowed: {limit}")
    found = Window(math.ceil(start * rate - 1e-6), math.ceil(end * rate - 1e-6), rate)
    if found.end - found.first > MOST_FRAMES:
        raise BagError(f"{found.end - found.first} frames were asked for; allowed: at most {MOST_FRAMES}")
    return found


def frames(bag: ReplayBag, wanted: Window) -> bytes:
    """Return the frames of a window, one after the other, as the protocol has them."""
    times, values = wanted.times, matrix(bag, wanted)
    kind = [("kind", "u1"), ("zero", "u1", 3), ("number", "<u4"), ("time", "<f8")]
    found = np.zeros(len(times), dtype=[*kind, ("values", "<f4", (values.shape[1],))])
    found["kind"], found["number"] = FRAME, np.arange(wanted.first, wanted.end)
    found["time"], found["values"] = times, values
    return found.tobytes()


def matrix(bag: ReplayBag, wanted: Window) -> NDArray[np.float64]:
    """Return the signals [n] at each time of a window [N], one row a time."""
    values = np.full((wanted.end - wanted.first, len(bag.units)), np.nan)
    for name, picked in _picked(bag, wanted).items():
        _fill(bag, name, picked, values)
    if bag.angles:
        places = slice(values.shape[1] - len(bag.crane.signals), None)
        values[:, places] = bag.crane.positions([values[:, column] for column in bag.angles])
    return values


def _picked(bag: ReplayBag, wanted: Window) -> dict[str, dict[int, RawMessage]]:
    """By topic: first row of each message that is the newest at some time of the window."""
    picked: dict[str, dict[int, RawMessage]] = {name: {} for name in bag.topics}
    times = (bag.start_ns + np.round(wanted.times * NS_PER_S).astype(np.int64)).tolist()
    if not times or not picked:
        return picked
    for name, message in bag.reader.newest(picked, times[0]).items():
        picked[name][0] = message
    for message in bag.reader.messages(picked, times[0] + 1):
        if message.log_ns > times[-1]:
            break
        picked[message.channel.topic][bisect_left(times, message.log_ns)] = message
    return picked


def _fill(bag: ReplayBag, name: str, picked: dict[int, RawMessage], values: NDArray[np.float64]) -> None:
    """Write a topic's columns: each message's numbers from its row on, until the next."""
    rows = sorted(row for row, message in picked.items() if len(message.data) <= LARGEST_MESSAGE)
    if not rows:
        return
    try:
        series = series_of(bag.reader.channels[name][0], [picked[row] for row in rows])
    except ValueError:  # none of these is of the topic's type
        return
    columns = bag.topics[name]
    kept = [(place, columns[label]) for place, label in enumerate(series.labels) if label in columns]
    places, targets = [place for place, _ in kept], [target for _, target in kept]
    lengths = np.diff([*rows, len(values)])
    values[rows[0] :, targets] = np.repeat(series.values[:, places], lengths, axis=0)
