"""Two sessions that were recorded at different times, compared signal by signal on a common time.

===============  ===========================================================================================
symbol           meaning
===============  ===========================================================================================
origin           stamp that counts as time 0 of a bag: its first message's, or a chosen topic's first
t                stamp - origin, s
difference       b(t) - a(t) at the stamps of a, b interpolated linearly
===============  ===========================================================================================

Of several messages of one stamp the last counts. Only the span that both have counts. Log times, bytes and
texts mean nothing here and are not compared.
"""

from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from forest_bag.compare.comparison import Comparison, SignalDifference, TopicDifference
from forest_bag.compare.pairing import common_topics
from forest_bag.read.bag_reader import BagReader
from forest_bag.read.timeseries import Bag, NotInBag, Series, read_bag
from forest_bag.storage.bag_files import BagError
from forest_description.types import Floats

START = "start"  # the origin of a bag is its first stamp


def compare_aligned(
    a: BagReader, b: BagReader, origin: str, ignore: Collection[str] = (), only: Collection[str] | None = None
) -> Comparison:
    """Compare the numbers of two bags on the time since their origins.

    Args:
        a: one bag.
        b: the other.
        origin: a topic whose first stamp is time 0, or "start".
        ignore: topics to leave out beside those of the wall clock.
        only: topics to compare; None: all.

    Raises:
        BagError: a bag has no message of the topic that gives the origin.
    """
    topics, alone, ignored = common_topics(a, b, ignore, only)
    wanted = {*topics, origin}
    bags = read_bag(a.path, wanted), read_bag(b.path, wanted)
    origins = [_origin(bag, origin, reader.path, topics) for bag, reader in zip(bags, (a, b), strict=True)]
    compared = {}
    for name, result in topics.items():
        try:
            series = bags[0].series(name), bags[1].series(name)
        except ValueError:  # texts, or a type that is not installed
            ignored = (*ignored, name)
            continue
        _compare_series(result, series, origins)
        compared[name] = result
    return Comparison(compared, alone, tuple(sorted(ignored)), (origins[0], origins[1]))


def _origin(bag: Bag, origin: str, path: Path, topics: Collection[str]) -> int:
    if origin != START:
        try:
            stamps = bag.series(origin).time_ns
        except (NotInBag, ValueError) as error:
            raise BagError(
                f"{path}: {error}; allowed for --align: {START}, or a topic with numbers"
            ) from error
        if not len(stamps):
            raise BagError(f"{path}: {origin} has no message; allowed for --align: one that has")
        return int(stamps[0])
    return min((stamp for name in topics for stamp in _first_stamp(bag, name)), default=0)


def _first_stamp(bag: Bag, name: str) -> list[int]:
    try:
        return [int(stamp) for stamp in bag.series(name).time_ns[:1]]
    except ValueError:  # texts: they are not compared
        return []


def _compare_series(result: TopicDifference, series: tuple[Series, Series], origins: list[int]) -> None:
    a, b = series
    result.counts = [len(a.time_ns), len(b.time_ns)]
    shared = [label for label in a.labels if label in b.labels]
    for label in (*a.labels, *b.labels):
        if label not in shared:
            result.structure += 1
            result.note(0, int(origins[0]), f"{label} only in {'A' if label in a.labels else 'B'}")
    a, b = _last_of_each_stamp(a), _last_of_each_stamp(b)
    times = a.time_ns - origins[0], b.time_ns - origins[1]
    if not (len(times[0]) and len(times[1])):
        return
    covered = (times[0] >= times[1][0]) & (times[0] <= times[1][-1])
    result.pairs = int(covered.sum())
    stamps = a.time_ns[covered]
    for label in shared:
        unit = a.units[a.labels.index(label)]
        difference = interpolated(times[1], b.column(label), times[0][covered]) - a.column(label)[covered]
        signal = result.signals[label] = SignalDifference(label, unit)
        for place in np.flatnonzero(difference != 0.0).tolist():
            signal.add(float(difference[place]), int(stamps[place]))
            result.note(
                place, int(stamps[place]), f"{label} differs by {difference[place]:.9g} {unit}".rstrip()
            )
        result.differing = max(result.differing, int((difference != 0.0).sum()))


def _last_of_each_stamp(series: Series) -> Series:
    """Return the series without messages that another of the same stamp follows."""
    kept = np.append(np.diff(series.time_ns) != 0, True)[: len(series.time_ns)]
    return series._replace(
        time_ns=series.time_ns[kept], log_time_ns=series.log_time_ns[kept], values=series.values[kept]
    )


def interpolated(time_ns: NDArray[np.int64], values: Floats, wanted_ns: NDArray[np.int64]) -> Floats:
    """Values at other times; NaN around samples that are missing."""
    return np.interp(wanted_ns, time_ns, values)
