"""The plant's steps, compiled: for studies that take millions of them, for control loops and for the node.

Compiled and interpreted steps agree to the last bit. `compiled_advance` and `compiled_record` take
and give a `Simulation`, as the interpreted functions do. Packing one costs more than some steps: a
control loop that looks at few of its numbers keeps a `FlatPlant` instead.
"""

import ctypes
import threading
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from forest_compile import flat_layout
from forest_compile.kernel_cache import can_compile
from forest_description.types import Floats, Vec3
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.solver import state_recording
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.plant_kernel import KERNEL, example
from forest_sim.solver.state_recording import STATE, restore, store
from forest_sim.solver.step_schedule import StepSchedule, schedule_of

Advance = Callable[[Simulation, Vec3, float, int, PlantParameters], Simulation]
Record = Callable[
    [Simulation, Floats, StepSchedule | float, PlantParameters, Floats, Floats | None], Simulation
]
Run = Callable[[Floats, StepSchedule, Floats, Floats], None]
"""Voltages, their schedule, the plant's row, and the states to be filled."""
DOUBLE = ctypes.sizeof(ctypes.c_double)
NOTHING, STATES, ENERGIES = 0, 1, 2
"""What the kernel records."""


class FlatPlant:
    """A machine that lies flat in an array, where the machine code moves it in place.

    Raises:
        ModuleNotFoundError: llvmlite is not installed.
    """

    def __init__(self) -> None:
        self._kernel = KERNEL.kernel()
        self.state: Floats = np.zeros(len(STATE))
        """What `state_recording.STATE` names; it may be read and written between calls."""
        self._state_at = self.state.ctypes.data
        self._held = (ctypes.c_double * 5)()  # three voltages, length and count of the steps
        self._held_at = ctypes.addressof(self._held)
        self._parameters: PlantParameters | Floats | None = None

    def lay_out(self, simulation: Simulation) -> None:
        """Take over a machine's state."""
        store(simulation, self.state)

    def set_parameters(self, p: PlantParameters | Floats) -> None:
        """Take over a machine's parameters, which seldom change; a row of them lies flat already."""
        if self._parameters is not p:
            row = p if isinstance(p, np.ndarray) else _packer()(p)
            self._parameters, self._row = p, np.array(row, dtype=np.float64)
            self._row_at = self._row.ctypes.data

    def advance(self, voltages: Vec3, h: float, count: int) -> None:
        """Advance by `count` steps of h [s] with the valve voltages [V] held."""
        self._held[:] = [*voltages, h, count]
        at, steps = self._held_at, self._held_at + 3 * DOUBLE
        into = self._row_at, self._state_at, self._state_at
        self._kernel(self._state_at, at, 0, steps, steps + DOUBLE, 0, 1, NOTHING, *into)

    def record(
        self, voltages: Floats, schedule: StepSchedule | float, states: Floats, energies: Floats | None
    ) -> None:
        """Do as `state_recording.record`."""
        table, rows = np.ascontiguousarray(voltages, dtype=np.float64), len(states)
        columns = schedule_of(schedule, rows, len(table))
        steps, counts = (np.ascontiguousarray(column, dtype=np.float64) for column in columns)
        recorded, filled = (STATES, states) if energies is None else (ENERGIES, energies)
        into = self._row_at, states.ctypes.data, filled.ctypes.data
        taken = table.ctypes.data, 3, steps.ctypes.data, counts.ctypes.data, 1, rows, recorded
        self._kernel(self._state_at, *taken, *into)

    @property
    def simulation(self) -> Simulation:
        """The machine as the laws take it."""
        return restore(self.state)


class _LastCall(threading.local):
    """What one thread has lying flat, and what it was given: a loop hands it back."""

    def __init__(self) -> None:
        self._flat = FlatPlant()
        self._result: Simulation | None = None

    def moved(
        self, simulation: Simulation, p: PlantParameters, move: Callable[[FlatPlant], None]
    ) -> Simulation:
        """Return what a call moves a machine to."""
        self._flat.set_parameters(p)
        if self._result is not simulation:
            self._flat.lay_out(simulation)
        self._result = None  # the kernel overwrites it
        move(self._flat)
        self._result = self._flat.simulation
        return self._result


@lru_cache(maxsize=1)
def _packer() -> Callable[[PlantParameters], flat_layout.Row]:
    """Return what lays parameters out flat; all machines' are of one shape."""
    return flat_layout.packer(example()[1])


@lru_cache(maxsize=1)
def _unpacker() -> Callable[[flat_layout.Row], PlantParameters]:
    """Return what makes parameters of a flat row."""
    return flat_layout.unpacker(example()[1])


@lru_cache(maxsize=1)
def _last_call() -> _LastCall:
    return _LastCall()


def compiled_advance() -> Advance:
    """Return `integrator.advance`, compiled.

    Raises:
        ModuleNotFoundError: llvmlite is not installed.
    """
    last = _last_call()

    def advance(
        simulation: Simulation, voltages: Vec3, h: float, count: int, p: PlantParameters
    ) -> Simulation:
        return last.moved(simulation, p, lambda flat: flat.advance(voltages, h, count))

    return advance


def compiled_record() -> Record:
    """Return `state_recording.record`, compiled.

    Raises:
        ModuleNotFoundError: as `compiled_advance`.
    """
    last = _last_call()

    def record(
        simulation: Simulation,
        voltages: Floats,
        schedule: StepSchedule | float,
        p: PlantParameters,
        states: Floats,
        energies: Floats | None,
    ) -> Simulation:
        return last.moved(simulation, p, lambda flat: flat.record(voltages, schedule, states, energies))

    return record


def ready_advance() -> Advance | None:
    """Return the compiled `integrator.advance` if its code is there; None if it would have to be made."""
    return compiled_advance() if KERNEL.ready() else None


def fastest_record() -> Record:
    """Return `state_recording.record`, compiled where llvmlite is installed: some hundred times faster."""
    return compiled_record() if can_compile() else state_recording.record


def fastest_run(simulation: Simulation) -> Run:
    """Return what records a machine on and on from a state: compiled where llvmlite is installed.

    Parameters are a row that `flat_layout` lays out.
    """
    if not can_compile():
        return _interpreted_run(simulation)
    flat = FlatPlant()
    flat.lay_out(simulation)

    def run(voltages: Floats, schedule: StepSchedule, p: Floats, states: Floats) -> None:
        flat.set_parameters(p)
        flat.record(voltages, schedule, states, None)

    return run


def _interpreted_run(simulation: Simulation) -> Run:
    def run(voltages: Floats, schedule: StepSchedule, p: Floats, states: Floats) -> None:
        nonlocal simulation
        plant = _unpacker()(p.tolist())
        simulation = state_recording.record(simulation, voltages, schedule, plant, states, None)

    return run
