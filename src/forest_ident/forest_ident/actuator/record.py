"""Read and check records of an actuator, `sample,valve,pressure,position` in a CSV file, and their scales.

| symbol | name |
|---|---|
| V, P, X | what the record's units are of those in which the priors stand (`Scales`) |
"""

import csv
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_description.types import Floats

LEAST = 60  # samples of a record that anything is fitted to
SPANS = (2.5, 7.3, 2.25)  # of valve, pressure and position in the units of `actuator_priors`


MEASURED = ("valve", "pressure", "position")


class RecordError(Exception):
    """A record cannot be used: the sentence names file, line and column."""


class Record(NamedTuple):
    """Columns of a file; None: the column is missing, or holds no number."""

    path: Path
    samples: NDArray[np.int64]
    valve: Floats
    pressure: Floats | None
    position: Floats | None


class Scales(NamedTuple):
    """The record's units: a signal of `valve` is 1 V, and so on; `pressure_zero` is read at rest."""

    valve: float  # negative if the valve's positive side retracts
    pressure: float
    position: float
    pressure_zero: float
    position_zero: float


def read(path: Path, whole: bool = True) -> Record:
    """Return a file's columns.

    Args:
        path: the CSV file; other columns than the four are ignored.
        whole: whether pressure and position must be there, too.

    Raises:
        RecordError: a column is missing, something is no number, or samples are left out.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise RecordError(f"{path} is no text (UTF-8), but should be a CSV file") from error
    rows = csv.DictReader(text.splitlines())
    head = [name.strip().lower() for name in rows.fieldnames or ()]
    rows.fieldnames = head
    wanted = ("sample", "valve", *(("pressure", "position") if whole else ()))
    missing = [name for name in wanted if name not in head]
    if missing:
        had = ", ".join(head) or "nothing"
        allowed = f"a head with {', '.join(wanted)}, columns separated by commas"
        raise RecordError(
            f"{path}, line 1: column {missing[0]!r} is missing; the head names {had}; allowed: {allowed}"
        )
    twice = [name for name in wanted if head.count(name) > 1]
    if twice:
        raise RecordError(f"{path}, line 1: column {twice[0]!r} stands there twice; allowed: each once")
    body = [Row(path, rows.line_num, row) for row in rows if any(_text(item) for item in row.values())]
    if not body:
        raise RecordError(f"{path} has a head but no samples")
    columns = {
        name: np.array([row.number(name) for row in body])
        for name in head
        if name in MEASURED and (name in wanted or not any(row.is_empty(name) for row in body))
    }
    return Record(
        path=path,
        samples=_samples(body),
        valve=columns["valve"],
        pressure=columns.get("pressure"),
        position=columns.get("position"),
    )


def _text(item: Any) -> str:
    return item.strip() if isinstance(item, str) else ""


class Row(NamedTuple):
    """A line of a file."""

    path: Path
    line: int
    items: dict[str, Any]  # of a column that the line does not reach: None

    def is_empty(self, name: str) -> bool:
        """Tell whether a column is empty or NaN here."""
        return _text(self.items[name]).lower() in ("", "nan")

    def number(self, name: str) -> float:
        """Return the finite number in a column.

        Raises:
            RecordError: there is none.
        """
        if self.items[name] is None:
            raise RecordError(f"{self.path}, line {self.line}: ends before column {name!r}")
        item = _text(self.items[name])
        try:
            value = float(item)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise RecordError(f"{self.path}, line {self.line}, column {name!r}: {item!r} is no finite number")
        return value


def _samples(body: list[Row]) -> NDArray[np.int64]:
    """Return the numbers of the samples, which must be whole and follow each other."""
    found: list[int] = []
    for row in body:
        value, item = row.number("sample"), _text(row.items["sample"])
        place = f"{row.path}, line {row.line}, column 'sample'"
        if value != round(value):
            raise RecordError(f"{place}: {item!r} is no whole number")
        if found and round(value) != found[-1] + 1:
            raise RecordError(
                f"{place}: {item} does not follow {found[-1]}; samples must be one apart, none left out"
            )
        found.append(round(value))
    return np.array(found, dtype=np.int64)


def scales(record: Record) -> Scales:
    """Return the units of a record that is fitted to; its first sample counts as rest.

    Raises:
        RecordError: there are too few samples, or a column does not change.
    """
    if len(record.samples) < LEAST:
        raise RecordError(f"{record.path} has {len(record.samples)} samples; a fit needs at least {LEAST}")
    assert record.pressure is not None
    assert record.position is not None
    spans = []
    columns = (record.valve, record.pressure, record.position)
    for name, column, span in zip(MEASURED, columns, SPANS, strict=True):
        spans.append(float(np.ptp(column)) / span)
        if spans[-1] <= 0.0:
            raise RecordError(f"{record.path}, column {name!r}: does not change, which tells nothing")
    speed = np.diff(record.position)
    side = -1.0 if float(speed @ record.valve[:-1]) < 0.0 else 1.0
    return Scales(
        valve=side * spans[0],
        pressure=spans[1],
        position=spans[2],
        pressure_zero=float(record.pressure[0]),
        position_zero=float(record.position[0]),
    )
