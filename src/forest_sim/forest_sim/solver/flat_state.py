"""A machine that stays laid out flat between calls, for control loops that look at few of its numbers.

`compiled_advance` takes and gives a `Simulation`, whose packing costs more than some steps; here the state
lies in an array that the machine code moves in place.
"""

import ctypes
from collections.abc import Callable

import numpy as np

from forest_compile import flat_layout
from forest_description.types import Floats, Vec3
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.plant_kernel import KERNEL
from forest_sim.solver.plant_parameters import PlantParameters
from forest_sim.solver.state_recording import restore, store

_packers: list[Callable[[PlantParameters], flat_layout.Row]] = []
"""One for all machines, which are of one shape: a warming machine gets a stepper every second."""

NO_STRIDE, ONE_ROW, UNRECORDED = 0, 1, 0


class Stepper:
    """One machine under way."""

    def __init__(self, simulation: Simulation, p: PlantParameters) -> None:
        """Lay a machine out flat.

        Raises:
            ModuleNotFoundError: llvmlite is not installed.
        """
        self._kernel = KERNEL.kernel()
        self.state: Floats = np.array(flat_layout.packer(simulation)(simulation), dtype=np.float64)
        """What `recording.STATE` names; it may be read and written between calls."""
        self._parameters = np.array(_packed(p), dtype=np.float64)
        self._voltages = (ctypes.c_double * 3)()
        self._pace = (ctypes.c_double * 2)()  # length and count of steps
        pace = ctypes.addressof(self._pace)
        self._moves = (
            *(self.state.ctypes.data, ctypes.addressof(self._voltages), NO_STRIDE),
            *(pace, pace + ctypes.sizeof(ctypes.c_double), NO_STRIDE, ONE_ROW, UNRECORDED),
            *(self._parameters.ctypes.data, self.state.ctypes.data, self.state.ctypes.data),
        )

    def advance(self, voltages: Vec3, h: float, count: int) -> None:
        """Advance by `count` steps of h [s] with the valve voltages [V] held."""
        self._voltages[0], self._voltages[1], self._voltages[2] = voltages
        self._pace[0], self._pace[1] = h, count
        self._kernel(*self._moves)

    @property
    def simulation(self) -> Simulation:
        """The machine as the laws take it."""
        return restore(self.state)

    @simulation.setter
    def simulation(self, simulation: Simulation) -> None:
        store(simulation, self.state)


def _packed(p: PlantParameters) -> flat_layout.Row:
    if not _packers:
        _packers.append(flat_layout.packer(p))
    return _packers[0](p)
