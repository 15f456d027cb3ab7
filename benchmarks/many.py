"""How `simulate_many` grows with the cores: many machines against one, in the same run.

Every job is a `c180_hoses` of its own (a drawn head mass) under a chirp, with its energy account. One
worker does a share of the jobs before, and the same share after the rest. By the clock, neighbours on the
machine count against the many; by CPU time, that of starting the workers included, only what the jobs cost
each other.
"""

import os
import resource
import time
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from forest_description.machine import load_machine
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.batch import Job, simulate_many
from forest_sim.simulation.open_loop import Block, Run

RUN = Run(60.0)
JOBS_A_CORE = 60
HEAD = (
    "| workers | jobs | simulated, s | took, s | CPU, s | × real time | of cores × one: by the clock "
    "| by CPU time |\n|---|---|---|---|---|---|---|---|"
)
Row = dict[str, Any]


def jobs(count: int) -> list[Job]:
    """Return jobs with drawn machines."""
    machine = load_machine("c180_hoses")
    crane, chirp = machine.manipulator, voltage_profiles.chirp(4.0, 0.1, 3.0)
    draws = np.random.default_rng(3).uniform(0.5, 1.5, count).tolist()
    return [
        Job(replace(machine, manipulator=replace(crane, head_mass=draw * crane.head_mass)), chirp)
        for draw in draws
    ]


def final(run: Block) -> list[float]:
    """Return the last state of a run."""
    last: list[float] = run.states[-1].tolist()
    return last


def measure(per_core: int = JOBS_A_CORE) -> list[Row]:
    """Return a row for one worker and one for as many as there are cores."""
    cores = len(os.sched_getaffinity(0))
    given = jobs(per_core * cores)
    simulate_many(given[:1], RUN, final, workers=1)  # makes or loads the machine code
    before = _seconds(given[: per_core // 2], 1)
    together = _seconds(given, cores)
    after = _seconds(given[per_core // 2 : per_core], 1)
    alone = before[0] + after[0], before[1] + after[1]
    return [_row(1, per_core, alone, alone), _row(cores, len(given), together, alone)]


def _row(workers: int, count: int, spent: tuple[float, float], alone: tuple[float, float]) -> Row:
    return {
        "workers": workers,
        "jobs": count,
        "seconds": spent[0],
        "cpu_seconds": spent[1],
        "real_time_factor": count * RUN.duration / spent[0],
        "efficiency": alone[0] / spent[0],
        "cpu_efficiency": workers * alone[1] / spent[1],
    }


def _seconds(given: list[Job], workers: int) -> tuple[float, float]:
    """Return the time that some jobs take [s]: by the clock, and of all processors."""
    began, used = time.perf_counter(), _cpu()
    simulate_many(given, RUN, final, workers)
    return time.perf_counter() - began, _cpu() - used


def _cpu() -> float:
    kinds = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN
    return sum(usage.ru_utime + usage.ru_stime for usage in map(resource.getrusage, kinds))


def table(rows: Iterable[Row]) -> Iterable[str]:
    """Return the rows as lines of Markdown."""
    for row in rows:
        simulated = row["jobs"] * RUN.duration
        yield (
            f"| {row['workers']} | {row['jobs']} | {simulated:.0f} | {row['seconds']:.1f} "
            f"| {row['cpu_seconds']:.1f} | {row['real_time_factor']:.0f} | {row['efficiency']:.2f} "
            f"| {row['cpu_efficiency']:.2f} |"
        )
