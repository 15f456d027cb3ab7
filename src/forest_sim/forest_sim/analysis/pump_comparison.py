"""The same machine with each of the four types of pump. Thesis section 2.2, fig. 2.3.

What a sort needs and the machine's own pump does not say comes from the default machine and from
the files in `pumps/`, where every number has its source. Motion and load are the same: the machine
with the load-sensing pump, which leaves its valves least, runs with the given voltages. All others
repeat its motion by a servo (`same_motion`), which opens their valves less.
"""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from forest_description.config.parameter import MachineError
from forest_description.geometry.kinematics import tip_position
from forest_description.hydraulics.pump import (
    ConstantFlowPump,
    IdealPump,
    LoadSensingPump,
    PressureCompensatedPump,
    Pump,
)
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES, Floats, Vec3
from forest_sim.analysis.run_summary import Summary
from forest_sim.analysis.same_motion import following
from forest_sim.simulation.energy_account import Account, account
from forest_sim.simulation.open_loop import Run, RunError, blocks, whole
from forest_sim.simulation.voltage_profiles import Voltages
from forest_sim.solver.state_recording import STATE

FILES = Path(__file__).resolve().parents[1] / "pumps"
SORTS: dict[type[Any], str] = {
    IdealPump: "c180_thesis",
    PressureCompensatedPump: "c180_hoses",
    ConstantFlowPump: str(FILES / "constant_flow.yaml"),
    LoadSensingPump: str(FILES / "load_sensing.yaml"),
}
REFERENCE = LoadSensingPump
ANGLES = [STATE.index(f"{axis}_angle") for axis in AXES]
POINTS = 2000  # rows kept for the picture


def with_pump(machine: Machine, sort: type[Any]) -> Machine:
    """Return the machine with a pump of another sort, its own numbers kept where both sorts have them."""
    if isinstance(machine.pump, sort):
        return machine
    other = load_machine(SORTS[sort]).pump
    own = {f.name: getattr(machine.pump, f.name) for f in dataclasses.fields(machine.pump)}
    known = {f.name: own[f.name] for f in dataclasses.fields(other) if f.name in own}
    pump: Pump = dataclasses.replace(other, **known)
    return dataclasses.replace(machine, pump=pump)


def with_each_pump(machine: Machine) -> dict[type[Any], Machine]:
    """Return the machine with a pump of each sort.

    Raises:
        RunError: its valves do not work with one of them.
    """
    try:
        return {sort: with_pump(machine, sort) for sort in SORTS}
    except MachineError as error:
        raise RunError(f"{machine.name} does not run on each of the four pumps: {error}") from error


@dataclasses.dataclass(frozen=True)
class Comparison:
    """One motion on four pumps."""

    time: Floats  # [N] s
    powers: dict[str, Floats]  # by kind of pump, [N, 13] W, means between the times
    energies: dict[str, dict[str, float]]  # by kind of pump, J
    paths: dict[str, float]  # by kind of pump, how far the tip went [m]
    apart: dict[str, float]  # by kind of pump, RMS of the tip's distance from where the first was [m]


def compare(machine: Machine, voltages: Voltages, angles: Vec3, run: Run) -> Comparison:
    """Run the machine with each sort of pump along the same motion.

    Args:
        machine: its own pump is one of them.
        voltages: what drives it where its pump is a load-sensing one.
        angles: joint angles at the start [rad].
        run: how long and how finely.

    Raises:
        RunError: the machine's valves do not work with one of the sorts.
    """
    found = Comparison(np.zeros(0), {}, {}, {}, {})
    variants = with_each_pump(machine)
    led = variants[REFERENCE]
    reference = whole(led, voltages, angles, run)
    links = machine.manipulator.links
    tips = np.array([tip_position(row, links) for row in reference.states[:, ANGLES]])
    for sort, variant in variants.items():
        given = voltages
        if sort is not REFERENCE:
            given = following(variant, led, reference, run)
        summary, parts = Summary(variant), []
        for block in blocks(variant, given, angles, run):
            summary.add(block)
            parts.append(block)
        result, name = summary.result(run, voltages.name, angles), variant.pump.kind.replace("_", " ")
        power = np.concatenate([np.column_stack(account(block.energies)) * run.rate for block in parts])
        time, found.powers[name] = _thinned(np.concatenate([b.time for b in parts])[1:], power[1:])
        found.energies[name], found.paths[name] = result["energy_j"], result["tip_path_m"]
        reached = np.array([tip_position(row, links) for b in parts for row in b.states[:, ANGLES]])
        found.apart[name] = float(np.sqrt(np.mean(np.sum((reached - tips) ** 2, axis=1))))
    return dataclasses.replace(found, time=time)


def _thinned(time: Floats, power: Floats) -> tuple[Floats, Floats]:
    """Return means over equal stretches, so that a picture of a long run keeps the energy."""
    every = max(1, len(time) // POINTS)
    count = len(time) // every
    means = power[: count * every].reshape(count, every, -1).mean(axis=1)
    return time[every - 1 : count * every : every], means


def table(comparison: Comparison) -> str:
    """Return the energies in a table, kJ, one column for each pump."""
    names = list(comparison.energies)
    width = max(map(len, names)) + 2
    head = f"  {'energy [kJ]':<14}" + "".join(f"{name:>{width}}" for name in names)
    lines = [head]
    for entry in (*Account._fields, "unaccounted"):
        values = "".join(f"{comparison.energies[name][entry] / 1e3:>{width}.2f}" for name in names)
        lines.append(f"  {entry.replace('_', ' '):<14}{values}")
    paths = [comparison.paths[name] for name in names]
    lines.append(f"  {'tip path [m]':<14}" + "".join(f"{path:>{width}.2f}" for path in paths))
    shares = [comparison.energies[name]["engine"] / 1e3 / max(comparison.paths[name], 1e-9) for name in names]
    lines.append(f"  {'engine [kJ/m]':<14}" + "".join(f"{share:>{width}.1f}" for share in shares))
    apart = "".join(f"{1e3 * comparison.apart[name]:>{width}.1f}" for name in names)
    lines.append(f"  {'apart [mm RMS]':<14}{apart}")
    return "\n".join(lines)
