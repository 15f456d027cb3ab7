"""Rows of numbers over time from a CSV file that a person wrote."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple


class CsvColumn(NamedTuple):
    """A column: its name in the header, and the numbers that it may hold."""

    name: str
    low: float  # inclusive
    high: float
    unit: str = ""  # told in messages


def read_rows(path: Path, columns: Sequence[CsvColumn], error: type[ValueError]) -> list[list[float]]:
    """Return the numbers of a CSV file, a list for each row.

    Args:
        path: of the file.
        columns: in the order of the header. The first is the time, which rises from row to row.
        error: raised with one sentence that names file, line and what is allowed.

    Raises:
        ValueError: `error`; the file cannot be read, or a line does not fit.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:  # spreadsheets begin with a byte order mark
            reader = csv.reader(file)
            (top, header), *rows = [(reader.line_num, row) for row in reader if row] or [(1, ["nothing"])]
    except (OSError, UnicodeDecodeError, csv.Error) as cause:
        raise error(f"{path}: cannot be read as CSV: {cause}") from cause
    names = [column.name for column in columns]
    if [cell.strip() for cell in header] != names:
        raise error(f"{path}:{top}: the header must be {','.join(names)}, found {','.join(header)}")
    if not rows:
        raise error(f"{path}:{top}: no rows below the header; allowed: one or more")
    numbers = [_numbers(f"{path}:{line}", row, columns, error) for line, row in rows]
    for (line, _), (before, after) in zip(rows[1:], pairwise(numbers), strict=True):
        if after[0] <= before[0]:
            times = f"{names[0]} is {after[0]:g} after {before[0]:g}"
            raise error(f"{path}:{line}: {times}; times must rise")
    return numbers


def _numbers(
    where: str, row: list[str], columns: Sequence[CsvColumn], error: type[ValueError]
) -> list[float]:
    if len(row) != len(columns):
        raise error(f"{where}: {len(row)} columns; allowed are the {len(columns)} of the header")
    values = []
    for cell, column in zip(row, columns, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not column.low <= value <= column.high:  # false for NaN as well
            allowed = f"{column.low:g} .. {column.high:g} {column.unit}".rstrip()
            raise error(f"{where}: {column.name} is {cell!r}; allowed: {allowed}")
        values.append(value)
    return values
