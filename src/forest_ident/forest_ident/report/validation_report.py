"""Predictions of held-out records: measured broad, predicted dotted, as Thesis fig. 4.12 and 4.13."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from forest_description.machine import Machine
from forest_description.types import AXES, Bools
from forest_ident.measurements.session import Session
from forest_ident.report import html_page
from forest_ident.validation.prediction_error import Signal
from forest_ident.validation.unmodelled_effects import Answer

SCALES = {
    "rad": ("deg", 57.29577951),
    "rad/s": ("deg/s", 57.29577951),
    "m3/s": ("L/min", 6e4),
    "Pa": ("MPa", 1e-6),
}
PALE = "#7fb8e6"  # under the dots of the prediction, so that neither hides the other
SHOWN = (6.0, 16.0)  # [s] of the record
PARTS = (("stick", "pressure 1"), ("stick", "pressure 2"), ("swing", "pressure 1"))


def write(session: Session, model: Machine, signals: list[Signal], directory: Path) -> Path:
    """Write `validation.html` into a directory to be made; return its path.

    Raises:
        OSError: it cannot be written.
    """
    title = f"{model.name} against {session.name}"
    content = {"title": title, "images": images(session, signals), "signals": signals}
    return html_page.write(directory / "validation.html", "validation.html", **content)


def images(session: Session, signals: list[Signal]) -> list[tuple[str, str]]:
    """Return an image per axis, as source for a page, with its caption."""
    axes = dict.fromkeys(s.axis for s in signals)
    figures = (_figure(session, axis, [s for s in signals if s.axis == axis]) for axis in axes)
    captions = (f"{session.name}, {axis}: measured broad, predicted dotted" for axis in axes)
    return [(html_page.image(figure), caption) for figure, caption in zip(figures, captions, strict=True)]


def _figure(session: Session, axis: str, signals: list[Signal]) -> Figure:
    """Return input and signals of an axis over time. Thesis fig. 4.12, 4.13."""
    count = len(signals) + 1
    figure = Figure(figsize=(8.0, 1.5 * count), layout="constrained")
    rows = figure.subplots(count, 1, sharex=True)
    rows[0].plot(session.time, session.voltages[:, AXES.index(axis)], "k", linewidth=0.9)
    rows[0].set(ylabel="input, V", title=f"{axis}: measured broad, predicted dotted")
    for row, s in zip(rows[1:], signals, strict=True):
        _compare(row, session, s, np.ones(len(session.time), dtype=bool), 1.3)
        row.set_ylabel(f"{s.name}, {SCALES[s.unit][0]}", fontsize=8)
    rows[-1].set_xlabel("time, s")
    return figure


def _compare(axes: Any, session: Session, signal: Signal, rows: Bools, width: float) -> None:
    scale = SCALES[signal.unit][1]
    axes.plot(session.time[rows], scale * signal.measured[rows], color=PALE, linewidth=2.5 * width)
    axes.plot(session.time[rows], scale * signal.predicted[rows], "k:", linewidth=width)


def draw_unmodelled_effects(answers: list[Answer], file: Path) -> None:
    """Draw a row per case: both pressures of the stick, one of the swing; after Thesis fig. 4.12, 4.13."""
    figure = Figure(figsize=(13.0, 1.8 * len(answers)), layout="constrained")
    rows = figure.subplots(len(answers), len(PARTS), sharex=True, squeeze=False)
    for row, answer in zip(rows, answers, strict=True):
        shown = (answer.session.time >= SHOWN[0]) & (answer.session.time < SHOWN[1])
        for axes, part in zip(row, PARTS, strict=True):
            for s in answer.signals:
                if (s.axis, s.name) == part:
                    _compare(axes, answer.session, s, shown, 1.2)
        row[0].set_ylabel(f"{answer.case.name}\nMPa", fontsize=8)
    for axes, part in zip(rows[0], PARTS, strict=True):
        axes.set_title(", ".join(part), fontsize=9)
    for axes in rows[-1]:
        axes.set_xlabel("time, s")
    figure.savefig(file, dpi=80)
