"""What sweeps of the kind `diagnosis` say together: rates with intervals, what is told apart, pictures."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy  # its `stats` takes a second to load: only where it is used
import yaml

from forest_study.diagnosis.detection_figures import TOLD
from forest_study.diagnosis.faults import CASES, FAULTS, HEALTH, SEVERITIES
from forest_study.results import StudyError

if TYPE_CHECKING:
    from pyarrow import Table

Row = Mapping[str, Any]
LEVEL = 0.95
LOOSEST, STRICTEST, POINTS = 0.05, 4.0, 80  # [1] of the thresholds of a ROC curve


class Rate(NamedTuple):
    """A rate, and its interval at `LEVEL`."""

    value: float
    low: float
    high: float


def rows_of(directories: Sequence[Path]) -> list[Row]:
    """Return the runs of sweeps.

    Raises:
        StudyError: one is not ended, or of another kind; or runs have failed.
    """
    from pyarrow import parquet  # it takes a third of a second

    found: list[Row] = []
    for directory in directories:
        file = directory / "runs.parquet"
        if not file.is_file():
            raise StudyError(
                f"{file} is not there; allowed: the --out of sweeps of kind diagnosis that have ended"
            )
        whole = parquet.read_table(file)
        rows = whole.to_pylist()
        if "healthy_h" not in rows[0]:
            raise StudyError(f"{directory} is a sweep of another kind; allowed: diagnosis")
        failed = next((row["error"] for row in rows if row["error"]), None)
        if failed:
            raise StudyError(f"{directory}: a run has failed: {failed}")
        found += rows if "case" in rows[0] else [{"case": _common_case(whole), **row} for row in rows]
    return found


def _common_case(whole: "Table") -> str:
    """Return the case that all runs of a study have in common."""
    text: str = whole.schema.metadata[b"study"].decode()
    return str(yaml.safe_load(text).get("with", {}).get("case", HEALTH))


def per_hour(count: float, hours: float) -> Rate:
    """Return a Poisson rate; its interval is exact (Garwood), one-sided above where nothing was counted."""
    tail = 0.5 * (1.0 - LEVEL) if count else 1.0 - LEVEL
    low = scipy.stats.chi2.ppf(tail, 2.0 * count) / 2.0 if count else 0.0
    high = scipy.stats.chi2.ppf(1.0 - tail, 2.0 * count + 2.0) / 2.0
    return Rate(count / hours, float(low) / hours, float(high) / hours)


def share(count: float, of: int) -> Rate:
    """Return a binomial share; its interval is exact (Clopper and Pearson)."""
    told = scipy.stats.binomtest(round(count), of).proportion_ci(LEVEL)
    return Rate(count / of, float(told.low), float(told.high))


def report(rows: Sequence[Row]) -> dict[str, Any]:
    """Return false alarms over all healthy hours, and what was told of each fault."""
    well = [row for row in rows if row["healthy_h"] > 0.0]
    hours, alarms = sum(row["healthy_h"] for row in well), sum(row["false_alarms"] for row in well)
    cases = {}
    for case in CASES:
        own = [row for row in rows if row["case"] == case and case != HEALTH]
        if own:
            cases[case] = _case(own)
    return {
        "healthy_runs": len(well),
        "healthy_h": hours,
        "faulty_h": sum(row["faulty_h"] for row in rows),
        "false_alarms": alarms,
        "false_alarms_per_h": per_hour(alarms, hours)._asdict() if hours else None,
        "cases": cases,
    }


def _case(own: Sequence[Row]) -> dict[str, Any]:
    times = [row["time_to_detect_s"] for row in own if row["detected"] > 0.0]
    told = {cause: sum(row[f"told {cause}"] for row in own) / len(own) for cause in TOLD}
    return {
        "runs": len(own),
        "hours": sum(row["faulty_h"] for row in own),
        "detected": share(sum(row["detected"] for row in own), len(own))._asdict(),
        "time_to_detect_s": float(np.median(times)) if times else None,
        "named": sum(row["named"] for row in own) / len(own),
        "alone": sum(row["alone"] for row in own) / len(own),
        "told": {cause: part for cause, part in told.items() if part > 0.0},
    }


def table(found: Mapping[str, Any]) -> str:
    """Return the report as Markdown."""
    rate = found["false_alarms_per_h"]
    lines = [f"{found['healthy_h']:.1f} h without a fault, {found['faulty_h']:.1f} h with one"]
    if rate:
        about = f"{rate['value']:.2f} per hour, {rate['low']:.2f} to {rate['high']:.2f}"
        lines.append(f"{found['false_alarms']:.0f} false alarms: {about} at {100 * LEVEL:.0f} %")
    lines += [
        "",
        "| fault | severity | runs | detected | after, s | named | nothing else | told |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for case, own in found["cases"].items():
        name, _, severity = case.partition(", ")
        amount = FAULTS[name].text.format(FAULTS[name].amounts[SEVERITIES.index(severity)])
        after = own["time_to_detect_s"]
        told = ", ".join(
            f"{cause} {100 * part:.0f}" for cause, part in sorted(own["told"].items(), key=_least)
        )
        lines.append(
            f"| {name} | {amount} | {own['runs']} | {100 * own['detected']['value']:.0f} %"
            f" | {'' if after is None else f'{after:.0f}'} | {100 * own['named']:.0f} %"
            f" | {100 * own['alone']:.0f} % | {told} |"
        )
    return "\n".join(lines)


def _least(told: tuple[str, float]) -> float:
    return -told[1]


def draw(rows: Sequence[Row], file: Path) -> None:
    """Draw a ROC curve for each fault and severity: detection over false alarms, by the thresholds' factor.

    False alarms are the healthy stretches that reach a threshold, over all healthy hours.
    """
    from matplotlib.figure import Figure  # half a second

    faults = [name for name in FAULTS if any(row["case"].startswith(f"{name}, ") for row in rows)]
    if not faults:
        return
    healthy = [row for row in rows if row["healthy_h"] > 0.0]
    hours, sizes = (
        sum(row["healthy_h"] for row in healthy),
        np.array([row["healthy_score"] for row in healthy]),
    )
    factors = np.geomspace(LOOSEST, STRICTEST, POINTS)
    false = np.array([np.count_nonzero(sizes >= factor) / hours for factor in factors])
    columns = min(4, len(faults))
    lines = math.ceil(len(faults) / columns)
    figure = Figure(figsize=(3.0 * columns, 2.6 * lines), layout="constrained")
    grid = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
    for axes, name in zip(grid.flat, faults, strict=False):
        for severity in SEVERITIES:
            own = np.array([row["faulty_score"] for row in rows if row["case"] == f"{name}, {severity}"])
            if len(own):
                found = [np.count_nonzero(own >= factor) / len(own) for factor in factors]
                axes.plot(false, found, drawstyle="steps-post", label=severity)
        axes.axvline(float(np.count_nonzero(sizes >= 1.0) / hours), color="0.7", linewidth=1.0)
        axes.set_title(name, fontsize=10)
        axes.set_xscale("symlog", linthresh=0.1)
        axes.set_ylim(-0.03, 1.03)
    grid.flat[0].legend(fontsize=8, loc="lower right")
    for axes in grid.flat[len(faults) :]:
        axes.set_axis_off()
    figure.supxlabel("false alarms per hour", fontsize=10)
    figure.supylabel("detected", fontsize=10)
    figure.savefig(file, dpi=110)
