"""The report of an identification: one HTML file that needs nothing beside it."""

import contextlib
import platform
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from forest_ident.estimators import valve_estimate
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.measurements.session import Session, SessionError
from forest_ident.online import online_comparison
from forest_ident.online.online_comparison import Comparison
from forest_ident.output_error.residual_test import ResidualTest
from forest_ident.refinement import linear_estimates
from forest_ident.refinement.result import Result, table, told_table, unidentified
from forest_ident.report import html_page, report_plots, validation_report
from forest_ident.validation.prediction_error import Signal
from forest_ident.validation.verdict import Verdict


def write(
    result: Result,
    directory: Path,
    judged: Verdict,
    held_out: Sequence[tuple[str, Sequence[Signal]]],
    start: str,
    bags: Mapping[str, str],
) -> Path:
    """Write `report.html` into a directory; return its path.

    Args:
        result: of the identification.
        directory: to be made, or one of an earlier report.
        judged: the verdict.
        held_out: signals of the records held out, in their order.
        start: name or file of the machine that the fit started from.
        bags: experiment by the bag's path.

    Raises:
        OSError: it cannot be written.
    """
    sessions = list({r.session.name: r.session for r in result.refined}.values())
    return html_page.write(
        directory / "report.html",
        "identification.html",
        title=f"{result.start.name}, identified",
        result=result,
        verdict=judged.lines,
        made=_made(start),
        bags=bags,
        parameters=[(e, before, off(e, before)) for e, before in (*table(result), *told_table(result))],
        curves=[_curve(result, session) for session in sessions if session.kind == "valve"],
        unidentified=unidentified(result),
        online=online(result),
        experiments=[
            (_image((6.0, 3.6), draw, result.machine, session), f"{session.name}: {_caption(draw)}")
            for session in sessions
            for draw in report_plots.of_session(session)
        ],
        whiteness=[
            (_image((6.0, 2.6), report_plots.whiteness, refined), refined.session.name)
            for refined in result.refined
        ],
        channels=_channels(result),
        held_out=[
            _held_out(session, signals)
            for session, (_, signals) in zip(result.held_out, held_out, strict=True)
        ],
    )


def _made(start: str) -> dict[str, str]:
    """Return when and with what a report was made."""
    return {
        "made": datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "start": start,
        "forest crane": version("forest-crane"),
        "Python": platform.python_version(),
        "numpy": np.__version__,
    }


def _caption(draw: Callable[..., None]) -> str:
    """Return what a function says that it plots."""
    return (draw.__doc__ or "").splitlines()[0].removeprefix("Plot ")


def off(e: Estimate, before: float | None) -> str:
    """Return how far an estimate is from what was told, in per cent, as text."""
    return "-" if not before else f"{100.0 * (e.value / before - 1.0):+.2f}"


def _curve(result: Result, session: Session) -> tuple[str, list[tuple[float, float]]]:
    """Return a valve record's name and its points: voltage [V], C_R [Pa s^2/m^6]."""
    low = linear_estimates.floor(result.machine, session)
    points = valve_estimate.points(session, linear_estimates.highest(result.machine, session))
    c_r = valve_estimate.resistance(points, low)
    seen = np.isfinite(c_r)
    return session.name, sorted(zip(points.voltage[seen].tolist(), c_r[seen].tolist(), strict=True))


def _image(size: tuple[float, float], draw: Callable[..., None], *content: Any) -> str:
    """Return the image that a function of `report_plots` draws of its content."""
    figure = Figure(figsize=size, layout="constrained")
    draw(figure.subplots(), *content)
    return html_page.image(figure)


def online(result: Result) -> list[Comparison]:
    """Return the running estimates at the end of the same records. Thesis table 4.1."""
    found = []
    for session in {r.session.name: r.session for r in result.refined}.values():
        if session.kind == "damping":
            with contextlib.suppress(SessionError):  # a sensor that the off-line fit can do without
                found += online_comparison.compare(result.start, result.machine, session)
    return found


def _channels(result: Result) -> list[tuple[str, ResidualTest]]:
    return [(r.session.name, test) for r in result.refined for test in r.tests]


def _held_out(
    session: Session, signals: Sequence[Signal]
) -> tuple[str, list[tuple[str, str]], Sequence[Signal]]:
    """Return text, images with their captions, and signals of a record that was held out."""
    if not signals:
        return f"{session.name}: it cannot be predicted.", [], []
    text = f"{session.name}, {session.time[-1]:.0f} s, not used for the fit."
    return text, validation_report.images(session, list(signals)), signals
