"""The trials of one change: scenes, pushes, plants of the matrix. A process of its own makes them.

All changes run in one compiled loop, which reads the constants when it runs. The operator says every period
what the fastest profile along the path wishes.
"""

import multiprocessing
import os
import signal
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from forest_compile.kernel_cache import CachedKernel
from forest_control.taught.tip_path import PathError, cross_track_distance
from forest_description.machine import load_machine
from forest_study.ablation.constants import ROOMS, Changes, at_runtime, changed, numbers
from forest_study.ablation.plants import plants
from forest_study.ablation.scenes import SCENES, pushes
from forest_study.closed_loop import compiled_loop, loop_kernel

Figures = dict[str, float]
"""What a change is judged by, by name and unit."""


class Trial(NamedTuple):
    """What is to be tried."""

    machine: str
    changes: Changes
    scenes: tuple[str, ...]  # of `SCENES`
    pushes: int  # of each of the conditions
    conditions: list[tuple[float, float]]  # believed over true overlap; tilt [rad] that nobody knows
    plants: int = 0  # of each of the matrix' rows


def tried(trials: Sequence[Trial]) -> Iterator[Figures | None]:
    """Yield the figures of trials in their order, each from a process of its own; None if control failed.

    The first is made alone, since it may have to compile the loop.

    Raises:
        StudyError: a name is not known.
    """
    numbers(ROOMS, load_machine(trials[0].machine))  # all modules are imported once, here
    cross_track_distance(np.eye(3), np.eye(3))  # scipy is, too
    context, count = multiprocessing.get_context("fork"), len(os.sched_getaffinity(0))
    # Forked workers would take the end of their pool, a SIGTERM, for Ctrl-C as the command does.
    unheeded = signal.SIGTERM, signal.SIG_DFL
    with context.Pool(count, signal.signal, unheeded, maxtasksperchild=1) as pool:
        yield pool.apply(figures, (trials[0],))
        yield from pool.imap(figures, trials[1:], chunksize=1)


def figures(trial: Trial) -> Figures | None:
    """Return the figures of a trial in this process, whose constants change for good.

    Raises:
        StudyError: a name is not known.
    """
    settings = changed(trial.changes)
    compiled_loop.runtime_numbers = at_runtime()
    loop_kernel.KERNEL = CachedKernel("loop", loop_kernel.entry)
    machine = load_machine(trial.machine)
    found: Figures = {}
    try:
        for name in trial.scenes:
            found |= SCENES[name](machine, settings)
        found |= pushes(machine, settings, trial.pushes, trial.conditions)
        return found | (plants(machine, settings, trial.plants) if trial.plants else {})
    except (ArithmeticError, PathError, ValueError):
        return None
