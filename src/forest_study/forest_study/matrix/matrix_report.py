"""The table of the matrix, and the picture of how the seeds spread."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

from forest_study.matrix.matrix_rows import Aim, MatrixRow
from forest_study.matrix.matrix_runs import Figures, Outcome

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLUMNS = (
    *("row", "seeds", "cross-track, mm", "governed, mm", "wish, mm", "over its bound", "time lost, s"),
    *("velocity RMS, mm/s", "end, mm", "overshoot, mm", "activity, V/s", "aim"),
)
DRAWN = {
    "cross_track_max_mm": "cross-track, max, mm",
    "governed_max_mm": "governed, max, mm",
    "wish_max_mm": "wish, max, mm",
    "activity": "activity of the busiest valve, V/s",
}


def summary(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return worst and median of each figure over the seeds that ended, and how many wishes were over."""
    ended = [one.figures for one in outcomes if one.figures is not None]
    columns = {name: [getattr(one, name) for one in ended] for name in Figures._fields}
    return {
        "seeds": len(outcomes),
        "not_ended": [one.seed for one in outcomes if one.figures is None],
        "over_bound": sum(value > 1.0 for value in columns["wish_over_bound"]),
        "worst": {name: max(values, default=None) for name, values in columns.items()},
        "median": {name: float(np.median(values)) if ended else None for name, values in columns.items()},
    }


def told(row: MatrixRow, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return a row as JSON has it."""
    runs = [
        {
            "seed": one.seed,
            "drawn": one.drawn,
            "worst": one.figures and one.figures._asdict(),
            "paths": {name: figures and figures._asdict() for name, figures in one.paths.items()},
        }
        for one in outcomes
    ]
    return {"text": row.text, "aim": row.aim._asdict(), "summary": summary(outcomes), "runs": runs}


def table(report: Mapping[str, Any]) -> str:
    """Return the rows as Markdown: worst seed, then median, RMS / max."""
    lines = [f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|"]
    for name, row in report.items():
        found = row["summary"]
        seeds, lost = found["seeds"], found["not_ended"]
        text = f"{name}: {row['text']}"
        count = f"{seeds}, {len(lost)} not ended" if lost else f"{seeds}"
        if len(lost) == seeds:
            lines.append(f"| {text} | {count} {'| ' * (len(COLUMNS) - 2)}|")
            continue
        for kind, first in (("worst", f"| {text} | {count} |"), ("median", "| | median |")):
            over = f"{found['over_bound']} seeds" if kind == "worst" else ""
            aim = _aimed(Aim(**row["aim"])) if kind == "worst" else ""
            lines.append(f"{first} {_cells(found[kind], over)} | {aim} |")
    return "\n".join(lines)


def _cells(of: Mapping[str, float], over: str) -> str:
    pairs = (
        f"{of[f'{name}_rms_mm']:.1f} / {of[f'{name}_max_mm']:.1f}"
        for name in ("cross_track", "governed", "wish")
    )
    rest = f"{of['time_lost_s']:.2f} | {1e3 * of['velocity_rms']:.0f} | {of['end_mm']:.1f}"
    return f"{' | '.join(pairs)} | {over} | {rest} | {of['overshoot_mm']:.1f} | {of['activity']:.0f}"


def _aimed(aim: Aim) -> str:
    parts = []
    if aim.rms_mm is not None:
        parts.append(f"{aim.rms_mm:g} / {aim.max_mm:g} mm")
    if aim.velocity_rms is not None:
        parts.append(f"{1e3 * aim.velocity_rms:g} mm/s")
    if aim.end_mm is not None:
        parts.append(f"end {aim.end_mm:g}, overshoot {aim.overshoot_mm:g} mm")
    return ", ".join(parts)


def draw(report: Mapping[str, Any], file: Path) -> None:
    """Draw which share of the seeds has at most which figure, row by row."""
    figure, axes = plt.subplots(2, 2, figsize=(10, 8), layout="constrained", sharey=True)
    for ax, (name, text) in zip(axes.flat, DRAWN.items(), strict=True):
        for row, of in report.items():
            values = sorted(run["worst"][name] for run in of["runs"] if run["worst"])
            shares = (np.arange(len(values)) + 1.0) / len(of["runs"])
            ax.step(values, shares, where="post", label=row)
        ax.set(xlabel=text, xscale="log", ylim=(0.0, 1.02))
        ax.grid(alpha=0.3, which="both")
    for ax in axes[:, 0]:
        ax.set(ylabel="share of the seeds")
    axes[0, 0].legend(fontsize="small")
    seeds = max(len(of["runs"]) for of in report.values())
    figure.suptitle(f"Simulated plants hidden from the controller: {seeds} seeds, the worst path of each")
    figure.savefig(file, dpi=110)
    plt.close(figure)
