"""`forest-ident fit --from-driving`: what bags of everyday work tell of a machine that is known already."""

import argparse
import itertools
from collections.abc import Collection, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Protocol

import numpy as np

from forest_description.machine import Machine, uncertainties
from forest_description.types import AXES
from forest_ident.cli import fit_tables
from forest_ident.estimators import calibration
from forest_ident.everyday import coverage, drift, numbers, segment_fit
from forest_ident.everyday.segment_fit import Found
from forest_ident.everyday.segments import Segment, cut
from forest_ident.measurements.session import Session, SessionError
from forest_ident.model_choice.held_out_comparison import compare
from forest_ident.refinement import experiment_check
from forest_ident.refinement.identification import HELD_OUT
from forest_ident.refinement.result import told_table
from forest_ident.report import machine_writer
from forest_ident.validation import prediction_error
from forest_ident.validation.verdict import NOT_TRUSTED, Verdict

OPTION = "--from-driving"
FEWEST = 6  # segments: fewer show no scatter between them, and leave none to judge by
STRANGE = 10.0  # times the limit of a prediction, and after the fit: no machine like the start
SIMULATIONS, UNENDED = 200.0, 0.25  # that a fit takes, about; of those done, that are left until it ends


class Progress(Protocol):
    """A progress bar."""

    def __call__(self, text: str, share: float) -> None:
        """Tell what is being done and which share is done."""

    def end(self) -> None:
        """Nothing more is simulated."""


def run(
    options: argparse.Namespace,
    sessions: Mapping[Path, Session],
    start: Machine,
    truth: Machine | None,
    progress: Progress,
) -> int:
    """Run `fit` on bags of everyday work; return its exit code.

    Args:
        options: of `fit`.
        sessions: by bag, in order of time.
        start: the machine as known until then.
        truth: of a simulated record: shown beside the estimates.
        progress: of the simulations.

    Raises:
        SessionError: the bags hold no work that can be fitted, or another machine's.
    """
    for path, session in sessions.items():
        _demand_work(start, path, session)
    parts = cut(start, {str(path): session for path, session in sessions.items()})
    if len(parts.segments) < FEWEST:
        raise SessionError(
            f"{_names(sessions)}: {len(parts.segments)} motions that begin at rest with an empty head; "
            f"allowed: {FEWEST} or more ({'; '.join(parts.left_out)})"
        )
    chosen = coverage.chosen(start, parts.segments)
    found = _found(start, chosen.fitted, uncertainties(options.start), progress)
    told = drift.told(start, found, _method(found, sessions))
    signals = drift.held_out_signals(told.result.machine, chosen.held_out)
    _refuse_stranger(start, sessions, signals)
    gain = compare(start, told.result.machine, [one.session for one in chosen.held_out])
    judged = drift.verdict(told, found, signals, gain)
    print(_text(judged, told, gain.told()))
    print(f"  held out: {len(chosen.held_out)} segments\n{prediction_error.text_table(signals)}")
    machine_writer.write(told.result, options.start, options.out, _doubts(judged, told))
    if truth is not None:
        print(fit_tables.against(told.result, numbers.prepared(truth)))
    for text in [*parts.left_out, *chosen.left_out(), *found.left_out()]:
        print(f"  left out: {text}")
    print(f"  {options.out}")
    return judged.code


def _found(
    start: Machine, segments: Sequence[Segment], stated: Mapping[str, float], progress: Progress
) -> Found:
    """Return what segments say, read by calibrated sensors."""
    count = itertools.count(1)

    def simulated() -> None:
        done = next(count)
        left = max(SIMULATIONS - done, UNENDED * done)
        progress(f"{len(segments)} segments, simulation {done}", done / (done + left))

    corrected = [one._replace(session=calibration.corrected(one.session, start)) for one in segments]
    try:
        return segment_fit.found(numbers.prepared(start), corrected, stated, simulated)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        raise SessionError(
            f"{segments[0].bag} cannot be evaluated ({error}); allowed: work of {start.name}"
        ) from error
    finally:
        progress.end()


def _method(found: Found, bags: Collection[Path]) -> str:
    return f"everyday work, {found.segments} segments of {_names(bags)}, {date.today()}"


def _doubts(judged: Verdict, told: drift.Told) -> Mapping[str, str]:
    """Return why each number is doubtful: one and all where the whole is."""
    if judged.code == NOT_TRUSTED:
        return dict.fromkeys(told.result.estimates, judged.reasons[0])
    return judged.doubts


def _text(judged: Verdict, told: drift.Told, gain: str) -> str:
    """Return the verdict, what has drifted, and the table."""
    trusted = "drifted" if judged.code != NOT_TRUSTED else "drifted, if it could be trusted"
    gone = ", ".join(f"{row.estimate.key} {row.change}" for row in told.rows if row.drifted)
    lines = [
        "\n  ".join([f"verdict: {judged.lines[0]}", *judged.lines[1:]]),
        f"  {trusted}: {gone or 'nothing that these records tell'}",
        f"  {gain}",
        f"  {'parameter':<42} {'start':>11} {'found':>13} {'change':>12}  95 % interval",
    ]
    for row in told.rows:
        e = row.estimate
        value, low, high = e.formatted()
        mark = " drifted" if row.drifted else ""
        numbers_told = f"{row.start:>11.5g} {value:>13} {row.change:>12}"
        lines.append(f"  {e.key:<42} {numbers_told}  {low} .. {high} {e.unit}{mark}")
    for e, before in told_table(told.result):
        value, low, high = e.formatted()
        stated = f"{before or 0.0:>11.5g} {value:>13} {'(stated)':>12}"
        lines.append(f"  {e.key:<42} {stated}  {low} .. {high} {e.unit}")
    lines += [f"  remark: {remark}" for remark in told.result.remarks]
    return "\n".join(
        lines
        + [f"  these records cannot tell {key}, unchanged; it takes {motion}" for key, motion in told.untold]
    )


def _names(bags: Collection[Path]) -> str:
    names = [path.name for path in bags]
    return f"{names[0]} .. {names[-1]} ({len(names)} bags)" if len(names) > 1 else names[0]


def refuse_options(options: argparse.Namespace) -> None:
    """Refuse options that mean nothing without experiments.

    Raises:
        SessionError: there is one.
    """
    given = {"--linear": options.linear, "--allow": options.allow, "--report": options.report is not None}
    wrong = [name for name, value in given.items() if value]
    if wrong:
        raise SessionError(
            f"{OPTION} {' '.join(wrong)}: allowed: {OPTION} with --start, --out and --truth; the others take "
            "experiments"
        )


def _demand_work(start: Machine, path: Path, session: Session) -> None:
    """Refuse a bag that is no everyday work of this machine.

    Raises:
        SessionError: it is an experiment's, another machine's, or without angles or pressures.
    """
    if session.name not in HELD_OUT:
        raise SessionError(
            f"{path}: the experiment {session.name}; allowed with {OPTION}: bags of everyday work; without "
            "it, experiments"
        )
    missing = [f"{axis}'s angle" for axis in AXES if not session.has(f"{axis}_resolver")]
    if not session.has(*segment_fit.PORTS):
        missing.append("the pressures at the actuators")
    if missing:
        raise SessionError(
            f"{path}: without {', '.join(missing)}; allowed: bags with voltages, angles "
            "and pressures throughout"
        )
    try:
        experiment_check.demand_machine(start, session)
    except SessionError as error:
        raise SessionError(f"{path}: {str(error).removeprefix(f'{session.name}: ')}") from error


def _refuse_stranger(start: Machine, bags: Collection[Path], signals: list[prediction_error.Signal]) -> None:
    """Refuse bags that no machine near the start explains.

    Raises:
        SessionError: held-out segments are predicted far worse than any machine's own.
    """
    worst = max(signals, key=lambda s: s.nrmse / prediction_error.limit(s))
    most = STRANGE * prediction_error.limit(worst)
    if not worst.nrmse <= most:
        raise SessionError(
            f"{_names(bags)}: after the fit the {worst.axis}'s {worst.name} is still "
            f"{100.0 * worst.nrmse:.0f} % off; allowed: up to {100.0 * most:.0f} %: is it {start.name}'s?"
        )
