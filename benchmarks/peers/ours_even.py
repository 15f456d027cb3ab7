"""Ours with even steps: `forest_sim.solver.plant_kernel`, one call for the whole work, as in a study.

The tolerance is the step [s]. Open loop: each step holds the voltage in its middle, read from a table made
beforehand. Held commands: the table repeats each command for every step until the next one.
"""

import time
from collections.abc import Callable

import numpy as np

import work as benchmark
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import STATE
from forest_sim.solver.step_schedule import even
from peers import Run
from work import SAMPLE, Floats, Work


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:
    """Return the function that does the work."""
    p, record = plant_parameters(load_machine("c180_thesis")), compiled_record()
    steps = round(SAMPLE / tolerance)
    voltages = np.ascontiguousarray(benchmark.step_voltages(work, steps))
    simulation = equilibrium(benchmark.START, p)  # `start` is its 18 states

    def integrate() -> Run:
        began = time.process_time()
        states = np.empty((work.samples, len(STATE)))
        record(simulation, voltages, even(SAMPLE / steps, work.samples, steps), p, states, None)
        spent = time.process_time() - began
        return Run(np.vstack([start, states[:, : len(start)]]), spent)

    return integrate
