"""`forest-study diagnosis`: the monitor's false alarms and detections, from sweeps of kind `diagnosis`."""

import argparse
from pathlib import Path

from forest_study.diagnosis.diagnosis_report import draw, report, rows_of, table
from forest_study.results import new_directory, write_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    text = "sweeps of kind: diagnosis (docs/explanation/diagnosis.md)"
    parser.add_argument("sweeps", type=Path, nargs="+", metavar="SWEEP", help=text)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        StudyError: a sweep is not usable, or the directory is not empty.
    """
    rows = rows_of(options.sweeps)
    new_directory(options.out)
    found = report(rows)
    write_json(options.out / "diagnosis.json", found)
    text = table(found)
    (options.out / "diagnosis.md").write_text(text + "\n", encoding="utf-8")
    draw(rows, options.out / "roc.png")
    print(text)
    return 0
