"""The table of the matrix, and the picture of how the seeds spread."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

from forest_study.matrix.figures import Figures
from forest_study.matrix.matrix_rows import Aim, MatrixRow
from forest_study.matrix.matrix_runs import Outcome

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLUMNS = (
    *("row", "seeds", "cross-track, mm", "governed, mm", "wish, mm", "keep its bound", "time lost, s"),
    *("velocity RMS, mm/s", "end, mm", "overshoot, mm", "activity, V/s", "aim"),
)
DRAWN = {
    "cross_track_max_mm": "cross-track, max, mm",
    "governed_max_mm": "governed, max, mm",
    "wish_max_mm": "wish, max, mm",
    "activity": "activity of the busiest valve, V/s",
}


def summary(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return worst and median of each figure over the seeds that ended; whose wish is over its bound."""
    ended = [one.figures for one in outcomes if one.figures is not None]
    columns = {name: [getattr(one, name) for one in ended] for name in Figures._fields}
    return {
        "seeds": len(outcomes),
        "not_ended": [one.seed for one in outcomes if one.figures is None],
        "over_bound": [one.seed for one in outcomes if one.figures and one.figures.wish_over_bound > 1.0],
        "worst": {name: max(values, default=None) for name, values in columns.items()},
        "median": {name: float(np.median(values)) if ended else None for name, values in columns.items()},
    }


def told(row: MatrixRow, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return a row as JSON has it; seeds whose load is within the crane's capacity, and the others, apart."""
    runs = [
        {
            "seed": one.seed,
            "drawn": one.drawn,
            "overloaded": one.overloaded,
            "worst": one.figures and one.figures._asdict(),
            "paths": {name: figures and figures._asdict() for name, figures in one.paths.items()},
        }
        for one in outcomes
    ]
    return {
        "text": row.text,
        "aim": row.aim._asdict(),
        "within": summary([one for one in outcomes if not one.overloaded]),
        "beyond": summary([one for one in outcomes if one.overloaded]),
        "runs": runs,
    }


def table(report: Mapping[str, Any]) -> str:
    """Return the rows as Markdown, RMS / max: worst seed within the capacity, median; the same beyond it."""
    lines = [f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|"]
    for name, row in report.items():
        lines += _lines(f"{name}: {row['text']}", row["within"], _aimed(Aim(**row["aim"])))
        lines += _lines("beyond the capacity", row["beyond"], "")
    return "\n".join(lines)


def _lines(text: str, found: Mapping[str, Any], aim: str) -> list[str]:
    seeds, lost = found["seeds"], found["not_ended"]
    if seeds == 0:
        return []
    count = f"{seeds}, {len(lost)} not ended" if lost else f"{seeds}"
    if len(lost) == seeds:
        return [f"| {text} | {count} {'| ' * (len(COLUMNS) - 2)}|"]
    kept = f"{seeds - len(lost) - len(found['over_bound'])} of {seeds - len(lost)}"
    return [
        f"| {text} | {count} | {_cells(found['worst'], kept)} | {aim} |",
        f"| | median | {_cells(found['median'], '')} | |",
    ]


def _cells(of: Mapping[str, float], kept: str) -> str:
    pairs = (
        f"{of[f'{name}_rms_mm']:.1f} / {of[f'{name}_max_mm']:.1f}"
        for name in ("cross_track", "governed", "wish")
    )
    rest = f"{of['time_lost_s']:.2f} | {1e3 * of['velocity_rms']:.0f} | {of['end_mm']:.1f}"
    return f"{' | '.join(pairs)} | {kept} | {rest} | {of['overshoot_mm']:.1f} | {of['activity']:.0f}"


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
    """Draw which share of the seeds has at most which figure, row by row; dashed beyond the capacity."""
    figure, axes = plt.subplots(2, 2, figsize=(10, 8), layout="constrained", sharey=True)
    for ax, (name, text) in zip(axes.flat, DRAWN.items(), strict=True):
        for k, (row, of) in enumerate(report.items()):
            for overloaded, style in ((False, "-"), (True, ":")):
                runs = [run["worst"] for run in of["runs"] if run["overloaded"] == overloaded]
                values = sorted(worst[name] for worst in runs if worst)
                shares = (np.arange(len(values)) + 1.0) / max(1, len(runs))
                label = None if overloaded else row
                ax.step(values, shares, where="post", label=label, linestyle=style, color=f"C{k}")
        ax.set(xlabel=text, xscale="log", ylim=(0.0, 1.02))
        ax.grid(alpha=0.3, which="both")
    for ax in axes[:, 0]:
        ax.set(ylabel="share of the seeds")
    axes[0, 0].legend(fontsize="small")
    seeds = max(len(of["runs"]) for of in report.values())
    figure.suptitle(
        f"Simulated plants hidden from the controller: {seeds} seeds, the worst path of each\n"
        "dotted: head beyond the crane's capacity"
    )
    figure.savefig(file, dpi=110)
    plt.close(figure)
