"""Figures 5.4 to 5.9 of the thesis' evaluation, in its layout: four graphs of signals, four of errors.

In the signals' graphs the wish is solid, scheme (c) dashed, scheme (d) dotted; in the errors' graphs (c) is
solid and (d) dashed. Where a figure has two cases, -20 % and +20 %, each has its colours. Positions count
from the start. The thesis' pictures are lost: that their fourth graph is the magnitude is a guess. Here it is
the speed or the distance from the start, and beside it the length of the error.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from forest_bag.plots.standard_plots import finish_axes, new_figure
from forest_description.types import Floats
from forest_study.thesis.thesis_plant import Motion
from forest_study.thesis.thesis_study import FIGURES, motion

GRAPHS = ("x", "y", "z", "magnitude")
HEIGHT = 11.0  # [in]
SERVOS = {"c": "velocity servo (c)", "d": "position servo (d)"}
SIGNAL_STYLES: dict[str, Any] = {"c": "--", "d": (0, (1.0, 1.2))}
ERROR_STYLES: dict[str, Any] = {"c": "-", "d": "--"}
COLOURS = ({"c": "C0", "d": "C3"}, {"c": "C2", "d": "C1"})  # by case
UNITS = {"velocity": "m/s", "position": "m"}


def draw_figures(out: Path) -> list[Path]:
    """Draw all six figures into a directory; return the files."""
    return [draw_figure(number, out / f"figure_{number.replace('.', '_')}.png") for number in FIGURES]


def draw_figure(number: str, file: Path) -> Path:
    """Draw one of the six figures. Thesis section 5.2.1, 5.2.2, 5.2.3.

    Args:
        number: "5.4" to "5.9".
        file: PNG to be written.
    """
    shows, cases = FIGURES[number]
    figure, panels = new_figure(4, 2, HEIGHT, _title(number))
    signals, errors = panels[0::2], panels[1::2]
    for place, case in enumerate(cases):
        note = f", {case.mismatch:+.0%}" if len(cases) > 1 else ""
        runs = {scheme: motion(scheme, case) for scheme in SERVOS}
        if place == 0:
            _plot(
                signals, runs["c"].time, _wished(runs["c"], shows), color="k", linewidth=1.2, label="wished"
            )
        for scheme, run in runs.items():
            style = {"color": COLOURS[place][scheme], "label": SERVOS[scheme] + note, "linewidth": 1.4}
            _plot(signals, run.time, _true(run, shows), linestyle=SIGNAL_STYLES[scheme], **style)
            _plot(errors, run.time, _error(run, shows), linestyle=ERROR_STYLES[scheme], **style)
    for column, name in ((signals, shows), (errors, f"{shows} error")):
        for axes, graph in zip(column, GRAPHS, strict=True):
            finish_axes(
                axes, f"{graph} [{UNITS[shows]}]", "time [s]" if graph == GRAPHS[-1] else "", legend=False
            )
        column[0].set_title(f"Tip {name}", fontsize="medium", pad=58.0 if len(cases) > 1 else 42.0)
        column[0].legend(
            loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize="small", ncols=2, frameon=False
        )
    figure.savefig(file)
    return file


def _title(number: str) -> str:
    shows, cases = FIGURES[number]
    if len(cases) == 1:
        return f"Figure {number}: tip {shows}, joints of {cases[0].design:g} Hz, gains made for them"
    return f"Figure {number}: tip {shows}, joints 20 % off the {cases[0].design:g} Hz of their gains"


def _plot(column: Sequence[Axes], time: Floats, values: Floats, **style: Any) -> None:
    """Draw x, y, z and the length of a signal [N, 3], one below the other."""
    rows: Mapping[str, Floats] = dict(zip(GRAPHS, [*values.T, np.linalg.norm(values, axis=1)], strict=True))
    for axes, graph in zip(column, GRAPHS, strict=True):
        axes.plot(time, rows[graph], **style)


def _wished(run: Motion, shows: str) -> Floats:
    return run.wished_velocity if shows == "velocity" else run.wished_position - run.wished_position[0]


def _true(run: Motion, shows: str) -> Floats:
    return run.velocity if shows == "velocity" else run.position - run.position[0]


def _error(run: Motion, shows: str) -> Floats:
    return run.velocity_error if shows == "velocity" else run.position_error
