"""Somebody's log, a CSV file, as signals of our topics in SI units.

===============  ===========================================================================================
symbol           meaning
===============  ===========================================================================================
cell             what stands in a row under a column; empty or "nan": the sensor had no sample
times_ns         stamps, ns, strictly rising, int64 [N]
values           float64 [N, k], k signals of a topic; NaN where the cell is empty
===============  ===========================================================================================
"""

import csv
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_bag.convert.log_map import FileForm, LogMap, Signal
from forest_bag.storage.bag_files import BagError
from forest_description.types import Floats
from forest_msgs_py.interfaces.topics import JOY, Topic
from forest_msgs_py.types import NS_PER_S

MAX_STAMP_S = 2**31 - 1  # builtin_interfaces/Time
SNIFFED = (",", ";", "\t")
EMPTY = ("", "nan", "na", "null", "-")


class MeasuredLog(NamedTuple):
    """A log in SI units."""

    times_ns: NDArray[np.int64]
    values: dict[Topic, tuple[tuple[str, ...], Floats]]  # labels, [N, k]
    lines: list[int]  # of the file, for each row

    def intervals(self) -> Floats:
        """Times between rows, s."""
        return np.diff(self.times_ns) / NS_PER_S

    def rate(self) -> float:
        """Median rate [Hz]; 0 for a single row."""
        intervals = self.intervals()
        return 1.0 / float(np.median(intervals)) if len(intervals) else 0.0


def read_log(path: Path, mapping: LogMap) -> MeasuredLog:
    """Read a log and check it.

    Raises:
        BagError: a column is not there, a cell is no number, times do not rise, or a check of the map fails.
        OSError: the file cannot be read.
    """
    names, rows = _cells(path, mapping.form)
    lines = [line for line, _ in rows]
    if not rows:
        raise BagError(f"{path} has no rows below its header; allowed: one or more")

    def column(signal: Signal) -> Floats:
        if not signal.column:
            return np.full(len(rows), signal.si(0.0))
        if signal.column not in names:
            raise BagError(f"{path} has no column '{signal.column}'; it has {', '.join(names)}")
        place = names.index(signal.column)
        cells = [
            _number(cells[place], mapping.form, f"{path}:{line}: {signal.column}") for line, cells in rows
        ]
        return np.array([signal.si(cell) for cell in cells])

    times = _times(path, mapping, column, lines)
    values = {
        topic: (tuple(signals), np.column_stack([column(signal) for signal in signals.values()]))
        for topic, signals in mapping.topics.items()
    }
    log = MeasuredLog(times, values, lines)
    _check(path, log, mapping)
    return log


def _times(
    path: Path, mapping: LogMap, column: Callable[[Signal], Floats], lines: list[int]
) -> NDArray[np.int64]:
    if mapping.time is None:
        seconds = np.arange(len(lines)) / mapping.rate
    else:
        seconds = column(mapping.time)
    for line, value in zip(lines, (seconds + mapping.start).tolist(), strict=True):
        if not 0.0 <= value <= MAX_STAMP_S:
            raise BagError(
                f"{path}:{line}: time is {value:g} s; allowed: 0 .. {MAX_STAMP_S} s, see 'start' in the map"
            )
    times: NDArray[np.int64] = np.round(seconds * NS_PER_S).astype(np.int64)
    times += round(mapping.start * NS_PER_S)  # whole numbers: a date has no room for nanoseconds in a float
    for place in np.flatnonzero(np.diff(times) <= 0)[:1].tolist():
        before, after = seconds[place], seconds[place + 1]
        raise BagError(
            f"{path}:{lines[place + 1]}: time is {after:.9g} s after {before:.9g} s; times must rise"
        )
    return times


def _check(path: Path, log: MeasuredLog, mapping: LogMap) -> None:
    """Compare with what the map expects."""
    if mapping.wanted_rate is not None:
        rate, share = mapping.wanted_rate
        if abs(log.rate() - rate) > share * rate:
            raise BagError(
                f"{path}: median rate {log.rate():.4g} Hz; the map allows {rate:g} Hz ± {100 * share:g} %"
            )
    for place in np.flatnonzero(log.intervals() > mapping.max_gap)[:1].tolist():
        gap, line = log.intervals()[place], log.lines[place + 1]
        raise BagError(f"{path}:{line}: {gap:.4g} s without a row; the map allows {mapping.max_gap:g} s")
    for topic, (labels, values) in log.values.items():
        if topic != JOY:
            continue
        for row, number in np.argwhere(~(np.abs(values) <= 1.0)).tolist()[:1]:
            told = "empty" if math.isnan(values[row, number]) else f"{values[row, number]:g}"
            raise BagError(f"{path}:{log.lines[row]}: {labels[number]} is {told}; allowed: -1 .. 1")


def _cells(path: Path, form: FileForm) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Column names, and rows with their line numbers; without empty lines and those that begin with #."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(_rows(file, form))
    except (UnicodeDecodeError, csv.Error) as error:
        raise BagError(f"{path} cannot be read as CSV: {error}") from error
    if not rows:
        raise BagError(f"{path} is empty; allowed: a header and rows")
    width = len(rows[0][1])
    names = [cell.strip() for cell in rows.pop(0)[1]] if form.header else [str(n + 1) for n in range(width)]
    for line, cells in rows:
        if len(cells) != width:
            raise BagError(f"{path}:{line}: {len(cells)} cells; allowed: {width}, as in the first row")
    return names, rows


def _rows(file: Iterator[str], form: FileForm) -> Iterator[tuple[int, list[str]]]:
    for _ in range(form.skip):
        next(file, None)
    lines = list(file)
    first = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    delimiter = form.delimiter or max(SNIFFED, key=first.count)
    if delimiter == form.decimal:
        delimiter = ";"
    reader = csv.reader(lines, delimiter=delimiter)
    for cells in reader:
        if any(cell.strip() for cell in cells) and not cells[0].startswith("#"):
            yield reader.line_num + form.skip, cells


def _number(cell: str, form: FileForm, where: str) -> float:
    text = cell.strip()
    if text.lower() in EMPTY:
        return math.nan
    try:
        value = float(text.replace(form.decimal, "."))
    except ValueError:
        value = math.inf
    if math.isinf(value):
        raise BagError(f"{where} is {cell!r}; allowed: a number, or nothing")
    return value
