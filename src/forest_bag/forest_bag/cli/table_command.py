"""`forest-bag to-csv` and `to-parquet`: a bag's numbers as one table, joined on stamps, with units."""

import argparse
import csv
import sys
from pathlib import Path
from typing import TextIO

import numpy as np

from forest_bag.convert.table import Table, joined
from forest_bag.storage.bag_files import BagError
from forest_msgs_py.runtime.command_line import Command, Subcommands, output_file
from forest_msgs_py.types import NS_PER_S

BLOCK = 4096  # rows formatted at once


def add_parser(verbs: Subcommands) -> None:
    """Add both verbs and their flags."""
    csv_parser = _add(verbs, "to-csv", "write a bag's numbers as one CSV table", to_csv)
    csv_parser.add_argument(
        "-o",
        "--output",
        type=output_file(),
        metavar="FILE",
        help="CSV file to be made (default: standard output)",
    )
    parquet = _add(verbs, "to-parquet", "write a bag's numbers as one Parquet table", to_parquet)
    parquet.add_argument(
        "-o",
        "--output",
        type=output_file(),
        metavar="FILE",
        help="Parquet file to be made (default: BAG.parquet)",
    )


def _add(
    verbs: Subcommands,
    name: str,
    text: str,
    command: Command,
) -> argparse.ArgumentParser:
    parser = verbs.add_parser(
        name,
        help=text,
        description=f"{text[0].upper()}{text[1:]}, a row for each stamp of any topic; "
        "a topic without a message there has empty cells.",
    )
    parser.set_defaults(command=command)
    parser.add_argument("bag", type=Path, metavar="BAG", help="directory, .mcap or .db3 file")
    parser.add_argument(
        "--topics", nargs="+", default=[], metavar="TOPIC", help="topics to use (default: all)"
    )
    parser.add_argument("--hold", action="store_true", help="fill empty cells with the topic's last values")
    parser.add_argument(
        "--at",
        default="",
        metavar="TOPIC",
        help="write rows at this topic's stamps only; the other topics are held",
    )
    return parser


def to_csv(options: argparse.Namespace) -> int:
    """Write a CSV; return the exit code."""
    if options.output is None:
        _write_csv(_table(options), sys.stdout)
        return 0
    _refuse_existing(options.output)
    table = _table(options)
    with options.output.open("x", encoding="utf-8", newline="") as file:
        _write_csv(table, file)
    return 0


def to_parquet(options: argparse.Namespace) -> int:
    """Write a Parquet file; return the exit code."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise BagError(
            "to-parquet needs pyarrow; allowed: pip install 'forest-crane[parquet]', or to-csv"
        ) from None
    output = options.output or options.bag.parent / f"{options.bag.resolve().name}.parquet"
    _refuse_existing(output)
    table = _table(options)
    seconds = (table.stamps_ns - table.stamps_ns[0]) / NS_PER_S
    arrays = [pyarrow.array(table.stamps_ns), pyarrow.array(seconds)]
    fields = [
        _field(pyarrow, "stamp", "ns", pyarrow.int64()),
        _field(pyarrow, "time", "s", pyarrow.float64()),
    ]
    for column in table.columns:
        arrays.append(pyarrow.array(column.values, mask=np.isnan(column.values)))
        fields.append(_field(pyarrow, column.name, column.unit, pyarrow.float64()))
    parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields)), output)
    print(f"{output}: {len(table.stamps_ns)} rows, {len(fields)} columns")
    return 0


def _field(pyarrow: object, name: str, unit: str, kind: object) -> object:
    header = f"{name}[{unit}]" if unit else name
    return pyarrow.field(header, kind, metadata={"unit": unit})  # type: ignore[attr-defined]


def _table(options: argparse.Namespace) -> Table:
    from forest_bag.read.timeseries import read_bag

    bag = read_bag(options.bag, set(options.topics) | {options.at} if options.topics else None)
    table = joined(bag, options.topics, options.at, options.hold)
    notes = (
        table.notes
        if bag.complete
        else ["the bag is damaged: the table has what is whole of it", *table.notes]
    )
    for note in notes:
        print(f"forest-bag: {note}", file=sys.stderr)
    return table


def _write_csv(table: Table, file: TextIO) -> None:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["stamp[ns]", "time[s]", *(column.header for column in table.columns)])
    values = np.column_stack([column.values for column in table.columns])
    first = int(table.stamps_ns[0])
    for start in range(0, len(values), BLOCK):
        stamps = table.stamps_ns[start : start + BLOCK].tolist()
        for stamp, row in zip(stamps, values[start : start + BLOCK].tolist(), strict=True):
            cells = ["" if value != value else repr(value) for value in row]
            writer.writerow([stamp, repr((stamp - first) / NS_PER_S), *cells])


def _refuse_existing(output: Path) -> None:
    if output.exists():
        raise BagError(f"{output} exists; allowed: a file to be made")
