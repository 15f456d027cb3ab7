"""Held-out records as pictures: measured solid, predicted dotted, as Thesis fig. 4.12 and 4.13."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from forest_description.machine import Machine
from forest_ident.measurements.session import Session
from forest_ident.validation.validation import Signal

SCALES = {
    "rad": ("deg", 57.29577951),
    "rad/s": ("deg/s", 57.29577951),
    "m3/s": ("L/min", 6e4),
    "Pa": ("MPa", 1e-6),
}


def comparison(session: Session, signals: list[Signal]) -> str:
    """Return pictures per axis and the table of scores, as HTML."""
    from forest_ident.report.report import embedded, rows

    axes = list(dict.fromkeys(s.axis for s in signals))
    parts = [embedded(_figure(session, axis, [s for s in signals if s.axis == axis])) for axis in axes]
    lines = [(f"{s.axis} {s.name}", f"{100 * s.nrmse:.2f}", f"{100 * s.vaf:.2f}") for s in signals]
    return "".join([*parts, rows(("signal", "NRMSE, % of range", "VAF, %"), lines)])


def _figure(session: Session, axis: str, signals: list[Signal]) -> Any:
    """Return input and signals of an axis over time. Thesis fig. 4.12, 4.13."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    figure, rows = pyplot.subplots(
        len(signals) + 1, 1, sharex=True, figsize=(8.0, 1.5 * (len(signals) + 1)), layout="constrained"
    )
    rows[0].plot(
        session.time, session.voltages[:, ("swing", "boom", "stick").index(axis)], "k", linewidth=0.9
    )
    rows[0].set(ylabel="input, V", title=f"{axis}: measured solid, predicted dotted")
    for row, s in zip(rows[1:], signals, strict=True):
        unit, scale = SCALES[s.unit]
        row.plot(session.time, scale * s.measured, color="C0", linewidth=0.9)
        row.plot(session.time, scale * s.predicted, "k:", linewidth=1.3)
        row.set_ylabel(f"{s.name}, {unit}", fontsize=8)
    rows[-1].set_xlabel("time, s")
    return figure


def write(session: Session, model: Machine, signals: list[Signal], directory: Path) -> Path:
    """Write `validation.html` into a directory to be made; return its path.

    Raises:
        OSError: it cannot be written.
    """
    from forest_ident.report.report import document

    directory.mkdir(parents=True)
    page = directory / "validation.html"
    title = f"{model.name} against {session.name}"
    page.write_text(document(title, [f"<h1>{title}</h1>", comparison(session, signals)]), encoding="utf-8")
    return page
