"""Many runs along one path, over all cores: noise and machines drawn by seed, and what they spread to.

Each run is one thread's; while the compiled loop runs, Python's lock is free. Results come in the order of
the seeds and are those of one run after the other.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_sim.sensors.sensor_suite import Suite
from forest_study.closed_loop import loop_kernel, model_mismatch
from forest_study.closed_loop.model_mismatch import Mismatch
from forest_study.tracking.scores import Score
from forest_study.tracking.tracking import Course, Session, follow

FEW = 20_000  # [1] periods in all that cost less in Python, 0.5 ms each, than machine code, some 10 s
SPREAD = (*(name for name in Score._fields if name.endswith("_mm")), "time_lost_s")
QUANTILES = {"least": 0.0, "q05": 0.05, "median": 0.5, "q95": 0.95, "greatest": 1.0}


class Variation(NamedTuple):
    """What a run has of its own."""

    suite: Suite | None
    mismatch: Mismatch | None


class Run(NamedTuple):
    """One run's figures."""

    seed: int
    total: Score
    laps: tuple[Score, ...]
    mismatch: Mismatch | None

    def told(self, path: str) -> dict[str, Any]:
        """Return it as JSON has it."""
        figures: dict[str, Any] = {"path": path, "seed": self.seed, **self.total._asdict()}
        figures["laps"] = [lap._asdict() for lap in self.laps]
        return figures if self.mismatch is None else {**figures, "mismatch": self.mismatch.told()}


def run_many(
    course: Course,
    machine: Machine,
    seeds: Sequence[int],
    varied: Callable[[int], Variation],
    adapt: bool = True,
    workers: int | None = None,
) -> tuple[list[Run], Session]:
    """Return every seed's figures, and the first one's whole session.

    Args:
        course: what all have in common.
        machine: what is simulated, before anything is drawn.
        seeds: one or more.
        varied: what a seed changes.
        adapt: the driver learns its valves.
        workers: threads; default: one for each core that this process may use.
    """
    compiled = len(seeds) * len(course.places) > FEW or loop_kernel.KERNEL.ready() is not None
    if compiled:
        loop_kernel.KERNEL.kernel()  # made or loaded once, here

    def one(seed: int) -> tuple[Run, Session]:
        suite, drawn = varied(seed)
        plant = None if drawn is None else model_mismatch.applied(machine, drawn)
        session = follow(course, machine, suite, adapt, plant, compiled)
        return Run(seed, session.total, session.scores, drawn), session

    first, session = one(seeds[0])
    with ThreadPoolExecutor(workers or len(os.sched_getaffinity(0))) as pool:
        others = pool.map(lambda seed: one(seed)[0], seeds[1:])
        return [first, *others], session


def quantiles(runs: Sequence[Run]) -> dict[str, Any]:
    """Return how the figures spread, of the whole and of every lap."""
    laps = zip(*(run.laps for run in runs), strict=True)
    return {**_spread([run.total for run in runs]), "laps": [_spread(list(lap)) for lap in laps]}


def _spread(scores: list[Score]) -> dict[str, dict[str, float]]:
    spread = {}
    for name in SPREAD:
        values = [getattr(score, name) for score in scores]
        spread[name] = {key: float(np.quantile(values, share)) for key, share in QUANTILES.items()}
    return spread
