"""A bag's numbers as one table, joined on stamps.

===========  ===============================================================================================
symbol       meaning
===========  ===============================================================================================
stamp        header stamp, ns; where a message has none, its log time
row          one stamp at which any topic has a message; a topic without one there has NaN
hold         such a topic has the values of its last message instead
column       ``topic/label[unit]``, without the topic's leading slash
===========  ===============================================================================================
"""

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_bag.read.timeseries import Bag, NotInBag, Series
from forest_bag.storage.bag_files import BagError
from forest_description.types import Floats


class Column(NamedTuple):
    """One signal."""

    name: str
    unit: str
    values: Floats

    @property
    def header(self) -> str:
        """Name with unit."""
        return f"{self.name}[{self.unit}]" if self.unit else self.name


class Table(NamedTuple):
    """Rows in the order of their stamps."""

    stamps_ns: NDArray[np.int64]
    columns: list[Column]
    notes: list[str]  # what is not in it, and why


def joined(bag: Bag, topics: Collection[str] = (), at: str = "", hold: bool = False) -> Table:
    """Join topics.

    Args:
        bag: in memory.
        topics: only these; (): all that have numbers.
        at: rows only at the stamps of this topic, and the others held.
        hold: fill with the last message's values.

    Raises:
        BagError: the bag has not got a topic, or nothing in it is a number.
    """
    notes: list[str] = []
    found: dict[str, Series] = {}
    wanted = topics or bag.topics
    for name in dict.fromkeys([*wanted, *([at] if at else [])]):
        try:
            series = _in_order(bag.series(name))
        except NotInBag as error:
            raise BagError(str(error)) from error
        except ValueError as error:  # texts, or a type that is not installed
            notes.append(f"left out: {error}")
            continue
        if len(series.time_ns):
            found[name] = series
    if at and at not in found:
        raise BagError(f"no numbers on '{at}'; they are on {', '.join(found) or 'no topic'}")
    if not found:
        raise BagError("; ".join(["no numbers in the bag", *notes]))
    stamps = np.unique(found[at].time_ns if at else np.concatenate([one.time_ns for one in found.values()]))
    columns = []
    for name, series in found.items():
        if name not in wanted:
            continue
        notes += _notes(name, series)
        columns += _columns(name, series, stamps, hold or bool(at))
    return Table(stamps, columns, notes)


def _notes(name: str, series: Series) -> list[str]:
    """What of a topic is not in the table as it is in the bag."""
    notes = []
    if series.unreadable:
        notes.append(f"{name}: {series.unreadable} messages are not of its type, their rows are empty")
    if doubled := len(series.time_ns) - len(np.unique(series.time_ns)):
        notes.append(f"{name}: {doubled} messages share their stamp with a later one, which is kept")
    return notes


def _in_order(series: Series) -> Series:
    order = np.argsort(series.time_ns, kind="stable")
    return series._replace(time_ns=series.time_ns[order], values=series.values[order])


def _columns(name: str, series: Series, stamps: NDArray[np.int64], hold: bool) -> list[Column]:
    place = np.searchsorted(series.time_ns, stamps, side="right") - 1
    given = place >= 0
    if not hold:
        given &= series.time_ns[np.maximum(place, 0)] == stamps
    values = np.where(given[:, np.newaxis], series.values[np.maximum(place, 0)], np.nan)
    return [
        Column(f"{name.lstrip('/')}/{label}", unit, values[:, number])
        for number, (label, unit) in enumerate(zip(series.labels, series.units, strict=True))
    ]
