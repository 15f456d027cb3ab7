"""Do the 95 % intervals of `forest-ident` hold the truth in 95 of 100 simulated experiments?

    python benchmarks/interval_coverage.py [--machine NAME] [--sessions 200] [--seed 0] [--only NAME ...]
                                           [--processes 2] [--json FILE]

Each session is another unit of every sensor, other noise and another machine: valve, hose and swing with
parameters drawn within 40 % of the shipped crane's. Linear estimates and refinement as `forest-ident fit`
makes them.

With --machine c180, all that a fit looks for on that crane is drawn within 40 %: friction, air, load holding,
hysteresis, backlash, damping. What a person tells is drawn within its uncertainty, head and boom by 5 %.
An interval that the fit withholds or doubts is not counted; how many these are is printed.

Printed: how often each parameter's interval held the truth, and all of them pooled; with the standard error
of a share that small, because 200 sessions know a share of 95 % to 1.5 %.

With --json every finished session is written at once, and sessions that the file holds are not run again: a
long count may be stopped and gone on with. Every session tells of which source it is.
"""

import argparse
import hashlib
import json
import math
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import numpy as np

import forest_ident
from forest_description.config.parameter import MachineError
from forest_description.machine import Machine, load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.experiments import experiment_plan
from forest_ident.measurements.parameter_path import value_of, with_values
from forest_ident.refinement import extension_keys, stated_numbers
from forest_ident.refinement.identification import identify
from forest_ident.refinement.refinement_task import INERTIAS, MASSES
from forest_ident.refinement.result import value_in
from forest_ident.validation.verdict import verdict

DRAWN = (
    "valve.deadband_voltage",
    "valve.minimum_resistance",
    "valve.spool_bandwidth",
    "hose.turbulent_resistance",
    "hose.inertance",
    "hose.capacitance",
    "swing.internal_leakage_resistance",
    "swing.external_leakage_resistance",
    "swing.damping",
)
PLAIN = "c180_hoses"
DAMPING = ("boom.damping", "stick.damping")
SCALE = 0.05  # by which the masses are drawn that a fit looks for, relative
EXPERIMENTS = ("valve", "hose", "motor_external", "motor_internal", "damping_swing")
WITHIN = 0.4
NORMAL_95 = 1.959963985
Trial = dict[str, float]


def drawn(machine: Machine, generator: np.random.Generator) -> Machine:
    """Return the machine with its parameters drawn within 40 % of what they are."""
    shares = 1.0 + generator.uniform(-WITHIN, WITHIN, len(DRAWN))
    values = {key: share * value_of(machine, key) for key, share in zip(DRAWN, shares.tolist(), strict=True)}
    return with_values(machine, values)


def drawn_with_told(machine: Machine, generator: np.random.Generator) -> Machine:
    """Return the machine with all drawn that a fit looks for, and with what a person tells as it may be."""
    wanted = (*DRAWN, *DAMPING, *extension_keys.of_machine(machine))
    told = {key: sd for key, sd in stated_numbers.errors(machine, {}).items() if key not in INERTIAS}
    told |= {key: SCALE * value_of(machine, key) for key in MASSES}
    while True:
        values = {key: value_of(machine, key) * (1.0 + generator.uniform(-WITHIN, WITHIN)) for key in wanted}
        values |= {key: generator.normal(value_of(machine, key), sd) for key, sd in told.items()}
        try:
            return with_values(machine, values)
        except MachineError:  # such as a breakaway force below the sliding one: drawn again
            continue


def trial(
    seed: int, names: tuple[str, ...] = EXPERIMENTS, machine: str = PLAIN
) -> tuple[Trial, dict[str, str]]:
    """Return (estimate - truth)/standard error of what one simulated session tells, and what it doubts."""
    start, generator = load_machine(machine), np.random.default_rng([seed, 95])
    truth = drawn(start, generator) if machine == PLAIN else drawn_with_told(start, generator)
    sessions = [experiment(name, truth, seed=seed) for name in names]
    result = identify(start, sessions)
    found, doubts, away = result.estimates, verdict(result).doubts, {}
    for key in DRAWN if machine == PLAIN else found:
        if key in found and (true := value_in(truth, key)) is not None:
            e = found[key]
            error = math.log(e.value / true) if e.positive else e.value - true
            away[key] = error / (e.standard_error / (e.value if e.positive else 1.0))
    return away, doubts


def timed(seed: int, names: tuple[str, ...], machine: str) -> tuple[Trial, dict[str, str], float]:
    """Return a trial with the CPU time that it took [s]."""
    began = time.process_time()
    return *trial(seed, names, machine), time.process_time() - began


def coverage(trials: list[Trial]) -> dict[str, float]:
    """Return the share of 95 % intervals that hold the truth, per parameter and pooled."""
    keys = list(dict.fromkeys(key for trial in trials for key in trial))
    held = {key: [abs(t[key]) <= NORMAL_95 for t in trials if key in t] for key in keys}
    shares = {key: float(np.mean(hits)) for key, hits in held.items()}
    pooled = [hit for hits in held.values() for hit in hits]
    return {**shares, "pooled": float(np.mean(pooled)) if pooled else math.nan}


def table(trials: list[Trial]) -> str:
    """Return the shares as text, with how many there were and how far the estimates scatter."""
    shares = coverage(trials)
    lines = ["| parameter | sessions | held, % | standard error, % | scatter of error/standard error |"]
    lines.append("|---|---|---|---|---|")
    for key, share in shares.items():
        all_of = [z for t in trials for k, z in t.items() if key in (k, "pooled")]
        error = math.sqrt(max(share * (1.0 - share), 1e-12) / len(all_of))
        scatter = math.sqrt(float(np.mean(np.square(all_of))))
        lines.append(f"| {key} | {len(all_of)} | {100 * share:.1f} | {100 * error:.1f} | {scatter:.2f} |")
    return "\n".join(lines)


def source() -> str:
    """Return a digest of what estimates: the modules of forest_ident."""
    digest = hashlib.sha256()
    for file in sorted(Path(forest_ident.__path__[0]).rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


def kept(file: Path | None, names: tuple[str, ...], machine: str = PLAIN) -> dict[int, dict[str, Any]]:
    """Return the sessions that a file holds of these experiments on a machine, by seed."""
    if file is None or not file.exists():
        return {}
    told = json.loads(file.read_text())
    if (tuple(told["experiments"]), told.get("machine", PLAIN)) != (names, machine):
        return {}
    return {int(seed): one for seed, one in told["sessions"].items()}


def missing(
    seeds: list[int], names: tuple[str, ...], machine: str, processes: int
) -> Iterator[tuple[int, dict[str, Any]]]:
    """Run sessions side by side; give each when it is done."""
    of_source = source()
    with ProcessPoolExecutor(processes) as pool:
        running = {pool.submit(timed, seed, names, machine): seed for seed in seeds}
        for done in as_completed(running):
            away, doubts, seconds = done.result()
            one = {"away": away, "doubts": doubts, "cpu_s": round(seconds, 2), "source": of_source}
            yield running[done], one


def main() -> None:
    """Run the sessions; print and write the shares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--machine", choices=(PLAIN, "c180"), default=PLAIN)
    parser.add_argument("--sessions", type=int, default=200, metavar="N")
    parser.add_argument("--seed", type=int, default=0, help="of the first session")
    every = experiment_plan.names(load_machine("c180"))
    parser.add_argument("--only", nargs="+", choices=every, default=EXPERIMENTS, metavar="NAME")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args()
    names = tuple(options.only)
    done = kept(options.json, names, options.machine)
    seeds = [options.seed + k for k in range(options.sessions)]
    left = [seed for seed in seeds if seed not in done]
    for seed, one in missing(left, names, options.machine, options.processes):
        done[seed] = one
        away = ", ".join(f"{key.rpartition('.')[2]} {z:+.1f}" for key, z in one["away"].items())
        print(f"{len(done)}/{len(seeds)}, seed {seed}, {one['cpu_s']:.0f} s: {away}", flush=True)
        if options.json is not None:
            told = {"machine": options.machine, "experiments": names, "sessions": done}
            options.json.write_text(json.dumps(told, indent=1) + "\n")
    counted = [done[seed] for seed in seeds]
    doubted = [key for one in counted for key in one["away"] if key in one.get("doubts", {})]
    print(table([{k: z for k, z in o["away"].items() if k not in o.get("doubts", {})} for o in counted]))
    print(f"doubted, and not counted: {len(doubted)} ({', '.join(sorted(set(doubted))) or 'none'})")
    print(f"CPU time {sum(one['cpu_s'] for one in counted):.0f} s of {len(counted)} sessions")
    of = Counter(one["source"] for one in counted)
    print(f"sessions by source of forest_ident: {', '.join(f'{k}: {n}' for k, n in of.items())}")


if __name__ == "__main__":
    main()
