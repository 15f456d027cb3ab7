"""The picture of a track run: where the tip was and should have been, its error, the valves."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib

from forest_description.types import AXES
from forest_msgs_py.types import PERIOD

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

if TYPE_CHECKING:
    from forest_study.tracking.tracking import Session


def draw(session: "Session", file: Path) -> None:
    """Draw a session into a file."""
    moved = session.moved
    wished = moved.tip[0] + np.vstack([np.zeros(3), np.cumsum(moved.tip_wish[:-1], axis=0) * PERIOD])
    figure, axes = plt.subplots(2, 2, figsize=(10, 7), layout="constrained")
    for ax, (i, j) in zip(axes[0], ((0, 1), (0, 2)), strict=True):
        ax.plot(wished[:, i], wished[:, j], "k--", label="reference")
        ax.plot(moved.tip[:, i], moved.tip[:, j], label="tip")
        ax.set(xlabel=f"{'xyz'[i]}, m", ylabel=f"{'xyz'[j]}, m", aspect="equal", adjustable="datalim")
        ax.legend()
    axes[1, 0].plot(moved.time, 1e3 * moved.tip_error(), label=["x", "y", "z"])
    axes[1, 0].set(xlabel="time, s", ylabel="tip minus reference, mm")
    axes[1, 1].plot(moved.time, moved.voltages, label=list(AXES))
    axes[1, 1].set(xlabel="time, s", ylabel="valve, V")
    for ax in axes[1]:
        ax.legend()
    score = session.total
    figure.suptitle(f"{session.laps[0].path.name}: RMS {score.rms_mm:.2f} mm, max {score.max_mm:.1f} mm")
    figure.savefig(file, dpi=110)
    plt.close(figure)


def draw_runs(report: dict[str, Any], file: Path) -> None:
    """Draw which share of the runs has at most which error."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained", sharey=True)
    for ax, (field, label) in zip(axes, (("rms_mm", "RMS, mm"), ("max_mm", "max, mm")), strict=True):
        for name in report["quantiles"]:
            values = [run[field] for run in report["runs"] if run["path"] == name]
            ax.ecdf(values, label=name)
        ax.set(xlabel=label, xscale="log")
        ax.grid(alpha=0.3, which="both")
    axes[0].set(ylabel="share of the runs")
    axes[0].legend()
    count = len(report["runs"]) // len(report["quantiles"])
    drawn = "drawn machines" if report["mismatch"] else "one machine"
    figure.suptitle(f"{count} runs a path, {report['scheme']}, {report['speed']:g} m/s, {drawn}")
    figure.savefig(file, dpi=110)
    plt.close(figure)
