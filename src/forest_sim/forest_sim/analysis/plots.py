"""Pictures of runs without a graph, beside the standard ones of `forest_bag.plots.standard_plots`."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from forest_bag.plots.standard_plots import draw_all, finish_axes, new_figure, widen
from forest_bag.read.timeseries import Bag, Series, bag_of
from forest_description.derived.limits import joint_limits
from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import columns
from forest_sim.analysis.mode_map import MapPoint
from forest_sim.simulation.energy_account import Account
from forest_sim.simulation.sensor_log import LOGGED_TOPICS
from forest_sim.simulation.trajectory_files import Rows

L_MIN_PER_M3_S = 60_000.0
# Each entry of the account keeps its colour in every picture.
COLOURS = {
    "pump": "#8c8c8c",
    "throttling": "#d62728",
    "port_valves": "#ff9896",
    "hoses": "#ff7f0e",
    "leakage": "#bcbd22",
    "friction": "#9467bd",
    "gear": "#e377c2",
    "bending": "#bcbd22",
    "stops": "#8c564b",
    "mechanical": "#2ca02c",
    "return_line": "#c49c94",
    "stored": "#17becf",
}
LABELS = {
    "pump": "pump losses",
    "port_valves": "port valves",
    "return_line": "tank line",
    "mechanical": "work on the links",
}
SMALL = 0.002  # of the engine's work: less has no place in a legend


def label_of(entry: str) -> str:
    """Return what a picture calls an entry of the account."""
    return LABELS.get(entry, entry)


def draw_run(kept: Rows, machine: Machine, out: Path) -> list[Path]:
    """Draw all pictures of a run.

    Args:
        kept: "time" [N] s, "power" [N, 13] W in the order of `Account`, and each observed topic's
            columns.
        machine: what was simulated.
        out: directory for the files.
    """
    bag = _bag(kept)
    limits = dict(zip(AXES, joint_limits(machine), strict=True))
    paths = draw_all(bag, out, limits, leave_out=("tip_error.png",))
    figures = {"spools.png": _spools(bag, kept["time"]), "power.png": _power(kept["time"], kept["power"])}
    for name, figure in figures.items():
        figure.savefig(out / name)
        paths.append(out / name)
    return paths


def _bag(kept: Rows) -> Bag:
    """Return the kept rows as a session that `forest_bag.plots.standard_plots` can draw."""
    stamps = np.round(kept["time"] * 1e9).astype(np.int64)
    return bag_of(
        {
            topic: Series(
                time_ns=stamps,
                log_time_ns=stamps,
                values=kept[topic],
                labels=columns(topic),
                units=(),
                incomplete=0,
            )
            for topic in LOGGED_TOPICS
        }
    )


def _spools(bag: Bag, time: Floats) -> Figure:
    """Voltages and the spools that follow them; below, what the pump makes of it."""
    voltage, auxiliary = bag.series(topics.VALVE_VOLTAGES), bag.series(topics.AUXILIARY)
    supply = bag.series(topics.SUPPLY)
    figure, panels = new_figure(5, 1, 10.0, "Spools and supply")
    for axes, name in zip(panels, AXES, strict=False):
        axes.plot(time, voltage.column(name), color="0.6", linestyle="--", label="voltage")
        axes.plot(time, auxiliary.column(f"{name}_spool"), label="spool")
        widen(axes, 1.0)
        finish_axes(axes, f"{name} [V]")
    panels[3].plot(time, 1e-6 * supply.column("pressure"), color="C3", label="pressure")
    panels[3].set_ylim(0.0, 1.2e-6 * float(supply.column("pressure").max()))
    finish_axes(panels[3], "pressure [MPa]")
    panels[4].plot(time, L_MIN_PER_M3_S * supply.column("flow"), color="C2", label="flow")
    finish_axes(panels[4], "flow [L/min]", "time [s]")
    return figure


def _power(time: Floats, power: Floats) -> Figure:
    """Where the power goes over time, and the energy so far."""
    entries = dict(zip(Account._fields, power.T, strict=True))
    period = np.diff(time, prepend=time[0])
    figure, (now, total) = new_figure(2, 1, 8.0, "Power and energy")
    engine = float(np.sum(entries["engine"] * period))
    for name, colour in COLOURS.items():
        if np.sum(np.abs(entries[name]) * period) > SMALL * engine:
            now.plot(time, 1e-3 * entries[name], color=colour, linewidth=1.1, label=label_of(name))
            total.plot(time, 1e-3 * np.cumsum(entries[name] * period), color=colour, label=label_of(name))
    now.plot(time, 1e-3 * entries["engine"], color="k", linewidth=1.3, label="engine", zorder=3)
    total.plot(time, 1e-3 * np.cumsum(entries["engine"] * period), color="k", label="engine")
    finish_axes(now, "power [kW]", legend=False)
    finish_axes(total, "energy so far [kJ]", "time [s]")
    total.legend(loc="upper left", fontsize="small", ncols=2)
    return figure


def draw_pumps(
    time: Floats,
    powers: Mapping[str, Floats],
    energies: Mapping[str, Mapping[str, float]],
    paths: Mapping[str, float],
    out: Path,
) -> Path:
    """Draw the comparison of pumps: shaft power over time, and where the energy went. Thesis fig. 2.3.

    Args:
        time: [N] s.
        powers: by pump, [N, 13] W in the order of `Account`.
        energies: by pump, the account [J] by entry.
        paths: by pump, how far the tip went [m].
        out: file.
    """
    figure = Figure(figsize=(10.0, 9.0), dpi=100, layout="constrained")
    figure.suptitle("The same motion on four pumps")
    grid = figure.add_gridspec(3, 1)
    shaft, work, bars = (figure.add_subplot(grid[row]) for row in range(3))
    for place, (name, power) in enumerate(powers.items()):
        entries = dict(zip(Account._fields, power.T, strict=True))
        shaft.plot(time, 1e-3 * entries["engine"], f"C{place}", linewidth=1.2, label=name)
        work.plot(time, 1e-3 * entries["mechanical"], f"C{place}", linewidth=2.4 - 0.5 * place, label=name)
    finish_axes(shaft, "engine shaft [kW]")
    shaft.set_ylim(bottom=0.0)
    shaft.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize="small", ncols=4, frameon=False)
    finish_axes(work, "work on the links [kW]", "time [s]", legend=False)
    _bars(bars, energies, paths)
    figure.savefig(out)
    return out


def _bars(axes: Axes, energies: Mapping[str, Mapping[str, float]], paths: Mapping[str, float]) -> None:
    names = list(energies)
    ends = np.zeros(len(names))
    starts = np.zeros(len(names))
    for entry, colour in COLOURS.items():
        values = 1e-3 * np.array([energies[name][entry] for name in names])
        if np.max(np.abs(values)) < SMALL * 1e-3 * max(energies[name]["engine"] for name in names):
            continue
        left = np.where(values >= 0.0, ends, starts)
        axes.barh(names, values, left=left, color=colour, label=label_of(entry), height=0.6)
        ends, starts = ends + np.maximum(values, 0.0), starts + np.minimum(values, 0.0)
    for row, name in enumerate(names):
        label = f"  {energies[name]['engine'] / 1e3:.0f} kJ, tip {paths[name]:.1f} m"
        axes.text(ends[row], row, label, va="center", fontsize="small")
    axes.axvline(0.0, color="k", linewidth=0.8)
    axes.invert_yaxis()
    axes.set_xlim(right=1.3 * float(np.max(ends)))
    back = "; to the left of zero: given back by the links" if np.min(starts) < 0.0 else ""
    finish_axes(axes, "", f"energy [kJ] and the length of the tip's path{back}")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize="small", ncols=5, frameon=False)


def draw_map(points: Sequence[MapPoint], spacing: float, machine: Machine, out: Path) -> Path:
    """Draw the slow modes' frequencies over the workspace without dry friction, one panel for each axis.

    Args:
        points: from `mode_map.mode_map`.
        spacing: of its grid [m].
        machine: whose crane's plane it is.
        out: file.
    """
    figure = Figure(figsize=(13.0, 6.6), dpi=100, layout="constrained")
    rubs = any(point.sliding is not point.modes for point in points)
    without = ", without dry friction" if rubs else ""
    figure.suptitle(f"Natural frequencies with shut valves{without}: {machine.name}")
    for axes, name in zip(figure.subplots(1, 3, sharey=True), AXES, strict=True):
        found = [(p.reach, p.height, m) for p in points if (m := p.sliding[name]) is not None]
        if found:
            reach, height = np.array([p[0] for p in found]), np.array([p[1] for p in found])
            grid, extent = _grid(reach, height, np.array([p[2].frequency for p in found]), spacing)
            image = axes.imshow(grid, origin="lower", extent=extent, cmap="viridis")
            if min(grid.shape) > 1:  # of a single row or column there are no contours
                levels = axes.contour(grid, levels=8, extent=extent, colors="w", linewidths=0.6)
                axes.clabel(levels, fontsize="x-small", fmt="%.3g")
            figure.colorbar(image, ax=axes, label="Hz", shrink=0.75)
            damping = [p[2].damping for p in found]
            axes.set_title(
                f"{name}: damping ratio {min(damping):.3f} .. {max(damping):.3f}", fontsize="medium"
            )
        axes.plot(0.0, 0.0, "k+", markersize=9)
        axes.set(xlabel="reach from the swing axis [m]", aspect="equal")
        axes.grid(alpha=0.3)
        if name == AXES[0]:
            axes.set_ylabel("height over the boom pivot [m]")
    figure.savefig(out)
    return out


def _grid(
    reach: Floats, height: Floats, values: Floats, spacing: float
) -> tuple[Floats, tuple[float, float, float, float]]:
    """Return values on their grid, nan where there is none, and the grid's extent."""
    column = np.round((reach - reach.min()) / spacing).astype(int)
    row = np.round((height - height.min()) / spacing).astype(int)
    grid = np.full((row.max() + 1, column.max() + 1), np.nan)
    grid[row, column] = values
    half = 0.5 * spacing
    extent = (reach.min() - half, reach.max() + half, height.min() - half, height.max() + half)
    return grid, extent
