"""Numbers over time from a CSV file that somebody else wrote; a problem is named with its line."""

import csv
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple


class Column(NamedTuple):
    """A column of the file, and the lowest and highest number in it."""

    name: str
    low: float
    high: float
    unit: str = ""


def read_rows(path: Path, columns: Sequence[Column], error: type[Exception]) -> list[list[float]]:
    """Return the numbers of all rows.

    Args:
        path: of the file.
        columns: all that the header names, in its order; the first is the time, which must rise.
        error: raised with one sentence where the file cannot be read, or a line does not fit.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:  # spreadsheets put a byte order mark there
            reader = csv.reader(file)
            header, *rows = [(reader.line_num, row) for row in reader if row] or [(1, ["nothing"])]
    except (OSError, UnicodeDecodeError, csv.Error) as problem:
        raise error(f"{path}: cannot be read as CSV: {problem}") from problem
    names = [column.name for column in columns]
    if [cell.strip() for cell in header[1]] != names:
        found = ",".join(header[1])
        raise error(f"{path}:{header[0]}: the header must be {','.join(names)}, found {found}")
    if not rows:
        raise error(f"{path}:{header[0]}: no rows below the header; allowed: one or more")
    numbers = []
    for line, row in rows:
        if len(row) != len(columns):
            raise error(f"{path}:{line}: {len(row)} columns; allowed are the {len(columns)} of the header")
        numbers.append([_number(f"{path}:{line}", *pair, error) for pair in zip(columns, row, strict=True)])
    for (line, _), (before, after) in zip(rows[1:], pairwise(numbers), strict=True):
        if after[0] <= before[0]:
            raise error(f"{path}:{line}: {names[0]} is {after[0]:g} after {before[0]:g}; times must rise")
    return numbers


def _number(place: str, column: Column, cell: str, error: type[Exception]) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not column.low <= value <= column.high:  # false for NaN as well
        allowed = f"{column.low:g} .. {column.high:g} {column.unit}".rstrip()
        raise error(f"{place}: {column.name} is {cell!r}; allowed: {allowed}")
    return value
