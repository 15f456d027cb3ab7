"""How well `forest-ident actuator` predicts held-out parts of one record, and what a learnt remainder adds.

    python benchmarks/crane_record.py RECORD.csv [--starts 10] [--repeats 5]

The record has 512 samples. Each fold is fitted from so many starts, and for each repeat from others; their
spread is told. The remainder is a ridge regression of what the physics leaves of the fitted rows. It sees the
valve and what the model itself simulates, but no measured pressure of the rows to be predicted. The penalty
that is chosen predicts quarters of the fitted rows best from the others; the greatest leaves no remainder.
Beside it stands a small penalty, without a choice.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np

from forest_description.types import Floats
from forest_ident.actuator import fit, kernel, record
from forest_ident.cli.actuator_command import scaled
from forest_ident.validation.prediction_error import rms

COUNT = 512  # samples of the record
FOLDS = (  # fitted rows, predicted rows
    *(((0, end), (end, COUNT)) for end in (285, 320, 365, 400, 430)),
    *(((begin, COUNT), (0, begin)) for begin in (205, 256)),
    ((117, 400), (400, COUNT)),
)
LAGS = (2, 4, 8)  # [samples]
PENALTIES = (0.01, 0.1, 1.0, 10.0, 1e6)  # of coefficients of normed features; the last leaves the physics
QUARTERS, SMALL = 4, 0.1  # parts by which a penalty is judged; the penalty without a choice


class Simulated(NamedTuple):
    """What fits simulate freely over the whole record, in the mean."""

    pressure: Floats
    position: Floats


def main() -> None:
    """Print a row for each fold, and the mean."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("record", type=Path)
    parser.add_argument("--starts", type=int, default=10)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    read = record.read(options.record)
    if len(read.valve) != COUNT:
        parser.error(f"{options.record} has {len(read.valve)} samples; allowed: {COUNT}")
    scales = record.scales(read)
    columns, missed = scaled(read, scales), []
    print("| fitted, samples | predicted | RMS, physics | learnt remainder, chosen | of a small penalty |")
    print("|---|---|---|---|---|")
    for fitted, held in FOLDS:
        rows = [
            scales.pressure * of_fold(columns, fitted, held, options.starts, n)
            for n in range(options.repeats)
        ]
        missed.append(rows)
        print(f"| {_text(fitted)} | {_text(held)} | {_told(np.array(rows))} |", flush=True)
    print(f"| mean | | {_told(np.mean(missed, axis=0))} |")


def of_fold(
    columns: fit.Columns, fitted: tuple[int, int], held: tuple[int, int], starts: int, seed: int
) -> Floats:
    """Return RMS of the pressure [P] over the held rows: physics alone, and with either remainder."""
    mask = np.zeros(len(columns.signal), dtype=bool)
    mask[slice(*fitted)] = True
    found = fit.similar(fit.fit_from_many_starts(fit.Problem(columns, mask), starts, seed))
    simulated = mean_of([fit.simulate(one.z, columns.signal) for one in found])
    left = columns.pressure - simulated.pressure
    about, rows = features(simulated, columns.signal), np.flatnonzero(mask)
    learnt = [
        np.zeros(len(left)),
        remainder(about, left, rows, PENALTIES),
        remainder(about, left, rows, (SMALL,)),
    ]
    return np.array([rms((left - one)[slice(*held)]) for one in learnt])


def mean_of(runs: list[tuple[Floats, Floats]]) -> Simulated:
    """Return the mean of the runs that do not run away."""
    sound = [run for run in runs if np.max(np.abs(run[0])) < kernel.BEYOND]
    return Simulated(*np.mean(sound or runs, axis=0))


def features(simulated: Simulated, signal: Floats) -> Floats:
    """Return the N by k columns that a remainder is made of."""
    speed = np.gradient(simulated.position)
    now = [
        simulated.pressure,
        simulated.position,
        speed,
        np.gradient(simulated.pressure),
        signal,
        np.abs(signal),
    ]
    late = [
        np.concatenate([np.full(lag, column[0]), column[:-lag]])
        for column in (simulated.pressure, speed, signal)
        for lag in LAGS
    ]
    return np.array([*now, *late]).T


def remainder(columns: Floats, left: Floats, rows: np.ndarray, penalties: tuple[float, ...]) -> Floats:
    """Return what a ridge regression over some rows says of every row, by the best of some penalties."""
    normed = (columns - columns[rows].mean(axis=0)) / columns[rows].std(axis=0)
    quarters = np.array_split(rows, QUARTERS)

    def missed(penalty: float) -> float:
        return sum(
            float(np.sum((left - normed @ ridge(normed, left, np.setdiff1d(rows, one), penalty))[one] ** 2))
            for one in quarters
        )

    return np.asarray(normed @ ridge(normed, left, rows, min(penalties, key=missed)))


def ridge(columns: Floats, left: Floats, rows: np.ndarray, penalty: float) -> Floats:
    """Return the coefficients of a ridge regression over some rows."""
    a = columns[rows]
    return np.asarray(np.linalg.solve(a.T @ a + penalty * len(a) * np.eye(a.shape[1]), a.T @ left[rows]))


def _text(rows: tuple[int, int]) -> str:
    return f"{rows[0]}–{rows[1] - 1}"


def _told(found: Floats) -> str:
    """Return mean and spread over the repeats."""
    means, spreads = found.mean(axis=0), found.std(axis=0)
    return " | ".join(f"{mean:.3f} ± {spread:.3f}" for mean, spread in zip(means, spreads, strict=True))


if __name__ == "__main__":
    main()
