"""Ours: `forest_sim.compiled`, the loop over steps compiled as a study would do it.

The tolerance is the step [s]. Open loop: each step holds the voltage in its middle, read from a table made
beforehand. Held commands: the steps between two commands are one call.
"""

import time
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

import work as benchmark
from forest_description.machine import load_machine
from forest_sim.compiled import compiled_advance
from forest_sim.equilibrium import equilibrium
from forest_sim.parameters import plant_parameters
from peers import Run
from work import SAMPLE, Floats, Work

_advance: Any = compiled_advance()


@numba.njit(cache=True)
def _integrate(simulation, voltages, h, count, states, p):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Fill `states` from row 1; voltages has shape (samples, calls a sample, 3), `count` steps a call."""
    for k in range(voltages.shape[0]):
        for j in range(voltages.shape[1]):
            v = (voltages[k, j, 0], voltages[k, j, 1], voltages[k, j, 2])
            simulation = _advance(simulation, v, h, count, p)
        column, plant = 0, simulation.plant
        for axis in (plant.swing, plant.boom, plant.stick):
            for value in axis:
                states[k + 1, column] = value
                column += 1


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:
    """Return the function that does the work."""
    p = plant_parameters(load_machine("c180_thesis"))
    steps = round(SAMPLE / tolerance)
    calls = 1 if work.mode == "held" else steps
    voltages = benchmark.step_voltages(work, calls).reshape(work.samples, calls, 3)
    simulation = equilibrium(benchmark.START, p)  # `start` is its 18 states

    def integrate() -> Run:
        states = np.empty((work.samples + 1, 18))
        states[0] = start
        began = time.process_time()
        _integrate(simulation, voltages, SAMPLE / steps, steps // calls, states, p)
        return Run(states, time.process_time() - began)

    return integrate
