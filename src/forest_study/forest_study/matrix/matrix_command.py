"""`forest-study matrix`: seeded plants that nobody knows exactly, row by row; the worst seed counts."""

import argparse
from typing import Any

from forest_description.machine import load_machine
from forest_msgs_py.runtime.command_line import whole
from forest_study.matrix.matrix_rows import FACTORS, apart, matrix_rows
from forest_study.matrix.matrix_runs import run_row
from forest_study.matrix.rivals import RIVALS
from forest_study.results import new_directory, require_llvm, write_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add, rows = parser.add_argument, matrix_rows()
    add(
        "--seeds",
        type=whole(1, 1000),
        default=10,
        metavar="N",
        help="plants of each row (default: %(default)s)",
    )
    add(
        "--seed", type=whole(0), default=0, metavar="N", help="seed of the first plant (default: %(default)s)"
    )
    add(
        "--machine",
        default="c180",
        help="machine file of the controller, around which plants are drawn (default: %(default)s)",
    )
    add("--row", nargs="+", choices=tuple(rows), metavar="NAME", help=f"{', '.join(rows)} (default: all)")
    add("--only", nargs="+", choices=FACTORS, default=(), metavar="FACTOR", help="vary only these factors")
    add(
        "--without",
        nargs="+",
        choices=FACTORS,
        default=(),
        metavar="FACTOR",
        help="vary all factors but these",
    )
    add(
        "--laps",
        type=whole(1, 20),
        default=1,
        metavar="N",
        help="laps, of which the last is judged (default: %(default)s)",
    )
    add(
        "--scheme",
        nargs="+",
        choices=tuple(RIVALS),
        default=["coordinated"],
        metavar="NAME",
        help=f"control laws, one after the other: {', '.join(RIVALS)} (default: coordinated)",
    )
    learns = "the valve driver learns deadbands and gains on the way (default: it does)"
    add("--adapt", action=argparse.BooleanOptionalAction, default=True, help=learns)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        PathError: a path leaves the machine's reach.
        MachineError: the machine's file cannot be read, or lacks what is drawn.
        StudyError: LLVM is not installed.
    """
    new_directory(options.out)
    require_llvm("matrix")
    from forest_study.matrix.matrix_report import draw, table, told  # matplotlib takes half a second

    machine, rows = load_machine(options.machine), matrix_rows()
    seeds, report = range(options.seed, options.seed + options.seeds), dict[str, Any]()
    chosen = [rows[name] for name in options.row or rows]
    for row in (each for one in chosen for each in apart(one, options.only, options.without)):
        for name in options.scheme:
            key = row.name if name == "coordinated" else f"{row.name}, {name}"
            print(f"{key}: {row.text}", flush=True)
            outcomes = run_row(row, machine, seeds, options.adapt, options.laps, RIVALS[name])
            report[key] = told(row, outcomes)
    protocol = {"machine": machine.name, "adapt": options.adapt, "laps": options.laps}
    whole_report = {**protocol, "rows": report}
    write_json(options.out / "matrix.json", whole_report)
    text = table(report)
    (options.out / "matrix.md").write_text(text + "\n", encoding="utf-8")
    draw(report, options.out / "matrix.png")
    print(text)
    print(f"  {options.out / 'matrix.json'}")
    return 0
