"""The same voltages on several machines: what a component changes, beside the machine without it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from forest_bag.plots.standard_plots import finish_axes, new_figure, widen
from forest_description.machine import Machine
from forest_description.types import AXES, Floats, Vec3
from forest_sim.equations.plant import AxisState
from forest_sim.simulation.load_schedule import Loads
from forest_sim.simulation.open_loop import Run, whole
from forest_sim.simulation.voltage_profiles import Voltages
from forest_sim.solver.state_recording import STATE

PANELS = (
    ("angle", "angle [deg]"),
    ("rate", "rate [deg/s]"),
    ("pressure_1", "port 1 [MPa]"),
    ("pressure_2", "port 2 [MPa]"),
)
SWAY = ("alpha", "sway [deg]")
SUPPLY = (
    ("supply_pressure", "supply [MPa]"),
    ("pump_stroke", "displacement"),
    ("pump_speed", "engine [rpm]"),
    ("tank_pressure", "tank line [MPa]"),
)
BENDING = ("bending", "bending [mrad]")
FACTORS = {
    "angle": 180.0 / np.pi,
    "rate": 180.0 / np.pi,
    "pressure_1": 1e-6,
    "pressure_2": 1e-6,
    "spool_position": 1.0,
    "alpha": 180.0 / np.pi,
    "supply_pressure": 1e-6,
    "pump_stroke": 1.0,
    "pump_speed": 30.0 / np.pi,
    "tank_pressure": 1e-6,
    "bending": 1e3,
}
LEAST_SPAN = 1.0  # of a panel [deg; deg/s; MPa; mrad]


class Course:
    """One axis of one machine over a run."""

    def __init__(self, name: str, axis: int, time: Floats, states: Floats) -> None:
        self.name, self.time = name, time
        self._columns = {
            field: states[:, STATE.index(f"{AXES[axis]}_{field}")]
            for field in (*AxisState._fields, "spool_position")
        }
        self._columns["alpha"] = states[:, STATE.index("head_alpha")]
        self._columns |= {field: states[:, STATE.index(field)] for field, _ in SUPPLY}
        root = states[:, STATE.index(f"{AXES[axis]}_root_angle")]
        self._columns["bending"] = (self._columns["angle"] - root) * root.any()  # a rigid link has no root

    def column(self, field: str) -> Floats:
        """Return a state [N] in a picture's units."""
        return FACTORS[field] * self._columns[field]

    def has(self, field: str) -> bool:
        """Tell whether a state is one of the machine's: it is not zero all the time."""
        return bool(self._columns[field].any())


def compare(
    machines: Sequence[Machine], axis: int, voltages: Voltages, angles: Vec3, run: Run, loads: Loads = ()
) -> list[Course]:
    """Run the same voltages and loads on every machine, all from the same angles [rad]; return one axis."""
    blocks = [(machine.name, whole(machine, voltages, angles, run, loads)) for machine in machines]
    return [Course(name, axis, block.time, block.states) for name, block in blocks]


def table(courses: Sequence[Course]) -> str:
    """Return where the axis ends, how fast it was, and the range of its pressures."""
    head = f"  {'machine':<14} {'end':>9} {'fastest':>11} {'port 1':>18} {'port 2':>18}"
    return "\n".join([head, *map(_row, courses)])


def _row(course: Course) -> str:
    ranges = [course.column(field) for field in ("pressure_1", "pressure_2")]
    pressures = "".join(f" {values.min():7.2f} .. {values.max():5.2f} MPa" for values in ranges)
    fastest = np.abs(course.column("rate")).max()
    return f"  {course.name:<14} {course.column('angle')[-1]:6.2f} deg {fastest:5.1f} deg/s{pressures}"


def draw(courses: Sequence[Course], axis: int, voltages: Voltages, out: Path) -> Path:
    """Draw an axis of every machine: its voltage and spool, motion and pressures.

    Args:
        courses: from `compare`.
        axis: of them.
        voltages: what drove them.
        out: file.
    """
    names = " and ".join(course.name for course in courses)
    drawn = [*PANELS, *(field for field in (BENDING, SWAY) if any(c.column(field[0]).any() for c in courses))]
    if any(course.has("pump_stroke") or course.has("tank_pressure") for course in courses):
        drawn += [panel for panel in SUPPLY if any(course.has(panel[0]) for course in courses)]
    height = max(10.0, 1.4 * len(drawn))
    figure, panels = new_figure(len(drawn) + 1, 1, height, f"{AXES[axis]}: {names}")
    time = courses[0].time
    panels[0].plot(time, voltages.at(time)[:, axis], color="0.4")
    for place, course in enumerate(courses):
        panels[0].plot(time, course.column("spool_position"), f"C{place}", linewidth=0.8)
    finish_axes(panels[0], "voltage, spools [V]")
    for panel, (field, label) in zip(panels[1:], drawn, strict=True):
        for place, course in enumerate(courses):
            if course.has(field) or field not in dict(SUPPLY):
                panel.plot(course.time, course.column(field), f"C{place}", linewidth=1.1, label=course.name)
        if field not in dict(SUPPLY):
            widen(panel, LEAST_SPAN)
        finish_axes(panel, label, legend=field == "angle")
    panels[-1].set_xlabel("time [s]")
    figure.savefig(out)
    return out
