"""The picture of a track run: where the tip was and should have been, its errors, the valves."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure, FigureBase

from forest_control.taught.tip_path import cross_track_distance
from forest_description.types import AXES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from forest_study.closed_loop.closed_loop import Trajectory
    from forest_study.tracking.tracking import Session

SIZE, DPI = (10.0, 7.0), 110  # [in], [1/in]
SPREAD = {"governed": "against the governed reference", "cross_track": "cross-track", "wish": "wish"}


def draw(session: "Session", file: Path) -> None:
    """Draw a session into a file."""
    figure = Figure(figsize=SIZE, layout="constrained")
    fill(figure, session.moved, session)
    figure.savefig(file, dpi=DPI)


def fill(figure: FigureBase, moved: "Trajectory", session: "Session | None" = None) -> None:
    """Draw what happened into an empty figure, and beside it the path that it was led along, if any."""
    governed = moved.tip - moved.tip_error()
    axes = figure.subplots(2, 2)
    for ax, (i, j) in zip(axes[0], ((0, 1), (0, 2)), strict=True):
        if session:
            line = session.drawn[0].line
            ax.plot(line[:, i], line[:, j], color="0.7", linewidth=4, label="path as drawn")
        ax.plot(governed[:, i], governed[:, j], "k--", label="governed reference")
        ax.plot(moved.tip[:, i], moved.tip[:, j], label="tip")
        ax.set(xlabel=f"{'xyz'[i]}, m", ylabel=f"{'xyz'[j]}, m", aspect="equal", adjustable="datalim")
        ax.legend()
    _draw_errors(axes[1, 0], moved, session)
    axes[1, 1].plot(moved.time, moved.voltages, label=list(AXES))
    axes[1, 1].set(xlabel="time, s", ylabel="valve, V")
    for ax in axes[1]:
        ax.legend()
    if session:
        figure.suptitle(_title(session))


def _title(session: "Session") -> str:
    s = session.total
    return (
        f"{session.drawn[0].lap.path.name}, RMS / max, mm: governed {s.governed_rms_mm:.2f} / "
        f"{s.governed_max_mm:.1f}, cross-track {s.cross_track_rms_mm:.2f} / {s.cross_track_max_mm:.1f}, "
        f"wish {s.wish_rms_mm:.1f} / {s.wish_max_mm:.1f}; {s.time_lost_s:.2f} s lost"
    )


def _draw_errors(ax: "Axes", moved: "Trajectory", session: "Session | None") -> None:
    """Draw the tip's three distances over time: path and wish where there are."""
    governed = moved.tip_error()
    begin = session.drawn[0].lap.rows(session.led.clock)[0] if session else 0
    governed = np.linalg.norm(governed - governed[begin], axis=1)
    ax.plot(moved.time, 1e3 * governed, "k--", label="governed reference")
    ax.set(xlabel="time, s", ylabel="tip off by, mm")
    if not session:
        return
    ax.plot(moved.time, 1e3 * cross_track_distance(session.drawn[0].line, moved.tip), label="cross-track")
    for k, one in enumerate(session.drawn):
        rows = one.lap.rows(session.led.clock)
        wish = 1e3 * np.linalg.norm(moved.tip[rows] - one.ideal_in(rows), axis=1)
        ax.plot(moved.time[rows], wish, "C1", label="wish" if k == 0 else None)


def draw_runs(report: dict[str, Any], file: Path) -> None:
    """Draw which share of the runs has at most which error, by every measure."""
    figure = Figure(figsize=(10, 11), layout="constrained")
    axes = figure.subplots(len(SPREAD), 2, sharey=True)
    for row, (measure, text) in zip(axes, SPREAD.items(), strict=True):
        for ax, figures in zip(row, ("rms", "max"), strict=True):
            for name in report["quantiles"]:
                values = [run[f"{measure}_{figures}_mm"] for run in report["runs"] if run["path"] == name]
                ax.ecdf(values, label=name)
            ax.set(xlabel=f"{text}, {figures.replace('rms', 'RMS')}, mm", xscale="log")
            ax.grid(alpha=0.3, which="both")
        row[0].set(ylabel="share of the runs")
    axes[0, 0].legend()
    count = len(report["runs"]) // len(report["quantiles"])
    drawn = "drawn machines" if report["mismatch"] else "one machine"
    figure.suptitle(f"{count} runs a path, {report['scheme']}, {report['speed']:g} m/s, {drawn}")
    figure.savefig(file, dpi=DPI)
