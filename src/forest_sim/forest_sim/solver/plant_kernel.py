"""The plant's steps as machine code, for studies that take millions of them and for the node.

The laws stay ordinary Python; here, and only here, they are handed to a compiler. Compiled and interpreted
steps agree to the last bit. Making the machine code takes some two seconds
(`python -m forest_sim.compiled`), loading it (`forest_compile.kernel_cache`) some milliseconds.
"""

import threading
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from forest_compile import flat_layout, machine_code
from forest_compile.entry import Entry
from forest_compile.kernel_cache import CachedKernel, can_compile
from forest_description.components import valve_characteristic
from forest_description.machine import load_machine
from forest_description.types import Floats, Vec3
from forest_sim.hydraulics import port, spool_dynamics
from forest_sim.mechanics import pendulum
from forest_sim.solver import implicit_stage, integrator, plant, power, state_recording
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.plant_parameters import PlantParameters, plant_parameters
from forest_sim.solver.step_schedule import Pace, given

# What is seldom called, or only with the energy account: inlined, it would make the whole larger.
NOINLINE = (
    port._two_edges,
    pendulum.pendulum_dynamics,
    spool_dynamics._second_order,
    valve_characteristic._curved_opening,
    implicit_stage._solve_further,
    implicit_stage._try_again,
    power.power_flows,
    power._axis_power,
    plant._axis_derivative,
)
# state, voltages and their stride, length and count of each row's steps and their stride, rows, recorded (0:
# nothing, 1: states, 2: energies, too), parameters, states, energies
ARGUMENTS = "ppippiiippp"
NAMES = "state, voltages, stride, steps, counts, pace, rows, recorded, parameters, states, energies"

Advance = Callable[[Simulation, Vec3, float, int, PlantParameters], Simulation]
Record = Callable[[Simulation, Floats, Pace | float, PlantParameters, Floats, Floats | None], Simulation]


def compiled_advance() -> Advance:
    """Return `integrator.advance`, compiled.

    Raises:
        ModuleNotFoundError: llvmlite is not installed.
    """
    return _compiled()[0]


def compiled_record() -> Record:
    """Return `recording.record`, compiled.

    Raises:
        ModuleNotFoundError: as `compiled_advance`.
    """
    return _compiled()[1]


def ready_advance() -> Advance | None:
    """Return the compiled `integrator.advance` if its code is there; None if it would have to be made."""
    return compiled_advance() if KERNEL.ready() else None


def fastest_record() -> Record:
    """Return `recording.record`, compiled if that can be; interpreted it is some hundred times slower."""
    return compiled_record() if can_compile() else state_recording.record


@lru_cache(maxsize=1)
def _compiled() -> tuple[Advance, Record]:
    return _around(KERNEL.kernel())


class _Flat(threading.local):
    """What one thread has lying flat: parameters seldom change, and a loop hands back what it was given."""

    def __init__(self) -> None:
        self.state, self.voltages = np.empty(len(state_recording.STATE)), np.empty(3)
        self.pace = np.empty(2)  # length and count of steps
        self.state_at, self.voltages_at = self.state.ctypes.data, self.voltages.ctypes.data
        self.pace_at = self.pace.ctypes.data, self.pace.ctypes.data + self.pace.itemsize
        self._moved: Simulation | None = None
        self._p: PlantParameters | None = None
        self._row, self._row_at = np.empty(0), 0

    def run(
        self, kernel: machine_code.Kernel, simulation: Simulation, p: PlantParameters, *arguments: Any
    ) -> Simulation:
        """Return what a kernel moves a machine to."""
        if self._p is not p:
            self._p, self._row = p, flat_parameters(p)
            self._row_at = self._row.ctypes.data
        if self._moved is not simulation:
            state_recording.store(simulation, self.state)
        self._moved = None  # the kernel overwrites it
        kernel(self.state_at, *arguments[:7], self._row_at, *arguments[7:])
        self._moved = state_recording.restore(self.state)
        return self._moved


def flat_parameters(p: PlantParameters) -> Floats:
    """Return parameters laid out flat."""
    return np.array(_packer()(p), dtype=np.float64)


@lru_cache(maxsize=1)
def _packer() -> Callable[[PlantParameters], flat_layout.Row]:
    """Return what lays out any machine's parameters: all are of one shape."""
    return flat_layout.packer(_example()[1])


def _around(kernel: machine_code.Kernel) -> tuple[Advance, Record]:
    """Return `integrator.advance` and `recording.record` around a kernel that moves a flat state in place."""
    here = _Flat()

    def advance(
        simulation: Simulation, voltages: Vec3, h: float, count: int, p: PlantParameters
    ) -> Simulation:
        here.voltages[:] = voltages
        here.pace[:] = h, count
        unused = here.state_at
        return here.run(kernel, simulation, p, here.voltages_at, 0, *here.pace_at, 0, 1, 0, unused, unused)

    def record(
        simulation: Simulation,
        voltages: Floats,
        pace: Pace | float,
        p: PlantParameters,
        states: Floats,
        energies: Floats | None,
    ) -> Simulation:
        table, rows = np.ascontiguousarray(voltages, dtype=np.float64), len(states)
        columns = given(pace, rows, len(table))
        steps, counts = (np.ascontiguousarray(column, dtype=np.float64) for column in columns)
        recorded, filled = (1, states) if energies is None else (2, energies)
        into = states.ctypes.data, filled.ctypes.data
        moves = table.ctypes.data, 3, steps.ctypes.data, counts.ctypes.data, 1, rows, recorded
        return here.run(kernel, simulation, p, *moves, *into)

    return advance, record


def entry() -> Entry:
    """Return what the kernel is made of: it steps a machine that lies flat, and records it if asked to."""
    simulation, p = _example()
    none = power.power_flows(simulation, p)
    names = {"step": integrator.step, "power_flows": power.power_flows, "NOTHING": none}
    state = [path for path, _ in flat_layout.leaves(simulation, "simulation")]
    flows = [path for path, _ in flat_layout.leaves(none, "")]
    lines = [
        f"def kernel({NAMES}):",
        "    before, i = power_flows(simulation, p) if recorded > 1 else NOTHING, 0",
        "    for row in range(rows):",
        "        h = steps[pace * row]",
        "        for _ in range(int(counts[pace * row])):",
        "            held = (voltages[i], voltages[i + 1], voltages[i + 2])",
        "            simulation = step(simulation, held, h, p)",
        "            i += stride",
        "            if recorded > 1:",
        "                after = power_flows(simulation, p)",
        f"                e = row * {len(flows)}",
        *(
            f"                energies[e + {i}] += 0.5 * h * (before{path} + after{path})"
            for i, path in enumerate(flows)
        ),
        "                before = after",
        "        if recorded:",
        f"            s = row * {len(state)}",
        *(f"            states[s + {i}] = {path}" for i, path in enumerate(state)),
        *(f"    state[{i}] = {path}" for i, path in enumerate(state)),
    ]
    return Entry(
        text="\n".join(lines),
        names=names,
        arguments=ARGUMENTS,
        tuples={"simulation": ("state", simulation), "p": ("parameters", p)},
        noinline=NOINLINE,
    )


@lru_cache(maxsize=1)
def _example() -> tuple[Simulation, PlantParameters]:
    """Return values of the types that all machines share."""
    p = plant_parameters(load_machine("c180_thesis"))
    return equilibrium((0.0, 0.5, -1.5), p), p


KERNEL = CachedKernel("plant", entry)
"""The kernel, which moves a flat machine in place (`stepper`)."""
