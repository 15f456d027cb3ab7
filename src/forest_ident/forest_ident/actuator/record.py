"""Records of an actuator: `sample,valve,pressure,position` in a CSV file, read, checked and brought to scale.

| symbol | name |
|---|---|
| V, P, X | what the record's units are of those in which the priors stand (`Scales`) |
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_description.types import Floats

LEAST = 60  # samples of a record that anything is fitted to
SPANS = (2.5, 7.3, 2.25)  # of valve, pressure and position in the units of `actuator_priors`


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
        path: the CSV file; columns beside the four are not looked at.
        whole: whether pressure and position must be there, too.

    Raises:
        RecordError: a column is missing, something is no number, or samples are left out.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise RecordError(f"{path} is no text (UTF-8), but should be a CSV file") from error
    rows = csv.reader(text.splitlines())
    head = [name.strip().lower() for name in next(rows, [])]
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
    body = [(rows.line_num, row) for row in rows if any(item.strip() for item in row)]
    if not body:
        raise RecordError(f"{path} has a head but no samples")
    samples = _samples(path, [(line, _item(path, line, row, head, "sample")) for line, row in body])
    columns = {name: _column(path, head, body, name, name in wanted) for name in head if name in _MEASURED}
    valve = columns["valve"]
    assert valve is not None
    return Record(
        path=path,
        samples=samples,
        valve=valve,
        pressure=columns.get("pressure"),
        position=columns.get("position"),
    )


_MEASURED = ("valve", "pressure", "position")


def _item(path: Path, line: int, row: list[str], head: list[str], name: str) -> str:
    place = head.index(name)
    if place >= len(row):
        raise RecordError(f"{path}, line {line}: ends before column {name!r}")
    return row[place].strip()


def _samples(path: Path, items: list[tuple[int, str]]) -> NDArray[np.int64]:
    found: list[int] = []
    for line, item in items:
        value = _number(path, line, "sample", item)
        if value != round(value):
            raise RecordError(f"{path}, line {line}, column 'sample': {item!r} is no whole number")
        if found and round(value) != found[-1] + 1:
            raise RecordError(
                f"{path}, line {line}, column 'sample': {item} does not follow {found[-1]}; "
                "samples must be one apart, none left out"
            )
        found.append(round(value))
    return np.array(found, dtype=np.int64)


def _column(
    path: Path, head: list[str], body: list[tuple[int, list[str]]], name: str, needed: bool
) -> Floats | None:
    """Return a column; None if it is not needed and empty or NaN somewhere."""
    values = []
    for line, row in body:
        if not needed and (head.index(name) >= len(row) or _blank(row[head.index(name)])):
            return None
        values.append(_number(path, line, name, _item(path, line, row, head, name)))
    return np.array(values)


def _blank(item: str) -> bool:
    return item.strip().lower() in ("", "nan")


def _number(path: Path, line: int, name: str, item: str) -> float:
    try:
        value = float(item)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RecordError(f"{path}, line {line}, column {name!r}: {item!r} is no finite number")
    return value


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
    for name, column, span in zip(
        _MEASURED, (record.valve, record.pressure, record.position), SPANS, strict=True
    ):
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
