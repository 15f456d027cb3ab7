"""One contestant in a process of its own: start-up, then the whole work; prints one JSON object.

Times are CPU times of this process, which neighbours on the machine disturb least; start-up is wall time from
the process' spawning to the end of the first 5 ms of work, and CPU time beside it.
"""

import argparse
import importlib
import json
import resource
import time
from typing import Any

import numpy as np

import work as benchmark
from peers import CONTESTANTS, Prepare, Run
from work import Floats

REPEATS = 100
PATIENCE = 0.1  # of the work's length: CPU time after which nothing is repeated
ANGLES, PRESSURES = [0, 6, 12], [2, 3, 8, 9, 14, 15]


def errors(states: Floats, reference: Floats) -> tuple[float, float]:
    """Return the largest deviation of a joint angle [rad] and of a hose pressure [MPa]."""
    deviation = np.abs(states - reference[: len(states)])
    return float(deviation[:, ANGLES].max()), float(deviation[:, PRESSURES].max()) / 1e6


def measure(
    prepare: Prepare, mode: str, seconds: float, tolerance: float, reference: Floats
) -> dict[str, Any]:
    """Return the fastest of some repetitions of the whole work, and its errors."""
    integrate = prepare(benchmark.make(mode, seconds), reference[0], tolerance)
    run = integrate()
    best, spent, repeats = run.cpu_seconds, run.cpu_seconds, 1
    while repeats < REPEATS and spent < PATIENCE * seconds:
        cpu = integrate().cpu_seconds
        best, spent, repeats = min(best, cpu), spent + cpu, repeats + 1
    return {"cpu_seconds": best, **_quality(run, reference), "real_time_factor": seconds / best}


def _quality(run: Run, reference: Floats) -> dict[str, float]:
    error_rad, error_mpa = errors(run.states, reference)
    return {"error_rad": error_rad, "error_mpa": error_mpa}


def _cpu() -> float:
    """Return the CPU time [s] of this process and of the compilers that it called."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def main() -> None:
    """Do what the parent process asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("contestant", choices=CONTESTANTS)
    parser.add_argument("--mode", required=True)
    parser.add_argument("--seconds", type=float, required=True)
    parser.add_argument("--tolerance", type=float, required=True)
    parser.add_argument("--reference", required=True)
    parser.add_argument("--spawned", type=float, required=True, help="time.time() before this process")
    parser.add_argument("--first-step", action="store_true", help="end after the first 5 ms")
    args = parser.parse_args()

    reference = np.load(args.reference)
    prepare: Prepare = importlib.import_module(f"peers.{CONTESTANTS[args.contestant].module}").prepare
    prepare(benchmark.make(args.mode, benchmark.SAMPLE), reference[0], args.tolerance)()
    result: dict[str, Any] = {"first_step_s": time.time() - args.spawned, "first_step_cpu_s": _cpu()}
    if not args.first_step:
        result |= measure(prepare, args.mode, args.seconds, args.tolerance, reference)
    print(json.dumps(result))


if __name__ == "__main__":
    main()
