"""The same machine with each of the four sorts of pump. Thesis section 2.2, fig. 2.3.

What a sort needs and the machine's own pump does not say comes from the default machine and from
the files in `pumps/`, where every number has its source. The voltages are the same, the motion is
not: a load-sensing pump leaves the valve no more than its margin, and less goes through at the same
opening. Hence the tip's path.
"""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from forest_description.components.pump import (
    ConstantFlowPump,
    IdealPump,
    LoadSensingPump,
    PressureCompensatedPump,
    Pump,
)
from forest_description.machine import Machine, load_machine
from forest_description.types import Floats, Vec3
from forest_sim.analysis.run_summary import Summary
from forest_sim.simulation.energy_account import Account, account
from forest_sim.simulation.open_loop import Run, blocks
from forest_sim.simulation.voltage_profiles import Voltages

FILES = Path(__file__).resolve().parents[1] / "pumps"
SORTS: dict[type[Any], str] = {
    IdealPump: "c180_thesis",
    PressureCompensatedPump: "c180",
    ConstantFlowPump: str(FILES / "constant_flow.yaml"),
    LoadSensingPump: str(FILES / "load_sensing.yaml"),
}
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


@dataclasses.dataclass(frozen=True)
class Comparison:
    """One input on four pumps."""

    time: Floats  # [N] s
    powers: dict[str, Floats]  # by kind of pump, [N, 12] W, means between the times
    energies: dict[str, dict[str, float]]  # by kind of pump, J
    paths: dict[str, float]  # by kind of pump, how far the tip went [m]


def compare(machine: Machine, voltages: Voltages, angles: Vec3, run: Run) -> Comparison:
    """Run the same voltages on the machine with each sort of pump.

    Args:
        machine: its own pump is one of them.
        voltages: what drives it.
        angles: joint angles at the start [rad].
        run: how long and how finely.
    """
    powers, energies, paths = {}, {}, {}
    time: Floats = np.zeros(0)
    for sort in SORTS:
        variant = with_pump(machine, sort)
        summary = Summary(variant)
        times, rows = [], []
        for block in blocks(variant, voltages, angles, run):
            summary.add(block)
            times.append(block.time)
            rows.append(np.column_stack(account(block.energies)) * run.rate)
        result = summary.result(run, voltages.name, angles)
        time, power = _thinned(np.concatenate(times)[1:], np.concatenate(rows)[1:])
        name = variant.pump.kind.replace("_", " ")
        powers[name], energies[name], paths[name] = power, result["energy_j"], result["tip_path_m"]
    return Comparison(time, powers, energies, paths)


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
    return "\n".join(lines)
