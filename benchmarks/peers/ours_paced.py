"""Ours: as `ours_even`, but with short steps after a command jumps (`forest_sim.solver.step_schedule`).

Where a command jumps is found in the table of the long steps' voltages, as for any input; pace and voltages
are made before the clock runs, as every contestant's input is.
"""

import time
from collections.abc import Callable

import numpy as np

import work as benchmark
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver import step_schedule
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import STATE
from peers import Run
from work import SAMPLE, Floats, Work


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:  # noqa: ARG001
    """Return the function that does the work."""
    p, record = plant_parameters(load_machine("c180_thesis")), compiled_record()
    given, voltages = _paced(work)
    simulation = equilibrium(benchmark.START, p)  # `start` is its 18 states

    def integrate() -> Run:
        began = time.process_time()
        states = np.empty((work.samples, len(STATE)))
        record(simulation, voltages, given, p, states, None)
        spent = time.process_time() - began
        return Run(np.vstack([start, states[:, : len(start)]]), spent)

    return integrate


def _paced(work: Work) -> tuple[step_schedule.StepSchedule, Floats]:
    long = step_schedule.long_steps(SAMPLE)
    tables = {
        n: benchmark.step_voltages(work, n).reshape(work.samples, n, 3)
        for n in (long, step_schedule.FINER * long)
    }
    jumped = step_schedule.jumps(tables[long].reshape(-1, 3), np.zeros(3), work.samples)
    given = step_schedule.after_jumps(jumped, SAMPLE)
    rows = [tables[round(count)][row] for row, count in enumerate(given.counts.tolist())]
    return given, np.concatenate(rows)
