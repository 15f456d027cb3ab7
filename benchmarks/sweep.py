"""What a run of a sweep costs, and what a longer step of the simulated machine changes in it.

A run is `kind: track` along a circle that takes 20 s, with noise, and with it on a drawn plant that the
controller does not know. Both steps see the same noise, in one process. Times are processor time of one
thread; the fastest of the seeds counts, for neighbours only slow it. Seeds whose noise is drawn anew, and
machines of a study's own, cost the set-up that is told apart.

| column | is |
|---|---|
| tip | distance of the tip from that of steps of 0.25 ms, period by period: RMS and greatest |
| cross-track | its RMS with 0.25 ms, mean of the seeds; what the step adds, and twice its standard error |
"""

import argparse
import time
from typing import Any

import numpy as np

from forest_control.servo.schemes import scheme_named
from forest_description.machine import load_machine
from forest_description.types import Floats
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop import compiled_loop, model_mismatch
from forest_study.sweep.trials import tracked
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import follow, noisy, prepare

MACHINES = ("c180_hoses", "c180", "loader", "forwarder")
FINE, STEPS = 2.5e-4, (1e-3, 2.5e-3, 5e-3)  # [s]
COURSE = {"path": "circle_h", "speed": 0.325}
RANGES = model_mismatch.Ranges()
RUNS, CORES = 10_000, 2
COLUMNS = (
    *("machine", "step, ms", "a run, ms", "with its own noise", "10 000 on two cores, min"),
    *("tip, mm", "cross-track, mm", "drawn plant: tip, mm", "cross-track, mm"),
)
COSTED = 5  # [1] seeds whose time is taken


def tips(machine: str, step: float, seed: int, drawn: bool) -> tuple[Floats, float]:
    """Return the tip's places [N, 3] m of a run, and its cross-track RMS [mm]."""
    crane = load_machine(machine)
    course = prepare(path_named(COURSE["path"]), COURSE["speed"], scheme_named("coordinated"), crane)
    course = course._replace(substeps=round(PERIOD / step))
    plant = model_mismatch.applied(crane, model_mismatch.draw(seed, RANGES)) if drawn else None
    session = follow(course, crane, noisy(crane, seed), course.drive.adapt, plant)
    return session.moved.tip, session.total.cross_track_rms_mm


def changed(machine: str, seeds: int, drawn: bool) -> list[str]:
    """Return the cells that tell what each step changes."""
    finest = [tips(machine, FINE, seed, drawn) for seed in range(seeds)]
    cells = []
    for step in STEPS:
        away, changes = [], []
        for seed, (fine, fine_rms) in enumerate(finest):
            tip, rms = tips(machine, step, seed, drawn)
            rows = min(len(tip), len(fine))
            away.append(np.linalg.norm(tip[:rows] - fine[:rows], axis=1))
            changes.append(rms - fine_rms)
        whole, half = np.concatenate(away), 2.0 * np.std(changes, ddof=1) / np.sqrt(seeds)
        mean = np.mean([rms for _, rms in finest])
        apart = f"{1e3 * np.sqrt(np.mean(whole**2)):.2f} / {1e3 * whole.max():.1f}"
        cells.append(f"{apart} | {mean:.2f} {np.mean(changes):+.2f} ± {half:.2f}")
    return cells


def cost(machine: str, step: float, seeds: int) -> tuple[float, float]:
    """Return a run's processor time [s] with noise that another run has drawn, and with its own."""
    case: dict[str, Any] = {"machine": machine, "step": step, **COURSE}
    found = []
    for seed in range(seeds + 1):
        compiled_loop._drawn.cache_clear()
        found.append([_took(case, seed) for _ in range(3)])
    own, shared = np.array(found[1:])[:, 0], np.array(found[1:])[:, 1:]
    return float(shared.min()), float(own.min())


def _took(case: dict[str, Any], seed: int) -> float:
    begun = time.process_time()
    tracked(case, seed)
    return time.process_time() - begun


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("machines", nargs="*", default=MACHINES)
    parser.add_argument("--seeds", type=int, default=16)
    options = parser.parse_args()
    print(f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}")
    for machine in options.machines:
        known, unknown = (changed(machine, options.seeds, drawn) for drawn in (False, True))
        for step, one, other in zip(STEPS, known, unknown, strict=True):
            shared, own = cost(machine, step, COSTED)
            cells = f"{one} | {other}"
            minutes = RUNS * shared / CORES / 60.0, RUNS * own / CORES / 60.0
            print(
                f"| `{machine}` | {1e3 * step:g} | {1e3 * shared:.0f} | {1e3 * own:.0f} "
                f"| {minutes[0]:.1f}, {minutes[1]:.1f} | {cells} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
