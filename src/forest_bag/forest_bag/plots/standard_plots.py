"""The standard pictures of a bag, for people: metres, degrees, millimetres, megapascals, litres per minute.

===============  ===========================================================================================
picture          shows
===============  ===========================================================================================
tip_path         the tip's path, drawn by the levers, governed, and moved; from above and from the side
tip_error        true tip minus the governed reference, by axis and as a norm; and minus the levers' wish
joints           joint angles with their limits, and joint speeds
voltages         valve commands (ideal valve) and voltages (amplifier), by axis
hydraulics       actuator pressures by axis with the pump pressure, and flows
===============  ===========================================================================================

The governed reference starts at the true tip where the first command was given, and integrates the commands
behind every limit. What the levers wished is drawn where the caller knows it.
"""

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from forest_bag.read.timeseries import Bag, NotInBag, Series
from forest_description.types import Floats
from forest_msgs_py.interfaces.topics import (
    FLOWS,
    GROUND_TRUTH_TIP_POSE,
    JOINT_STATES,
    JOINTS,
    PRESSURES,
    SUPPLY,
    TIP_TWIST_COMMAND,
    VALVE_COMMANDS,
    VALVE_VOLTAGES,
    Topic,
)
from forest_msgs_py.types import NS_PER_S

matplotlib.use("Agg")

Limits = Mapping[str, tuple[float, float]]  # joint -> lowest and highest angle, rad

WIDTH_IN, DPI = 10.0, 100  # 1000 px
MAX_HOLD_PERIODS = 3.0  # a command older than this is stale, and a stale wish is no motion
L_MIN_PER_M3_S = 60_000.0
WISHED: dict[str, Any] = {"color": "0.35", "linestyle": "--", "linewidth": 1.4, "zorder": 3}

_log = logging.getLogger(__name__)


def tip_error(bag: Bag) -> tuple[Floats, Floats, Floats]:
    """Governed reference and true tip at the stamps of the tip commands (`command_stamps`).

    The commands are those behind every limit; the reference starts where the tip is at the first.

    Returns:
        time since the first command [s], shape [N]; reference and moved tip [m], each of shape [N, 3].

    Raises:
        NotInBag: no tip commands, or no true tip at their time.
    """
    stamps, truth = command_stamps(bag), _need(bag, GROUND_TRUTH_TIP_POSE)
    command, start = _need(bag, TIP_TWIST_COMMAND), int(stamps[0])
    time = _seconds(stamps, start)
    truth_time = _seconds(truth.time_ns, start)
    moved = np.column_stack([np.interp(time, truth_time, truth.values[:, axis]) for axis in range(3)])
    return time, moved[0] + travelled(time, command.values[np.isin(command.time_ns, stamps)]), moved


def command_stamps(bag: Bag) -> NDArray[np.int64]:
    """Return the stamps of the tip commands while the true tip was recorded, N of them in ns.

    Raises:
        NotInBag: there are no two.
    """
    command, truth = _need(bag, TIP_TWIST_COMMAND), _need(bag, GROUND_TRUTH_TIP_POSE)
    covered = (command.time_ns >= truth.time_ns[0]) & (command.time_ns <= truth.time_ns[-1])
    if covered.sum() < 2:
        raise NotInBag(f"no two commands of {TIP_TWIST_COMMAND.name} while the true tip was recorded")
    stamps: NDArray[np.int64] = command.time_ns[covered]
    return stamps


def travelled(time: Floats, velocity: Floats) -> Floats:
    """Return the way [N, 3] m at times [N] s under velocities [N, 3] m/s.

    Each velocity holds until the next, for three periods at most.
    """
    step = np.diff(time)
    held = np.minimum(step, MAX_HOLD_PERIODS * float(np.median(step)))
    return np.vstack([np.zeros(3), np.cumsum(velocity[:-1] * held[:, np.newaxis], axis=0)])


def draw_all(
    bag: Bag,
    out_dir: str | Path,
    limits: Limits | None = None,
    leave_out: Collection[str] = (),
    wish: Floats | None = None,
) -> list[Path]:
    """Draw every standard picture for which the bag has the topics; the others are reported in the log.

    Args:
        bag: a recorded session.
        out_dir: directory for the PNG files; made if it is not there.
        limits: joint angles to show as limits, rad.
        leave_out: pictures not to draw, like "tip_error.png".
        wish: where the levers wanted the tip [N, 3] m at the times of `tip_error`; None: not known.

    Returns:
        The files drawn.
    """
    out_dir = Path(out_dir)
    out_dir.mkdir(parents=True, exist_ok=True)
    pictures: dict[str, Callable[[], Figure]] = {
        "tip_path.png": lambda: draw_tip_path(bag, wish),
        "tip_error.png": lambda: draw_tip_error(bag, wish),
        "joints.png": lambda: draw_joints(bag, limits),
        "voltages.png": lambda: draw_voltages(bag),
        "hydraulics.png": lambda: draw_hydraulics(bag),
    }
    drawn = []
    for name in sorted(pictures.keys() - set(leave_out), key=list(pictures).index):
        draw = pictures[name]
        try:
            figure = draw()
        except NotInBag as missing:
            _log.warning("%s is not drawn: %s", name, missing)
            continue
        figure.savefig(out_dir / name)
        drawn.append(out_dir / name)
    return drawn


def draw_tip_path(bag: Bag, wish: Floats | None = None) -> Figure:
    """Top view (x, y) and side view (reach, height); without commands only what moved."""
    reference: Floats | None = None
    try:
        _, reference, moved = tip_error(bag)
    except NotInBag:
        moved = _need(bag, GROUND_TRUTH_TIP_POSE).values[:, :3]
    figure, (top, side) = new_figure(1, 2, 5.2, "Path of the tip")
    for axes, project in ((top, _from_above), (side, _from_the_side)):
        axes.plot(*project(moved), label="moved", color="C0")
        axes.plot(*(values[:1] for values in project(moved)), "o", color="C2", label="start")
        if wish is not None:
            axes.plot(*project(wish), label="as the levers drew it", color="0.75", linewidth=4.0, zorder=1)
        if reference is not None:
            axes.plot(*project(reference), label="governed reference", **WISHED)
        axes.set_aspect("equal", adjustable="datalim")
        axes.grid(alpha=0.3)
    top.set(title="from above", xlabel="x, forward [m]", ylabel="y, left [m]")
    side.set(
        title="from the side", xlabel="reach from the swing axis [m]", ylabel="height over boom pivot [m]"
    )
    top.legend()
    return figure


def draw_tip_error(bag: Bag, wish: Floats | None = None) -> Figure:
    """Error of the tip against the governed reference by axis and as a norm, and against the wish, mm."""
    time, reference, moved = tip_error(bag)
    error = 1e3 * (moved - reference)
    norm = np.linalg.norm(error, axis=1)
    title = f"True tip minus governed reference: {_size(norm)}"
    if wish is not None:
        late = 1e3 * np.linalg.norm(moved - wish, axis=1)
        title += f"\nminus the levers' wish: {_size(late)}"
    figure, (by_axis, whole) = new_figure(2, 1, 6.0, title)
    for place, name in enumerate("xyz"):
        by_axis.plot(time, error[:, place], label=name)
    whole.plot(time, norm, color="0.2", label="from the governed reference")
    if wish is not None:
        whole.plot(time, late, color="C1", label="from the levers' wish")
    finish_axes(by_axis, "error [mm]")
    finish_axes(whole, "error [mm]", "time since the first command [s]")
    return figure


def _size(error: Floats) -> str:
    """Return RMS and greatest of errors [mm] as text."""
    return f"{np.sqrt(np.mean(error**2)):.0f} mm RMS, {error.max():.0f} mm at most"


def draw_joints(bag: Bag, limits: Limits | None = None) -> Figure:
    """Measured joint angles with their limits, and joint speeds."""
    joints = _need(bag, JOINT_STATES)
    time = _seconds(joints.time_ns, int(joints.time_ns[0]))
    figure, (angles, speeds) = new_figure(2, 1, 6.5, "Joints")
    for place, name in enumerate(JOINTS):
        angles.plot(time, np.degrees(joints.column(f"{name}.position")), f"C{place}", label=name)
        if f"{name}.velocity" in joints.labels:
            speeds.plot(time, np.degrees(joints.column(f"{name}.velocity")), f"C{place}", label=name)
        for limit in (limits or {}).get(name, ()):
            angles.axhline(np.degrees(limit), color=f"C{place}", linestyle=":", linewidth=1.0)
    finish_axes(angles, "angle [°]" + (", limits dotted" if limits else ""))
    finish_axes(speeds, "speed [°/s]", "time [s]")
    return figure


def draw_voltages(bag: Bag) -> Figure:
    """What the controller wished of an ideal valve, if there was one, and what the amplifier was given."""
    voltage, command = _need(bag, VALVE_VOLTAGES), _have(bag, VALVE_COMMANDS)
    start = int(min(series.time_ns[0] for series in (voltage, command) if series is not None))
    title = (
        "Valves: command (ideal valve) and voltage (amplifier)"
        if command is not None
        else "Voltages at the valves"
    )
    figure, panels = new_figure(3, 1, 7.0, title)
    for axes, name in zip(panels, JOINTS, strict=False):
        axes.plot(_seconds(voltage.time_ns, start), voltage.column(name), color="C3", label="voltage")
        if command is not None:
            axes.plot(_seconds(command.time_ns, start), command.column(name), label="command", **WISHED)
        widen(axes, 1.0)
        finish_axes(axes, f"{name} [V]", "time [s]" if name == JOINTS[-1] else "")
    return figure


def draw_hydraulics(bag: Bag) -> Figure:
    """Pressures at the actuators with the pump's, and the flows where there is a meter."""
    pressure = _need(bag, PRESSURES)
    supply, flow = _have(bag, SUPPLY), _have(bag, FLOWS)
    start = int(pressure.time_ns[0])
    figure, panels = new_figure(4, 1, 9.0, "Hydraulics")
    for axes, name in zip(panels, JOINTS, strict=False):
        for port in (1, 2):
            label = f"{name}_{port}_actuator"
            if label in pressure.labels:
                axes.plot(
                    _seconds(pressure.time_ns, start), 1e-6 * pressure.column(label), label=f"port {port}"
                )
        if supply is not None:
            line = 1e-6 * supply.column("pressure")
            axes.plot(_seconds(supply.time_ns, start), line, "k:", linewidth=1.0, label="supply")
        finish_axes(axes, f"{name} [MPa]")
    if flow is not None:
        for label in flow.labels:
            _plot_flow(panels[3], flow, label, label.replace("_", " port "), start)
    if supply is not None:
        _plot_flow(panels[3], supply, "flow", "pump", start)
    finish_axes(panels[3], "flow [L/min]", "time [s]")
    return figure


def _plot_flow(axes: Axes, series: Series, label: str, name: str, start_ns: int) -> None:
    axes.plot(_seconds(series.time_ns, start_ns), L_MIN_PER_M3_S * series.column(label), label=name)


def _need(bag: Bag, topic: Topic) -> Series:
    series = bag.series(topic)
    if len(series.time_ns) < 2:
        raise NotInBag(f"'{topic.name}' has {len(series.time_ns)} messages")
    return series


def _have(bag: Bag, topic: Topic) -> Series | None:
    try:
        return _need(bag, topic)
    except NotInBag:
        return None


def _seconds(time_ns: NDArray[np.int64], start_ns: int) -> Floats:
    return (time_ns - start_ns) / float(NS_PER_S)


def _from_above(points: Floats) -> tuple[Floats, Floats]:
    return points[:, 0], points[:, 1]


def _from_the_side(points: Floats) -> tuple[Floats, Floats]:
    return np.hypot(points[:, 0], points[:, 1]), points[:, 2]


def new_figure(rows: int, columns: int, height_in: float, title: str) -> tuple[Figure, Sequence[Axes]]:
    """A figure that belongs to no window and no global state; panels above each other share their time."""
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=DPI, layout="tight")
    panels = figure.subplots(rows, columns, sharex=rows > 1, squeeze=False).ravel()
    figure.suptitle(title)
    return figure, list(panels)


def widen(axes: Axes, span: float) -> None:
    """Show no less than a span of y, so that a line at rest is not magnified into noise."""
    low, high = axes.get_ylim()
    if high - low < span:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - span, middle + span)


def finish_axes(axes: Axes, ylabel: str, xlabel: str = "", legend: bool = True) -> None:
    """Label the axes, draw their grid and, where anything has a name, their legend."""
    axes.set_ylabel(ylabel)
    axes.set_xlabel(xlabel)
    axes.grid(alpha=0.3)
    if legend and axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right", fontsize="small", ncols=3)
