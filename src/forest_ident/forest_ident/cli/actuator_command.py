"""`forest-ident actuator`: one actuator of our physics, fitted to one record, predicts another."""

import argparse
import csv
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from forest_compile.kernel_cache import can_compile
from forest_description.types import Floats
from forest_ident.actuator import fit, record
from forest_ident.actuator.fit import Columns, Fit
from forest_ident.actuator.priors import PRIORS, actuator, unit, unit_factor
from forest_ident.actuator.record import Record, RecordError, Scales
from forest_ident.validation.prediction_error import rms
from forest_msgs_py.runtime.command_line import Subcommands, subcommand, whole

STARTS, STARTS_INTERPRETED = 32, 1
IDENTIFIED = 0.8  # of a prior's width: a parameter with a smaller standard error is identified


def add_parser(verbs: Subcommands) -> None:
    """Name the verb's flags."""
    text = "fit one actuator of our physics to a CSV record and simulate another from its valve signal"
    parser = subcommand(verbs, "actuator", text, run)
    columns = "columns sample, valve, pressure, position"
    parser.add_argument("--fit", type=Path, required=True, metavar="TRAIN.csv", help=columns)
    help_test = "columns sample, valve; pressure, where it is there, is compared and never used"
    parser.add_argument("--simulate", type=Path, required=True, metavar="TEST.csv", help=help_test)
    help_out = "directory of prediction.csv, actuator.json and prediction.png"
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help=help_out)
    help_starts = f"starting points of the fit (default: {STARTS}; without llvmlite {STARTS_INTERPRETED})"
    parser.add_argument("--starts", type=whole(1), metavar="N", help=help_starts)
    help_cross = "also fit parts of TRAIN and predict the rest; the table goes into actuator.json"
    parser.add_argument("--cross-validate", action="store_true", help=help_cross)


def run(options: argparse.Namespace) -> int:
    """Run the verb; return its exit code.

    Raises:
        RecordError: a file cannot be used; the sentence says where.
    """
    train, test = record.read(options.fit), record.read(options.simulate, whole=False)
    scales = record.scales(train)
    if options.out.exists() and not options.out.is_dir():
        raise RecordError(f"{options.out} is no directory; choose another --out")
    options.out.mkdir(parents=True, exist_ok=True)
    starts = options.starts or (STARTS if can_compile() else STARTS_INTERPRETED)
    if not can_compile():
        _say("llvmlite is not installed (extra 'fast'): each start takes minutes instead of a second")
    trained_on = scaled(train, scales)
    problem = fit.Problem(trained_on)
    fits = fit.fit_from_many_starts(problem, starts, progress=lambda i, one: _tell(i, starts, one))
    kept = fit.similar(fits)
    lead, began = before(train, test)
    _say(began)
    predicted = predicted_pressure(kept, np.concatenate([lead, test.valve]), scales)[len(lead) :]
    found = report(problem, fits, kept, scales, trained_on) | {
        "train": str(options.fit),
        "test": str(options.simulate),
        "test_starts": began,
        "rms_test": None if test.pressure is None else rms(predicted - test.pressure),
    }
    if options.cross_validate:
        found["cross_validation"] = _folds(trained_on, scales, min(starts, 8))
    _write(options.out, test, predicted, found)
    return 0


def scaled(record: Record, s: Scales) -> Columns:
    """Return a record in the units of the priors."""
    assert record.pressure is not None
    assert record.position is not None
    pressure = (record.pressure - s.pressure_zero) / s.pressure
    return Columns(record.valve / s.valve, pressure, (record.position - s.position_zero) / s.position)


def predicted_pressure(fits: list[Fit], valve: Floats, s: Scales) -> Floats:
    """Return the pressure in the record's unit, freely from the valve's signal, from rest."""
    return s.pressure_zero + s.pressure * fit.predicted(fits, valve / s.valve)


def before(train: Record, test: Record) -> tuple[Floats, str]:
    """Return the valve's signal from TRAIN's first sample up to TEST's, and how TEST begins.

    Where TRAIN does not lead up to TEST without a gap, TEST begins at rest.
    """
    first = int(test.samples[0])
    if int(train.samples[0]) < first <= int(train.samples[-1]) + 1:
        return train.valve[: first - int(train.samples[0])], "state carried on from TRAIN's valve signal"
    return np.empty(0), "at rest, since TRAIN does not lead up to its first sample"


def report(
    problem: fit.Problem, fits: list[Fit], kept: list[Fit], s: Scales, record: Columns
) -> dict[str, Any]:
    """Return what actuator.json says of the fit: values in the record's units, of the best fit."""
    best = kept[0]
    errors = fit.standard_errors(problem, best)
    given = actuator(best.z.tolist())
    values = {"dead_time": given.dead_time, **given.parameters._asdict()}
    parameters = {}
    for prior, z, error in zip(PRIORS, best.z.tolist(), errors.tolist(), strict=True):
        factor = unit_factor(prior, s.valve, s.pressure, s.position)
        ends = (z - 1.96 * error, z + 1.96 * error)
        parameters[prior.name] = {
            "value": factor * values[prior.name],
            "interval_95": [factor * float(np.exp(end) if prior.positive else end) for end in ends],
            "unit": unit(prior),
            "told_by_record": error < IDENTIFIED * prior.width,
        }
    return {
        "parameters": parameters,
        "rms_train": s.pressure * rms(fit.predicted(kept, record.signal) - record.pressure),
        "rms_train_best_fit": s.pressure * rms(problem.residuals(best.z)[0]),
        "rms_train_position": s.position * rms(problem.residuals(best.z)[1]),
        "prediction": f"mean of {len(kept)} fits within {fit.SIMILAR:g} of the best cost",
        "costs": [round(fit.cost, 3) for fit in fits],
        "scales": s._asdict(),
    }


def _folds(record: Columns, s: Scales, starts: int) -> list[dict[str, Any]]:
    return [
        f._asdict() | {"rms_fitted": s.pressure * f.rms_fitted, "rms_held_out": s.pressure * f.rms_held_out}
        for f in fit.cross_validated(record, starts, _say)
    ]


def _write(out: Path, test: Record, predicted: Floats, found: dict[str, Any]) -> None:
    with (out / "prediction.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("sample", "pressure"))
        writer.writerows(zip(test.samples.tolist(), (f"{p:.6f}" for p in predicted.tolist()), strict=True))
    text = json.dumps(found, indent=2)
    (out / "actuator.json").write_text(text + "\n", encoding="utf-8")
    _plot(out / "prediction.png", test, predicted)
    ending = "" if found["rms_test"] is None else f"; on TEST: {found['rms_test']:.4f}"
    print(f"RMS of pressure on TRAIN: {found['rms_train']:.4f}{ending}")
    for fold in found.get("cross_validation", []):
        (first, end), (begin, stop) = fold["held_out"], fold["fitted"]
        rows = f"rows {first} to {end - 1}, fitted to {begin} to {stop - 1}"
        print(f"held out, {rows}: RMS {fold['rms_held_out']:.4f}")
    unidentified = [name for name, p in found["parameters"].items() if not p["told_by_record"]]
    if unidentified:
        print(f"this record hardly tells: {', '.join(unidentified)}")
    print(f"  {out / 'prediction.csv'}\n  {out / 'actuator.json'}\n  {out / 'prediction.png'}")


def _plot(path: Path, test: Record, predicted: Floats) -> None:
    """Write a PNG: the valve's signal above, pressure below, measured solid and predicted dotted."""
    from matplotlib.figure import Figure  # takes half a second

    figure = Figure(figsize=(10, 5), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1, 2.5))
    above.plot(test.samples, test.valve, "k", linewidth=1.0)
    above.set_ylabel("valve")
    if test.pressure is not None:
        below.plot(test.samples, test.pressure, "k", linewidth=1.2, label="measured")
    below.plot(test.samples, predicted, "r:", linewidth=1.6, label="simulated from the valve's signal")
    below.set_xlabel("sample")
    below.set_ylabel("pressure")
    below.legend(loc="upper right", fontsize=8)
    for axes in (above, below):
        axes.grid(linewidth=0.3)
    figure.savefig(path, dpi=110)


def _tell(place: int, starts: int, fit: Fit) -> None:
    _say(f"start {place + 1} of {starts}: cost {fit.cost:.1f} after {fit.iterations} steps")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
