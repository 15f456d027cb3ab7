"""The report of an identification: one HTML file that needs nothing beside it."""

from __future__ import annotations

import base64
import contextlib
import html
import io
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from forest_description.machine import Machine
from forest_ident.estimators.estimate import NORMAL_95
from forest_ident.measurements.session import Session, SessionError
from forest_ident.online import online_comparison
from forest_ident.refinement.result import Refined, Result, table
from forest_ident.refinement.unidentified import untold
from forest_ident.report import report_plots
from forest_ident.report.validation_report import comparison
from forest_ident.validation import validation

STYLE = (
    "body{font:14px sans-serif;max-width:70em;margin:2em auto;padding:0 1em}table{border-collapse:collapse}"
    "td,th{border:1px solid #ccc;padding:2px 8px;text-align:right}td:first-child{text-align:left}"
    "img{max-width:100%}.warning{color:#a40000}"
)


def write(result: Result, directory: Path) -> Path:
    """Write `report.html` into a directory to be made; return its path.

    Raises:
        OSError: it cannot be written.
    """
    directory.mkdir(parents=True)
    parts = [
        f"<h1>{html.escape(result.start.name)}, identified</h1>",
        "<h2>Parameters</h2>",
        _parameters(result),
        *(f'<p class="warning">{html.escape(text)}</p>' for text in result.remarks),
        *(f"<p>{html.escape(f'{key}: as told; it takes {how}')}</p>" for key, how in untold(result)),
        "<h2>What the linear estimators said</h2>",
        _linear(result),
        *_on_line(result),
        "<h2>Sensors</h2>",
        _sensors(result),
        "<h2>Experiments</h2>",
        *_pictures(result),
        "<h2>Residuals of the refinement</h2>",
        "<p>Standardised; white ones stay within the grey band. A channel's noise is what is left of it.</p>",
        *(_picture(partial(_white, r), (6.0, 2.6)) for r in result.refined),
        _noise(result),
        "<h2>Held out</h2>",
        *_held_out(result),
    ]
    page = directory / "report.html"
    page.write_text(document(f"{result.start.name}, identified", parts), encoding="utf-8")
    return page


def document(title: str, parts: list[str]) -> str:
    """Return an HTML document."""
    head = f"<meta charset='utf-8'><title>{html.escape(title)}</title><style>{STYLE}</style>"
    return f"<!doctype html><html><head>{head}</head><body>{''.join(parts)}</body></html>\n"


def rows(head: tuple[str, ...], lines: Sequence[tuple[str, ...]]) -> str:
    """Return an HTML table."""
    top = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    body = "".join(f"<tr>{''.join(f'<td>{html.escape(c)}</td>' for c in line)}</tr>" for line in lines)
    return f"<table><tr>{top}</tr>{body}</table>"


def embedded(figure: Any) -> str:
    """Return a figure as an image inside the document, and close it."""
    from matplotlib import pyplot

    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    pyplot.close(figure)
    return f"<img src='data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}'>"


def _picture(draw: Callable[[Any], None], size: tuple[float, float] = (6.0, 3.6)) -> str:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=size, layout="constrained")
    draw(axes)
    return embedded(figure)


def _parameters(result: Result) -> str:
    lines = []
    for e, told in table(result):
        value, low, high = e.spelled()
        old = "-" if told is None else f"{told:.5g}"
        cells = (
            value,
            f"{low} .. {high}",
            e.unit,
            f"{e.condition:.3g}",
            e.method,
            e.warning,
        )
        lines.append((e.key, old, *cells))
    head = ("parameter", "told", "found", "95 % interval", "unit", "condition", "method", "warning")
    return rows(head, lines)


def _linear(result: Result) -> str:
    lines = [
        (f.key, f"{f.value:.5g}", f"{f.error:.2g}", f"{f.condition:.3g}", f.method) for f in result.linear
    ]
    return rows(("parameter", "value", "standard error", "condition", "method"), lines)


def _on_line(result: Result) -> list[str]:
    """Return what the running estimates end with on the same records. Thesis table 4.1."""
    lines = []
    for session in sessions_of(result):
        if not session.name.startswith("damping_"):
            continue
        with contextlib.suppress(SessionError):  # a sensor that the off-line fit can do without
            for b in online_comparison.beside(result.start, result.machine, session):
                running = f"{b.running:.4g} ± {NORMAL_95 * b.spread:.2g}"
                lines.append((b.record, b.name, f"{b.told:.4g}", running, f"{b.settled:.4g}", b.unit))
    head = ("record", "quantity", "told", "on line, at its end", "off line, all records", "unit")
    return ["<h2>On line, over the same records</h2>", rows(head, lines)] if lines else []


def _sensors(result: Result) -> str:
    lines = [
        (
            o.channel,
            f"{o.offset:.4g} ± {NORMAL_95 * o.offset_error:.2g} {o.unit}" if o.offset_error > 0.0 else "-",
            f"{o.gain:.6f} ± {NORMAL_95 * o.gain_error:.1g}" if o.gain_error > 0.0 else "-",
        )
        for o in result.calibration
    ]
    return rows(("sensor", "offset ± 95 %", "gain ± 95 %"), lines) if lines else "<p>Not calibrated.</p>"


def _pictures(result: Result) -> list[str]:
    found = []
    for session in sessions_of(result):
        found += [
            _picture(partial(_drawn, draw, result.machine, session))
            for draw in report_plots.of_session(session)
        ]
    return found


def _drawn(draw: Callable[..., None], machine: Machine, session: Session, axes: Any) -> None:
    draw(axes, machine, session)


def _white(refined: Refined, axes: Any) -> None:
    report_plots.whiteness(axes, refined)


def sessions_of(result: Result) -> list[Session]:
    """Return the sessions that were used, each once."""
    return list({r.session.name: r.session for r in result.refined}.values())


def _noise(result: Result) -> str:
    lines = []
    for r in result.refined:
        for name, noise in r.fit.noise.items():
            residual = r.fit.residuals[name]
            correlation = report_plots.autocorrelation(residual)
            first = "-" if correlation is None else f"{correlation[0]:.3f}"
            lines.append((r.session.name, name, f"{noise:.3g}", str(int(np.isfinite(residual).sum())), first))
    return rows(("experiment", "channel", "noise left", "samples", "correlation at lag 1"), lines)


def _held_out(result: Result) -> list[str]:
    if not result.held_out:
        return ["<p>Nothing was held out: no record named validation was among the bags.</p>"]
    found = []
    for session in result.held_out:
        try:
            signals = validation.signals(result.machine, session)
        except SessionError as error:
            found.append(f"<p>{html.escape(str(error))}</p>")
            continue
        found.append(f"<p>{html.escape(session.name)}, {session.time[-1]:.0f} s, not used for the fit.</p>")
        found.append(comparison(session, signals))
    return found
