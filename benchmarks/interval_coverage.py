"""Do the 95 % intervals of `forest-ident` hold the truth in 95 of 100 simulated experiments?

    python benchmarks/coverage.py [--experiments 200] [--seed 0] [--out coverage.json]

Each experiment is another unit of every sensor, other noise and another machine: valve, hose and swing with
parameters drawn within 40 % of the shipped crane's. Linear estimates and refinement as `forest-ident fit`
makes them. Printed: how often each parameter's interval held the truth, and all of them pooled; with the
standard error of a share that small, because 200 experiments know a share of 95 % to 1.5 %.
"""

import argparse
import json
import math
from pathlib import Path

import numpy as np

from forest_description.machine import Machine, load_machine
from forest_ident.ident_experiment import experiment
from forest_ident.identification import identify
from forest_ident.keys import value_of, with_values

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
EXPERIMENTS = ("valve", "hose", "motor_external", "motor_internal", "damping_swing")
WITHIN = 0.4


def drawn(machine: Machine, generator: np.random.Generator) -> Machine:
    """Return the machine with its parameters drawn within 40 % of what they are."""
    shares = 1.0 + generator.uniform(-WITHIN, WITHIN, len(DRAWN))
    values = {key: share * value_of(machine, key) for key, share in zip(DRAWN, shares.tolist(), strict=True)}
    return with_values(machine, values)


def trial(seed: int, names: tuple[str, ...] = EXPERIMENTS) -> dict[str, float]:
    """Return (estimate - truth)/standard error of every parameter that one simulated session tells."""
    start = load_machine("c180")
    truth = drawn(start, np.random.default_rng([seed, 95]))
    sessions = [experiment(name, truth, seed=seed) for name in names]
    found = identify(start, sessions).estimates
    away = {}
    for key in DRAWN:
        if key in found:
            e, true = found[key], value_of(truth, key)
            error = math.log(e.value / true) if e.positive else e.value - true
            away[key] = error / (e.standard_error / (e.value if e.positive else 1.0))
    return away


def coverage(trials: list[dict[str, float]]) -> dict[str, float]:
    """Return the share of 95 % intervals that hold the truth, per parameter and pooled."""
    keys = list(dict.fromkeys(key for trial in trials for key in trial))
    held = {key: [abs(t[key]) <= 1.959963985 for t in trials if key in t] for key in keys}
    shares = {key: float(np.mean(hits)) for key, hits in held.items()}
    pooled = [hit for hits in held.values() for hit in hits]
    return {**shares, "pooled": float(np.mean(pooled)) if pooled else math.nan}


def main() -> None:
    """Run the trials; print and write the shares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--experiments", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--names", nargs="+", default=list(EXPERIMENTS), help="experiments of a session")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    trials = []
    for k in range(options.experiments):
        trials.append(trial(options.seed + k, tuple(options.names)))
        away = ", ".join(f"{key.rpartition('.')[2]} {z:+.1f}" for key, z in trials[-1].items())
        print(f"{k + 1}/{options.experiments}: {away}", flush=True)
    shares = coverage(trials)
    for key, share in shares.items():
        print(f"{key:<40} {100.0 * share:5.1f} %")
    if options.out is not None:
        options.out.write_text(json.dumps({"coverage": shares, "trials": trials}, indent=1) + "\n")


if __name__ == "__main__":
    main()
