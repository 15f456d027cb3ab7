"""A run in numbers, gathered block by block: what `summary.json` holds and the table that a run ends with."""

import math
import time
from typing import Any

import numpy as np

from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import AXES, ZERO, Floats, Vec3
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.energy_account import Account, account, unaccounted, with_stored_energy
from forest_sim.simulation.link_account import LinkBalance
from forest_sim.simulation.open_loop import Block, Run
from forest_sim.solver.integrator import Events
from forest_sim.solver.state_recording import ENERGY, STATE, restore

ENERGY_GAP = 0.002  # of the energy that passed through, above which a run is warned of
BEYOND_LIMIT = 3.0  # [deg]
_EVENTS = [STATE.index(name) for name in Events._fields]
_ANGLES = [STATE.index(f"{axis}_angle") for axis in AXES]
_PRESSURES = [place for place, name in enumerate(STATE) if "_pressure" in name]
_DIGITS = 6  # significant


class Summary:
    """Totals and extremes of a run."""

    def __init__(self, machine: Machine, tip_force: Vec3 = ZERO) -> None:
        """Begin; the force [N] is on the tip all the time."""
        self._machine = machine
        self._links, self._has_load = LinkBalance(machine, tip_force), False
        self._limits = np.array(joint_limits(machine))
        self._first: Floats | None = None
        self._last: Floats = np.zeros(len(STATE))
        self._temperature = math.nan
        self._time = 0.0
        self._energies = np.zeros(len(ENERGY))
        self._highest = np.full(len(_PRESSURES), -np.inf)
        self._lowest = np.full(len(_PRESSURES), np.inf)
        self._outside = np.zeros(3)
        self._tip: Vec3 | None = None
        self._path = 0.0
        self._began = math.inf

    def add(self, block: Block) -> None:
        """Take a block into account."""
        if self._first is None:
            self._first, self._began = block.states[0], time.monotonic()
        self._last, self._time = block.states[-1], float(block.time[-1])
        self._temperature = float(block.temperature[-1])
        self._energies += block.energies.sum(axis=0)
        self._links.add(block)
        self._has_load = self._has_load or bool(block.load[:, 0].any())
        pressures, angles = block.states[:, _PRESSURES], block.states[:, _ANGLES]
        self._highest = np.maximum(self._highest, pressures.max(axis=0))
        self._lowest = np.minimum(self._lowest, pressures.min(axis=0))
        outside = np.maximum(self._limits[:, 0] - angles, angles - self._limits[:, 1])
        self._outside = np.maximum(self._outside, outside.max(axis=0))
        for q in angles.tolist():
            tip = tip_position((q[0], q[1], q[2]), self._machine.manipulator.links)
            self._path += 0.0 if self._tip is None else math.dist(self._tip, tip)
            self._tip = tip

    def energy(self) -> dict[str, float]:
        """Return the account [J]; `unaccounted` is what it leaves open.

        What is stored follows from the oil's state at both ends; what stays open is the error of the
        integration.
        """
        total = account(self._energies)
        if self._first is not None:
            p = plant_parameters(self._machine)
            total = with_stored_energy(total, restore(self._first), restore(self._last), p)
        parts = {name: float(value) for name, value in total._asdict().items()}
        return parts | {"unaccounted": unaccounted(total)}

    def links(self) -> dict[str, float]:
        """Return the account of the links [J]."""
        found = self._links.result()
        parts = found._asdict() | {"unaccounted": found.unaccounted}
        return {name: _round(value) for name, value in parts.items()}

    def result(self, run: Run, voltages: str, start: Vec3) -> dict[str, Any]:
        """Return everything, for `summary.json`: SI units, degrees where the name says so."""
        wall = max(time.monotonic() - self._began, 1e-9)
        links, angles = self._machine.manipulator.links, self._last[_ANGLES]
        end = tip_position((angles[0], angles[1], angles[2]), links)
        events = dict(zip(Events._fields, self._last[_EVENTS].astype(int).tolist(), strict=True))
        names = [STATE[place] for place in _PRESSURES]
        loads = {"links_j": self.links()} if self._has_load else {}
        return {
            "machine": self._machine.name,
            "pump": self._machine.pump.kind,
            "voltages": voltages,
            "duration_s": self._time,
            "oil_temperature_k": None if math.isnan(self._temperature) else _round(self._temperature),
            "rate_hz": run.rate,
            "step_s": run.step,
            "real_time_factor": _round(self._time / wall),
            "start_tip_m": [_round(x) for x in tip_position(start, links)],
            "end_tip_m": [_round(x) for x in end],
            "tip_path_m": _round(self._path),
            "energy_j": {name: _round(value) for name, value in self.energy().items()},
            **loads,
            "mean_engine_power_w": _round(self._energies[0] / self._time) if self._time else 0.0,
            "events": events,
            "highest_pressure_pa": dict(zip(names, map(_round, self._highest.tolist()), strict=True)),
            "lowest_pressure_pa": dict(zip(names, map(_round, self._lowest.tolist()), strict=True)),
            "beyond_joint_limit_deg": dict(
                zip(AXES, map(_round, np.degrees(self._outside).tolist()), strict=True)
            ),
        }


def _round(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def table(result: dict[str, Any]) -> str:
    """Return the short table that a run ends with."""
    energy, events = result["energy_j"], result["events"]
    highest = max(result["highest_pressure_pa"].items(), key=lambda item: item[1])
    outside = result["beyond_joint_limit_deg"]
    rows = [
        ("machine", f"{result['machine']}, pump {result['pump']}"),
        ("duration", f"{result['duration_s']:g} s, {result['real_time_factor']:.3g} x real time"),
        ("tip", f"{_place(result['start_tip_m'])} to {_place(result['end_tip_m'])} m"),
        ("tip path", f"{result['tip_path_m']:.2f} m"),
        ("highest pressure", f"{highest[1] / 1e6:.2f} MPa ({highest[0].replace('_', ' ')})"),
        ("relief valves", f"opened {events['relief_openings']} times"),
        ("anti-cavitation", f"opened {events['anticavitation_openings']} times"),
        ("beyond limits", ", ".join(f"{axis} {angle:.2f} deg" for axis, angle in outside.items())),
        ("energy", f"{energy['engine'] / 1e3:.1f} kJ from the engine"),
        *(
            (f"  {name.replace('_', ' ')}", f"{energy[name] / 1e3:9.2f} kJ {_share(energy, name)}")
            for name in (*Account._fields[1:], "unaccounted")
        ),
    ]
    links = result.get("links_j", {})
    rows += [(f"links: {name.replace('_', ' ')}", f"{value / 1e3:9.2f} kJ") for name, value in links.items()]
    if events["unconverged_stages"]:
        rows.append(("unconverged", f"{events['unconverged_stages']} stages of the integrator"))
    return "\n".join(f"  {name:<18} {value}" for name, value in rows)


def run_warnings(result: dict[str, Any]) -> list[str]:
    """Return, a sentence each, why a run should not be believed; none for a sound one."""
    energy, unconverged = result["energy_j"], result["events"]["unconverged_stages"]
    passed = max(energy["engine"], sum(abs(energy[name]) for name in Account._fields[1:]) / 2.0)
    found = []
    if abs(energy["unaccounted"]) > ENERGY_GAP * passed + 1.0:
        found.append(
            f"{energy['unaccounted'] / 1e3:.3g} of {passed / 1e3:.3g} kJ are unaccounted for: the steps of "
            f"{result['step_s']:g} s are too long for what happened; try --step {result['step_s'] / 4.0:g}"
        )
    if unconverged:
        found.append(f"{unconverged} stages of the integrator did not converge; try shorter steps")
    found += [
        f"the {axis} went {angle:.1f} deg beyond its limits; a machine without end stops, or stops too soft"
        for axis, angle in result["beyond_joint_limit_deg"].items()
        if angle > BEYOND_LIMIT
    ]
    return found


def _place(point: list[float]) -> str:
    return f"({', '.join(f'{x:.2f}' for x in point)})"


def _share(energy: dict[str, float], name: str) -> str:
    return f"{100.0 * energy[name] / energy['engine']:6.1f} %" if energy["engine"] > 0.0 else ""
