"""`forest-ident fit`: bags in, machine file and report out."""

import argparse
import itertools
import sys
import time
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np

from forest_bag.read.bag_reader import FILE_KINDS, SUFFIXES
from forest_description.machine import Machine, load_machine, uncertainties
from forest_ident.cli import driving_fit, fit_tables
from forest_ident.experiments import experiment_plan
from forest_ident.measurements import session_bag
from forest_ident.measurements.session import Session, SessionError
from forest_ident.model_choice import candidates, choice
from forest_ident.refinement import identification
from forest_ident.refinement.result import Result, unidentified
from forest_ident.report import machine_writer
from forest_ident.validation import prediction_error
from forest_ident.validation.verdict import verdict
from forest_msgs_py.runtime.command_line import StatusLine, Subcommands, subcommand

WIDTH = 30  # characters of the progress bar


def add_parser(verbs: Subcommands) -> None:
    """Name the verb's flags."""
    text = "estimate a machine's parameters from bags, with their uncertainty"
    parser = subcommand(verbs, "fit", text, run)
    parser.add_argument("bags", nargs="+", type=Path, metavar="BAG", help="bag, or directory of bags")
    parser.add_argument(
        "--start",
        default="c180_hoses",
        metavar="NAME|FILE",
        help="machine that the search starts from (default: %(default)s)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="FILE.yaml",
        help="machine file to be written, with the estimates",
    )
    parser.add_argument("--report", type=Path, metavar="DIR", help="directory to be made, with report.html")
    help_truth = "true machine of a simulated record: shown beside the estimates, never used"
    parser.add_argument("--truth", metavar="NAME|FILE", help=help_truth)
    help_allow = "physics to add to the start; kept if held-out records are predicted better"
    parser.add_argument(
        "--allow", nargs="+", choices=candidates.NAMES, default=(), metavar="PHYSICS", help=help_allow
    )
    help_driving = "the bags hold everyday work instead of experiments: tell what has drifted from the start"
    parser.add_argument(driving_fit.OPTION, action="store_true", help=help_driving)
    parser.add_argument(
        "--linear", action="store_true", help="use the thesis' linear estimators alone, without refinement"
    )


def run(options: argparse.Namespace) -> int:
    """Run the verb; return its exit code.

    Raises:
        SessionError: a bag is not usable, or nothing can be estimated from them.
    """
    _demand_room(options.out, options.report)
    _refuse_start(options.start, options.out)
    start = load_machine(options.start)
    truth = None if options.truth is None else load_machine(options.truth)
    if options.from_driving:
        driving_fit.refuse_options(options)
    sessions = {path: session_bag.read(path) for path in found(options.bags)}
    _refuse_twice(sessions)
    if options.from_driving:
        return driving_fit.run(options, sessions, start, truth, Bar())
    _refuse_strangers(start, sessions)
    _demand_judge(options.allow, sessions)
    result = _fitted(start, sessions, options)
    held_out = [(s.name, prediction_error.predicted(result.machine, s)) for s in result.held_out]
    judged = verdict(result, held_out)
    print("\n  ".join([f"verdict: {judged.lines[0]}", *judged.lines[1:]]))
    print(fit_tables.text_table(result))
    for name, signals in held_out:
        print(f"  held out: {name}\n{prediction_error.text_table(signals)}")
    result.machine = machine_writer.write(result, options.start, options.out, judged.doubts)
    if truth is not None:
        print(fit_tables.against(result, truth))
    _tell_rest(result, sessions)
    print(f"  {options.out}")
    if options.report is not None:
        from forest_ident.report.identification_report import write  # matplotlib takes half a second

        bags = {str(path): session.name for path, session in sessions.items()}
        print(f"  {write(result, options.report, judged, held_out, options.start, bags)}")
    return judged.code


def _fitted(start: Machine, sessions: Mapping[Path, Session], options: argparse.Namespace) -> Result:
    """Return what the records tell, once for each physics that is tried.

    Raises:
        SessionError: nothing can be estimated from them.
    """
    bar = Bar()
    given, stated = list(sessions.values()), uncertainties(options.start)
    rounds, ended = 1 + len(options.allow), itertools.count()

    def identify(machine: Machine) -> Result:
        before = next(ended)

        def told(text: str, share: float) -> None:
            bar(text, (before + share) / rounds)

        return identification.identify(machine, given, told, not options.linear, stated)

    result = choice.chosen(start, identify, options.allow)
    bar.end()
    if not (result.estimates or result.calibration):
        said = "".join(f"; {remark}" for remark in result.remarks)
        names = ", ".join(session.name for session in sessions.values())
        raise SessionError(
            f"nothing for a machine file from {names}{said}; `forest-ident experiment list` tells which "
            "records hold something"
        )
    return result


def _tell_rest(result: Result, sessions: dict[Path, Session]) -> None:
    for remark in result.remarks:
        print(f"  remark: {remark}")
    for path, session in sessions.items():
        if session.name in identification.HELD_OUT:
            print(f"  held out, not used: {path} ({session.name})")
    for key, motion in unidentified(result):
        print(f"  not identifiable from these records, unchanged: {key}; it takes {motion}")


def _demand_room(out: Path, report: Path | None) -> None:
    """Refuse before the fit where its result could not be written.

    Raises:
        SessionError: a file or directory is there already, or cannot be made.
    """
    if out.suffix != ".yaml":
        raise SessionError(f"--out {out}: allowed: a file that ends in .yaml")
    for option, path in (("--out", out), ("--report", report)):
        if path is None or _is_own(path):
            continue
        if path.exists():
            raise SessionError(f"{path} exists already; choose another {option} or remove it")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
            path.unlink()
        except OSError as error:
            raise SessionError(
                f"{option} {path}: cannot be written ({error.strerror}); allowed: a folder you may write to"
            ) from error


def _refuse_start(start: str, out: Path) -> None:
    """Refuse to write over the start: what is written is based on it.

    Raises:
        SessionError: both are one file.
    """
    if Path(start).suffix and Path(start).resolve() == out.resolve():
        raise SessionError(f"--out {out}: it is the start, and is based on it; allowed: another file")


def _is_own(path: Path) -> bool:
    """Tell whether a path is what an earlier fit wrote, which a second run may make anew."""
    if path.is_dir():
        return [child.name for child in path.iterdir()] == ["report.html"]
    return path.is_file() and path.read_text("utf-8", errors="replace").startswith(machine_writer.OWN)


def _refuse_strangers(start: Machine, sessions: dict[Path, Session]) -> None:
    """Refuse records of experiments that a machine has not.

    Raises:
        SessionError: there is one; the message names those it has.
    """
    known = tuple(dict.fromkeys((*experiment_plan.names(start), *identification.HELD_OUT)))
    for path, session in sessions.items():
        if session.name not in known:
            raise SessionError(
                f"{path}: {start.name} has no experiment {session.name!r}; allowed: {', '.join(known)}; "
                "another machine's records take another --start"
            )


def _refuse_twice(sessions: dict[Path, Session]) -> None:
    """Refuse a record that comes twice: its errors would be taken for independent ones.

    Raises:
        SessionError: two bags hold the same.
    """
    for (one, first), (two, second) in combinations(sessions.items(), 2):
        same = first.name == second.name and first.readings.keys() == second.readings.keys()
        if same and all(np.array_equal(first.readings[key], second.readings[key]) for key in first.readings):
            raise SessionError(f"{one} and {two} hold the same record of {first.name}; allowed: each once")


def _demand_judge(allowed: Sequence[str], sessions: dict[Path, Session]) -> None:
    """Refuse before the fit to choose between models without a record to judge them by.

    Raises:
        SessionError: physics are allowed, but no record is held out.
    """
    if allowed and not any(session.name in identification.HELD_OUT for session in sessions.values()):
        raise SessionError(
            f"--allow {' '.join(allowed)}: no record is held out to decide by; allowed: with a bag of "
            "`validation`"
        )


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
            raise SessionError(f"{path}: no bag there; allowed: {FILE_KINDS}, or a directory of bags")
    return bags


def _is_bag(path: Path) -> bool:
    if path.is_dir():
        return any(child.is_file() and child.name.endswith(SUFFIXES) for child in path.iterdir())
    return path.is_file() and path.name.endswith(SUFFIXES)


class Bar:
    """A progress bar on standard error: rewritten on a terminal, a line every ten seconds elsewhere."""

    def __init__(self) -> None:
        self._began, self._line = time.monotonic(), StatusLine(sys.stderr)
        self._next = self._began + (0.0 if self._line.terminal else 10.0)

    def __call__(self, text: str, share: float) -> None:
        """Tell what is being done and which share is done."""
        now = time.monotonic()
        if share == 0.0:  # what comes before the simulations tells nothing of their pace
            self._began = now
        if now < self._next:
            return
        self._next = now + (0.1 if self._line.terminal else 10.0)
        filled = round(WIDTH * share)
        left = f", {(now - self._began) * (1.0 - share) / share:.0f} s left" if share > 0.02 else ""
        self._line.show(f"  [{'#' * filled}{'.' * (WIDTH - filled)}] {100.0 * share:3.0f} %{left}, {text}")

    def end(self) -> None:
        """Leave the bar as it is, and go to the next line."""
        self._line.end()
