"""The picture of the open questions: the stick's pressures case by case, read solid and predicted dotted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from forest_ident.validation.unmodelled_effects import Answer

SHOWN = (6.0, 16.0)  # [s] of the record
PARTS = (("stick", "pressure 1"), ("stick", "pressure 2"), ("swing", "pressure 1"))


def draw(answers: list[Answer], file: Path) -> None:
    """Draw a row per case: both pressures of the stick, one of the swing; after Thesis fig. 4.12, 4.13."""
    figure, rows = plt.subplots(
        len(answers), len(PARTS), sharex=True, figsize=(13.0, 1.8 * len(answers)), layout="constrained"
    )
    for row, answer in zip(np.atleast_2d(rows), answers, strict=True):
        for ax, (axis, name) in zip(row, PARTS, strict=True):
            _panel(ax, answer, axis, name)
        row[0].set_ylabel(f"{answer.case.name}\nMPa", fontsize=8)
    for ax, (axis, name) in zip(np.atleast_2d(rows)[0], PARTS, strict=True):
        ax.set_title(f"{axis}, {name}", fontsize=9)
    for ax in np.atleast_2d(rows)[-1]:
        ax.set_xlabel("time, s")
    figure.savefig(file, dpi=80)
    plt.close(figure)


def _panel(ax: Any, answer: Answer, axis: str, name: str) -> None:
    found = [s for s in answer.signals if (s.axis, s.name) == (axis, name)]
    rows = (answer.session.time >= SHOWN[0]) & (answer.session.time < SHOWN[1])
    for s in found:
        ax.plot(answer.session.time[rows], 1e-6 * s.measured[rows], color="C0", linewidth=0.9)
        ax.plot(answer.session.time[rows], 1e-6 * s.predicted[rows], "k:", linewidth=1.2)
