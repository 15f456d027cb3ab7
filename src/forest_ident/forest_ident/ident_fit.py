"""`forest-ident fit`: bags in, machine file and report out."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

from forest_description.machine import load_machine
from forest_ident import identification, machine_writer, session_bag
from forest_ident.result import Result, table
from forest_ident.session import SessionError
from forest_ident.untold import untold

WIDTH = 30  # characters of the progress bar


def add_parser(verbs: Any) -> None:
    """Name the verb's flags."""
    text = "estimate a machine's parameters from bags, with their uncertainty"
    parser = verbs.add_parser("fit", help=text, description=text[0].upper() + text[1:] + ".")
    parser.set_defaults(command=run)
    parser.add_argument("bags", nargs="+", type=Path, metavar="BAG", help="a bag, or a directory of bags")
    parser.add_argument("--start", default="c180", metavar="NAME|FILE", help="default: %(default)s")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.yaml", help="identified machine")
    parser.add_argument("--report", type=Path, metavar="DIR", help="to be made: report.html")
    parser.add_argument(
        "--linear", action="store_true", help="the thesis' estimators alone, without refinement"
    )


def run(options: argparse.Namespace) -> int:
    """Run the verb; return its exit code.

    Raises:
        SessionError: a bag is not usable, or nothing can be estimated from them.
    """
    if options.out.suffix != ".yaml":
        raise SessionError(f"--out {options.out}: allowed: a file that ends in .yaml")
    if options.report is not None and options.report.exists():
        raise SessionError(f"{options.report} exists already; choose another --report or remove it")
    start = load_machine(options.start)
    sessions = [session_bag.read(path) for path in found(options.bags)]
    bar = Bar()
    result = identification.identify(start, sessions, bar, refine=not options.linear)
    bar.end()
    if not result.estimates:
        names = ", ".join(session.name for session in sessions)
        raise SessionError(f"nothing can be estimated from {names}; record some of the experiments first")
    options.out.parent.mkdir(parents=True, exist_ok=True)
    result.machine = machine_writer.write(result, options.start, options.out)
    print(text_table(result))
    for remark in result.remarks:
        print(f"  remark: {remark}")
    for key, motion in untold(result):
        print(f"  not told by these records, left as it was: {key}; it takes {motion}")
    print(f"  {options.out}")
    if options.report is not None:
        from forest_ident.report import write  # matplotlib takes half a second

        print(f"  {write(result, options.report)}")
    return 0


def found(paths: list[Path]) -> list[Path]:
    """Return the bags that some paths name: themselves, or those in a directory of bags.

    Raises:
        SessionError: there is no bag at a path.
    """
    bags: list[Path] = []
    for path in paths:
        inside = sorted(child for child in path.iterdir() if _is_bag(child)) if path.is_dir() else []
        if _is_bag(path):
            bags.append(path)
        elif inside:
            bags.extend(inside)
        else:
            raise SessionError(f"{path}: no bag there; allowed: a bag, an .mcap file or a directory of bags")
    return bags


def _is_bag(path: Path) -> bool:
    return (path.is_file() and path.suffix == ".mcap") or (path.is_dir() and any(path.glob("*.mcap")))


def text_table(result: Result) -> str:
    """Return what was found as text: old, new, interval, warning."""
    lines = [f"  {'parameter':<42} {'told':>11} {'found':>11}  95 % interval"]
    for e, told in table(result):
        low, high = e.interval
        was = "-" if told is None else f"{told:.5g}"
        lines.append(f"  {e.key:<42} {was:>11} {e.value:>11.5g}  {low:.5g} .. {high:.5g} {e.unit}")
        if e.warning:
            lines.append(f"    warning: {e.warning}")
    return "\n".join(lines)


class Bar:
    """A progress bar on standard error: rewritten on a terminal, a line every ten seconds elsewhere."""

    def __init__(self) -> None:
        self._began = time.monotonic()
        self._terminal = sys.stderr.isatty()
        self._next = self._began + (0.0 if self._terminal else 10.0)

    def __call__(self, text: str, share: float) -> None:
        """Tell what is being done and which share is done."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + (0.1 if self._terminal else 10.0)
        filled = round(WIDTH * share)
        left = f", {(now - self._began) * (1.0 - share) / share:.0f} s left" if share > 0.02 else ""
        line = f"  [{'#' * filled}{'.' * (WIDTH - filled)}] {100.0 * share:3.0f} %{left}, {text}"
        print(f"{line:<100}", end="\r" if self._terminal else "\n", file=sys.stderr, flush=True)

    def end(self) -> None:
        """Clear the bar."""
        if self._terminal:
            print(" " * 100, end="\r", file=sys.stderr, flush=True)
