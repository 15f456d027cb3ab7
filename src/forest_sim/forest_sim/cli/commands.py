"""What the subcommands of `forest-sim` do, once their arguments are read; each returns the exit code."""

import contextlib
import json
import math
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from forest_compile.kernel_cache import can_compile
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES, Vec3
from forest_msgs_py.runtime.command_line import StatusLine, path_in_errors
from forest_msgs_py.runtime.stop_signals import heeded
from forest_sim.analysis import machine_check, mode_map, modes, oil_softening, pump_comparison, run_summary
from forest_sim.analysis.friction_linearisation import (
    axes_with_friction,
    drive_limits,
    is_rough,
    large_heading,
    small_heading,
    with_pressed_seals,
    without_dry_friction,
)
from forest_sim.equations.plant import at_joints
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_readings import deflections, true_joints
from forest_sim.simulation.disturbance import UNDISTURBED, Disturbance
from forest_sim.simulation.energy_account import account
from forest_sim.simulation.load_schedule import Loads
from forest_sim.simulation.open_loop import (
    Run,
    RunError,
    blocks,
    require_within_limits,
    require_within_rating,
    start_angles,
    substeps,
)
from forest_sim.simulation.sensor_log import EXACT, Sensing, SensorLog
from forest_sim.simulation.trajectory_files import DecimatedRows, Rows, TrajectoryFiles
from forest_sim.simulation.voltage_profiles import Voltages
from forest_sim.solver.equilibrium import equilibrium

QUIET = 2.0  # [s] after which a run begins to say how far it is
REPORT_EVERY = 1.0  # [s] on a terminal; elsewhere ten times rarer


class Progress:
    """Says how far a long run is; on a terminal a line that overwrites itself."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._began = time.monotonic()
        self._next = self._began + QUIET
        self._line = StatusLine(sys.stdout)
        self._every = REPORT_EVERY if self._line.terminal else 10.0 * REPORT_EVERY

    def __call__(self, simulated: float) -> None:
        """Tell the simulated time [s] when it is time to."""
        now = time.monotonic()
        if now < self._next or not 0.0 < simulated < self._duration:
            return
        self._next = now + self._every
        speed = simulated / (now - self._began)
        left = (self._duration - simulated) / speed
        self._line.show(
            f"  {simulated:.0f} / {self._duration:g} s, {speed:.3g} x real time, {left:.0f} s to go"
        )

    def end(self) -> None:
        """Go to the next line."""
        self._line.end()


def new_directory(out: Path) -> None:
    """Make the directory for results, or take an empty one.

    Raises:
        RunError: something is there already: results are never overwritten.
        OSError: it cannot be made.
    """
    if out.exists() and not (out.is_dir() and not any(out.iterdir())):
        raise RunError(f"{out} exists already; choose another --out or remove it")
    out.mkdir(parents=True, exist_ok=True)


@contextlib.contextmanager
def _deferred_stop_signals() -> Iterator[list[int]]:
    """Note what stops a command instead of stopping at once, perhaps in the middle of a bag's record."""
    noted: list[int] = []
    numbers = heeded()
    before = [signal.signal(number, lambda number, _: noted.append(number)) for number in numbers]
    try:
        yield noted
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


def simulate(
    machine: Machine,
    voltages: Voltages,
    angles: Vec3,
    run: Run,
    out: Path,
    sensing: Sensing = EXACT,
    disturbance: Disturbance = UNDISTURBED,
    loads: Loads = (),
) -> int:
    """Run a machine over an input; write trajectory, pictures and `summary.json`."""
    substeps(run)
    new_directory(out)
    _warn_if_interpreted()
    log, kept = SensorLog(machine, run.rate, sensing), DecimatedRows()
    summary = run_summary.Summary(machine, disturbance.tip_force)
    progress = Progress(run.duration)
    with (
        path_in_errors(out),
        _deferred_stop_signals() as stopped,
        contextlib.closing(TrajectoryFiles(out, machine, run.rate, bool(loads))) as files,
    ):
        for block in blocks(machine, voltages, angles, run, disturbance, loads):
            observed = log.observe(block)
            files.write(block, observed)
            power = np.column_stack(account(block.energies)) * run.rate
            kept.add({"time": block.time, "power": power, **observed})
            summary.add(block)
            progress(float(block.time[-1]))
            if stopped:
                raise KeyboardInterrupt
    progress.end()
    drawn = _summarize(summary.result(run, voltages.name, angles), kept.columns(), machine, out)
    print("\n".join(f"  {path}" for path in (files.bag, files.csv, out / "summary.json", *drawn)))
    return 0


def _summarize(result: dict[str, Any], columns: Rows, machine: Machine, out: Path) -> Sequence[Path]:
    """Write summary and pictures of a run, and print what a person looks for; return the pictures."""
    from forest_sim.analysis.plots import (
        draw_run,  # matplotlib takes half a second: no bad argument waits for it
    )

    with path_in_errors(out):
        (out / "summary.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
        drawn = draw_run(columns, machine, out)
    print(run_summary.table(result))
    for warning in run_summary.run_warnings(result):
        print(f"forest-sim: {warning}", file=sys.stderr)
    return drawn


def compare_pumps(machine: Machine, voltages: Voltages, angles: Vec3, run: Run, out: Path) -> int:
    """Run the same motion on the four types of pump; write table, picture and `pumps.json`."""
    substeps(run)
    pump_comparison.with_each_pump(machine)
    new_directory(out)
    _warn_if_interpreted()
    comparison = pump_comparison.compare(machine, voltages, angles, run)
    from forest_sim.analysis.plots import draw_pumps

    result = {
        "machine": machine.name,
        "voltages": voltages.name,
        "duration_s": run.duration,
        "energy_j": comparison.energies,
        "tip_path_m": comparison.paths,
        "tip_apart_m": comparison.apart,
    }
    (out / "pumps.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    picture = draw_pumps(
        comparison.time, comparison.powers, comparison.energies, comparison.paths, out / "pumps.png"
    )
    print(pump_comparison.table(comparison))
    print("\n".join(f"  {path}" for path in (out / "pumps.json", picture)))
    return 0


def compare_machines(
    machines: Sequence[Machine],
    axis: int,
    voltages: Voltages,
    angles: Vec3,
    run: Run,
    out: Path,
    loads: Loads = (),
) -> int:
    """Run the same input on several machines; write the picture of one axis."""
    substeps(run)
    for machine in machines:
        require_within_limits(machine, angles)
    new_directory(out)
    _warn_if_interpreted()
    from forest_sim.analysis import machine_comparison

    courses = machine_comparison.compare(machines, axis, voltages, angles, run, loads)
    picture = machine_comparison.draw(courses, axis, voltages, out / "compare.png")
    print(f"{machine_comparison.table(courses)}\n  {picture}")
    return 0


def show_equilibrium(machine: Machine, angles: Vec3, as_json: bool) -> int:
    """Print how the machine rests at a pose with its valves shut."""
    result = _rest(machine, angles)
    if as_json:
        print(json.dumps(result, indent=2))
        return 0
    tip = ", ".join(f"{x:.3f}" for x in result["tip_m"])
    print(f"  tip ({tip}) m, supply {result['supply_pressure_pa'] / 1e6:.2f} MPa")
    print(f"  {'':<6} {'angle':>9} {'port 1':>10} {'port 2':>10} {'cylinder':>11} {'joint':>12}")
    for axis in AXES:
        one = result[axis]
        force = f"{one['cylinder_force_n'] / 1e3:.1f} kN" if "cylinder_force_n" in one else ""
        print(
            f"  {axis:<6} {math.degrees(one['angle_rad']):5.1f} deg {one['pressure_1_pa'] / 1e6:6.2f} MPa "
            f"{one['pressure_2_pa'] / 1e6:6.2f} MPa {force:>11} {one['joint_torque_nm'] / 1e3:7.1f} kN m"
        )
    bent = [(axis, result[axis]["deflection_rad"]) for axis in AXES if "deflection_rad" in result[axis]]
    if bent:
        print(f"  deflection [mrad]: {', '.join(f'{axis} {1e3 * way:.2f}' for axis, way in bent)}")
    return 0


def _rest(machine: Machine, angles: Vec3) -> dict[str, Any]:
    """Return how the machine rests at a pose [rad], in SI units."""
    p = plant_parameters(machine)
    rest = equilibrium(angles, p)
    held = true_joints(rest, p)
    plant, bent = at_joints(rest.plant, p), deflections(rest, p)
    forces = [
        axis.actuator.displacement_1 * state.pressure_1 - axis.actuator.displacement_2 * state.pressure_2
        for state, axis in zip(plant.axes, p.axes, strict=True)
    ]
    result: dict[str, Any] = {
        "machine": machine.name,
        "tip_m": list(tip_position(held.position, machine.manipulator.links)),
        "supply_pressure_pa": plant.supply.pressure,
    }
    for place, (axis, state) in enumerate(zip(AXES, plant.axes, strict=True)):
        result[axis] = {
            "angle_rad": state.angle,
            "pressure_1_pa": state.pressure_1,
            "pressure_2_pa": state.pressure_2,
            "swing_motor_torque_nm" if place == 0 else "cylinder_force_n": forces[place],
            "joint_torque_nm": held.effort[place],
        }
        if p.elastic.present:
            result[axis]["deflection_rad"] = bent[place]
    return result


def show_modes(machine: Machine, angles: Vec3, spools: Vec3, as_json: bool) -> int:
    """Print frequencies and damping ratios at a pose; with dry friction, of small and large oscillations."""
    require_within_rating(machine, spools)
    p = plant_parameters(machine)
    rest = equilibrium(angles, p)
    told = with_pressed_seals(p, rest.plant)
    soft = oil_softening.amplitudes(rest, p) if spools == modes.SHUT else {}
    ends, swing = axes_with_friction(told), drive_limits(p)
    small = modes.modes(angles, spools, p)
    large = modes.modes(angles, spools, without_dry_friction(p)) if is_rough(p) else small
    if as_json:
        result = {
            "machine": machine.name,
            "angles_rad": list(angles),
            "dry_friction_speeds_m_s": {
                axis: {
                    "small_below": end.small,
                    "large_above": end.large if math.isfinite(end.large) else None,
                }
                for axis, end in ends.items()
            },
            "swing_drive": None
            if swing is None
            else {
                "small_below_rad": swing.small,
                "large_above_rad": swing.large,
                "large_above_rad_s": swing.fast if math.isfinite(swing.fast) else None,
            },
            "oil_with_air_amplitudes": soft,
            "modes": modes.as_json(small),
            "modes_without_dry_friction": modes.as_json(large),
        }
        print(json.dumps(result, indent=2))
        return 0
    pose = ", ".join(f"{axis} {math.degrees(q):.1f}" for axis, q in zip(AXES, angles, strict=True))
    volts = ", ".join(f"{v:g}" for v in spools)
    print(f"  {machine.name}, {pose} deg, spools at {volts} V")
    if is_rough(p):
        print(f"  {small_heading(p)}")
    print(modes.table(small))
    if is_rough(p):
        print(f"  {large_heading(told)}\n{modes.table(large)}")
    if soft:
        print(f"  {oil_softening.heading(soft)}")
    return 0


def map_modes(machine: Machine, spacing: float, out: Path) -> int:
    """Write the slow modes over the workspace as CSV and picture."""
    new_directory(out)
    p = plant_parameters(machine)
    p = with_pressed_seals(p, equilibrium(start_angles(machine), p).plant)
    points = mode_map.mode_map(machine, spacing)
    from forest_sim.analysis.plots import draw_map

    file = out / "modes.csv"
    file.write_text(mode_map.map_csv(points), encoding="utf-8")
    if is_rough(p):
        print(f"  {small_heading(p)}")
    print(mode_map.ranges([point.modes for point in points]))
    if is_rough(p):
        print(f"  {large_heading(p)}\n{mode_map.ranges([point.sliding for point in points])}")
    picture = draw_map(points, spacing, machine, out / "modes.png")
    print(f"  {len(points)} poses\n  {file}\n  {picture}")
    return 0


def show_check(machine: Machine) -> int:
    """Print what a machine file amounts to."""
    print(machine_check.report(machine))
    return 0


def export_fmu(name: str, out: Path | None) -> int:
    """Write a machine as an FMU, and print what is in it.

    Raises:
        RunError: the file cannot be made.
    """
    from forest_sim.fmi.export import export

    fmu = out or Path(f"{load_machine(name).name}.fmu")
    if fmu.exists():
        raise RunError(f"{fmu} exists already; choose another --out or remove it")
    if fmu.suffix != ".fmu" or not fmu.parent.is_dir():
        raise RunError(f"{fmu}: allowed: a file that ends in .fmu, in a directory that is there")
    inputs, outputs = export(name, fmu)
    print(f"{fmu}: FMI 2.0 co-simulation, {inputs} inputs, {outputs} outputs")
    return 0


def _warn_if_interpreted() -> None:
    if not can_compile():
        print(
            "llvmlite is not installed, so the equations are interpreted, some hundred times slower than "
            "compiled; pip install 'forest-crane[fast]' brings it",
            file=sys.stderr,
        )
