"""How much faster than real time the closed loop runs: compiled, and interpreted beside it, in the same run.

The work is the five paths of `forest-study track` at 0.5 m/s: full plant (default `c180_hoses`), noise,
controller, driver. Both loops give the same figures. Times are CPU time of one thread; planning a path, which
all its runs share, is told apart. With `--runs` also many drawn machines over all cores.
"""

import argparse
import json
import os
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import Machine, load_machine
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop import compiled_loop, loop_kernel, model_mismatch
from forest_study.tracking import tracking
from forest_study.tracking.paths import NAMES, path_named
from forest_study.tracking.track_runs import Variation, run_many

DRIVE = valve_driver_parameters.Settings(adapt=True)
HEAD = (
    "| path | simulated, s | compiled, × real time | with set-up and noise "
    "| interpreted | ratio | plan, s |\n|---|---|---|---|---|---|---|"
)
Row = dict[str, Any]


def compare(machine: Machine, name: str, repeats: int) -> Row:
    """Return a path's row; the fastest of some runs counts, for neighbours only slow them.

    Raises:
        AssertionError: the loops differ.
    """
    plan, course = _timed(lambda: tracking.prepare(path_named(name), 0.5, Scheme.COORDINATED, machine))
    suite, seconds = tracking.noisy(machine, 0), PERIOD * len(course.places)
    start = inverse_kinematics(path_named(name).at(0.0), machine.manipulator.links)
    rows = np.ones((len(course.places) + 1, 4))

    def given() -> compiled_loop.Prepared:
        return compiled_loop.prepared(machine, rows, start, course.settings, DRIVE, suite=suite)

    whole = [_timed(lambda: given().lead(course.places, course.hand)) for _ in range(repeats)]
    prepared = given()
    alone = [_timed(lambda: prepared.lead(course.places, course.hand))[0] for _ in range(repeats)]
    given_python = len(rows), start, course.settings, DRIVE, machine, suite, None
    in_python = compiled_loop.interpreted(machine, *given_python, fast=False)  # but for the plant
    python, slow = _timed(lambda: in_python.lead(course.places, course.hand))
    assert (whole[0][1].moved.tip == slow.moved.tip).all(), "both loops must give the same figures"
    fastest = min(took for took, _ in whole)
    return {
        "path": name,
        "seconds": seconds,
        "compiled": seconds / min(alone),
        "with_set_up": seconds / fastest,
        "interpreted": seconds / python,
        "ratio": python / fastest,
        "plan_seconds": plan,
    }


def many(machine: Machine, count: int) -> Row:
    """Return what so many drawn machines on one path take over all cores, by the clock and in CPU time."""
    course = tracking.prepare(path_named("circle_h"), 0.5, Scheme.COORDINATED, machine)

    def varied(seed: int) -> Variation:
        return Variation(tracking.noisy(machine, seed), model_mismatch.draw(seed, model_mismatch.Ranges()))

    began = time.perf_counter()
    took, _ = _timed(lambda: run_many(course, machine, range(count), varied, adapt=True), time.process_time)
    seconds, clock = count * PERIOD * len(course.places), time.perf_counter() - began
    return {
        "runs": count,
        "cores": len(os.sched_getaffinity(0)),
        "seconds": seconds,
        "by_clock": seconds / clock,
        "per_core": seconds / took,
    }


def _timed(work: Callable[[], Any], clock: Callable[[], float] = time.thread_time) -> tuple[float, Any]:
    before = clock()
    result = work()
    return clock() - before, result


def table(rows: Iterable[Row]) -> Iterable[str]:
    """Return the rows as lines of Markdown."""
    for r in rows:
        yield (
            f"| {r['path']} | {r['seconds']:.1f} | {r['compiled']:.0f} | {r['with_set_up']:.0f} "
            f"| {r['interpreted']:.1f} | {r['ratio']:.0f} | {r['plan_seconds']:.2f} |"
        )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--paths", nargs="+", choices=NAMES, default=NAMES)
    parser.add_argument("--repeats", type=int, default=10, help="of the compiled loop (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=0, metavar="N", help="drawn machines over all cores, too")
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--machine", default="c180_hoses", metavar="NAME|FILE")
    options = parser.parse_args()
    machine = load_machine(options.machine)
    loop_kernel.KERNEL.kernel()
    print(HEAD)
    rows = []
    for name in options.paths:
        rows.append(compare(machine, name, options.repeats))
        print(*table(rows[-1:]), sep="\n", flush=True)
    together = many(machine, options.runs) if options.runs else None
    if together:
        print(
            "\n{runs} drawn machines, {seconds:.0f} s, over {cores} cores: {by_clock:.0f} × real time by the "
            "clock, {per_core:.0f} by CPU time".format(**together)
        )
    if options.json:
        options.json.write_text(json.dumps({"rows": rows, "many": together}, indent=2) + "\n")


if __name__ == "__main__":
    main()
