"""The report of an identification: one HTML file that needs nothing beside it."""

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from forest_ident.measurements.session import Session, SessionError
from forest_ident.online import online_comparison
from forest_ident.online.online_comparison import Comparison
from forest_ident.refinement.result import Result, table, unidentified
from forest_ident.report import html_page, report_plots, validation_report
from forest_ident.validation import prediction_error
from forest_ident.validation.prediction_error import Signal


class ChannelNoise(NamedTuple):
    """Residuals of a channel in a refinement."""

    experiment: str
    channel: str
    noise: float
    samples: int
    correlation: float | None  # at lag 1


def write(result: Result, directory: Path) -> Path:
    """Write `report.html` into a directory to be made; return its path.

    Raises:
        OSError: it cannot be written.
    """
    sessions = {r.session.name: r.session for r in result.refined}.values()
    return html_page.write(
        directory / "report.html",
        "identification.html",
        title=f"{result.start.name}, identified",
        result=result,
        parameters=table(result),
        unidentified=unidentified(result),
        online=online(result),
        experiments=[
            _image((6.0, 3.6), draw, result.machine, session)
            for session in sessions
            for draw in report_plots.of_session(session)
        ],
        whiteness=[_image((6.0, 2.6), report_plots.whiteness, refined) for refined in result.refined],
        channels=_channels(result),
        held_out=[_held_out(result, session) for session in result.held_out],
    )


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


def _channels(result: Result) -> list[ChannelNoise]:
    found = []
    for r in result.refined:
        for name, noise in r.fit.noise.items():
            residual = r.fit.residuals[name]
            correlation = report_plots.autocorrelation(residual)
            lag_1 = None if correlation is None else correlation[0]
            found.append(
                ChannelNoise(
                    experiment=r.session.name,
                    channel=name,
                    noise=noise,
                    samples=int(np.isfinite(residual).sum()),
                    correlation=lag_1,
                )
            )
    return found


def _held_out(result: Result, session: Session) -> tuple[str, list[str], list[Signal]]:
    """Return text, images and signals of a record that was held out."""
    try:
        signals = prediction_error.signals(result.machine, session)
    except SessionError as error:
        return str(error), [], []
    text = f"{session.name}, {session.time[-1]:.0f} s, not used for the fit."
    return text, validation_report.images(session, signals), signals
