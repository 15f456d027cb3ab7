"""Many runs at once, over all cores: draws of parameters, inputs, poses.

Each run is one thread's work in a process of its own; results come in the order of the jobs and are
those of a serial loop. A worker hands back what `keep` makes of a run, so that thousands of runs
fit into memory.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from typing import NamedTuple, TypeVar

from forest_compile.kernel_cache import can_compile
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_sim.simulation.open_loop import Block, Run, require_within_limits, start_angles, whole
from forest_sim.simulation.voltage_profiles import Voltages

T = TypeVar("T")


class Job(NamedTuple):
    """One run: a machine, what drives it, the joint angles [rad] at its start (None: as the node starts)."""

    machine: Machine
    voltages: Voltages
    angles: Vec3 | None = None


def everything(run: Block) -> Block:
    """Keep a run as it is."""
    return run


def simulate_one(job: Job, run: Run, keep: Callable[[Block], T]) -> T:
    """Return what `keep` makes of one run."""
    m, angles = job.machine, job.angles
    start = start_angles(m) if angles is None else require_within_limits(m, angles)
    return keep(whole(m, job.voltages, start, run))


def simulate_many(
    jobs: Sequence[Job],
    run: Run,
    keep: Callable[[Block], T] = everything,  # type: ignore[assignment]
    workers: int | None = None,
) -> list[T]:
    """Return what `keep` makes of each job's run, in the jobs' order.

    Worker processes are spawned, so jobs and `keep` must be picklable (a function of a module, no
    lambda), and a script that calls this guards itself with `if __name__ == "__main__":`.

    Args:
        jobs: what to simulate.
        run: how long and how finely, for all.
        keep: made of each run in the worker; default: the whole run, some 7 MB a minute at 200 Hz.
        workers: processes; default: one for each core that this process may use.

    Raises:
        RunError: a job's start is out of reach, or step and rate do not fit.
    """
    count = min(len(jobs), workers or len(os.sched_getaffinity(0)))
    if count <= 1:
        return [simulate_one(job, run, keep) for job in jobs]
    if can_compile():  # once, here: the workers then find the compiled kernel in its cache
        simulate_one(jobs[0], run._replace(duration=1.0 / run.rate), everything)
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        return list(pool.map(partial(simulate_one, run=run, keep=keep), jobs))
