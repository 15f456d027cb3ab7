"""What a run came to: false alarms before the fault, and what was told after it."""

import math
from collections.abc import Collection

import numpy as np

from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.diagnosis import monitor_readings, residual_limits, residuals
from forest_ident.diagnosis.findings import Alarms, findings, out_from_the_start
from forest_ident.diagnosis.sequential_test import HIGHEST
from forest_ident.diagnosis.signatures import CAUSES, MACHINE_FILE
from forest_study.diagnosis.diagnosis_trial import Run, begins_at, monitored
from forest_study.diagnosis.faults import HEALTH, injected, right_causes
from forest_study.diagnosis.monitored_loop import FROZEN, MISSING, SENSORS

TOLD = (*(cause.name for cause in CAUSES), MACHINE_FILE.name, "frozen", "missing")
CERTAIN = HIGHEST  # score of a sensor that is frozen or missing


def diagnosed(machine: Machine, case: str, seed: int, duration: float) -> dict[str, float]:
    """Return the figures of a run.

    Args:
        machine: that is believed.
        case: one of `faults.CASES`.
        seed: of machine, work, sensors, and of the axis that is hit.
        duration: [s].
    """
    begins = math.inf if case == HEALTH else begins_at(seed, duration)
    run = monitored(machine, seed, duration, injected(case, seed), begins)
    return figures(run, right_causes(case, seed))


def figures(run: Run, right: Collection[str]) -> dict[str, float]:
    """Return a run's figures; NaN where it has no part without, or with, a fault.

    Args:
        run: rows of the monitor.
        right: findings that name the fault.
    """
    begun = math.ceil(min(run.begins, len(run.rows)))
    told = [_told(row) for row in run.rows]
    size = _size(run.rows)
    before = told[begun - 1] if begun else set()
    onsets = sum(
        len(now - last) for last, now in zip([set(), *told[: begun - 1]], told[:begun], strict=False)
    )
    new = [now - before for now in told[begun:]]
    first = next((k for k, now in enumerate(new) if now), None)
    every = set().union(*new)
    is_faulty = begun < len(run.rows)
    found = {
        "healthy_h": begun / 3600.0,
        "false_alarms": float(onsets),
        "healthy_score": float(size[:begun].max()) if begun else math.nan,
        "faulty_h": (len(run.rows) - begun) / 3600.0,
        "faulty_score": float(_risen(run.rows, begun)) if is_faulty else math.nan,
        "detected": float(first is not None) if is_faulty else math.nan,
        "time_to_detect_s": float(begun + first + 1 - run.begins) if first is not None else math.nan,
        "named": float(any(one in every for one in right)) if is_faulty else math.nan,
        "alone": float(bool(every) and every <= set(right)) if is_faulty else math.nan,
    }
    causes = {one.split(" ", 1)[1] for one in every}
    return found | {f"told {cause}": float(cause in causes) for cause in TOLD}


def _told(row: Floats) -> set[str]:
    """Return the findings of a row, as "boom spool"."""
    n = residuals.COUNT
    scores = dict(zip(residuals.NAMES, row[n : 2 * n].tolist(), strict=True))
    sensors = dict(
        zip(monitor_readings.CHANNELS, row[SENSORS : SENSORS + monitor_readings.COUNT].tolist(), strict=True)
    )
    alarms = Alarms(
        residuals={name: x for name, x in scores.items() if abs(x) >= 1.0},
        frozen=[name for name, x in sensors.items() if x == FROZEN],
        missing=[name for name, x in sensors.items() if x == MISSING],
        at_start=out_from_the_start(row[2 * n : 3 * n].tolist(), residual_limits.LIMITS),
    )
    return {f"{one.part} {one.cause}" for one in findings(alarms)}


def _all(rows: Floats) -> Floats:
    """Return the scores of residuals and sensors [N, columns], without signs."""
    n = residuals.COUNT
    sensors = np.where(rows[:, SENSORS : SENSORS + monitor_readings.COUNT] > 0.0, CERTAIN, 0.0)
    scores: Floats = np.hstack([np.abs(rows[:, n : 2 * n]), sensors])
    return scores


def _size(rows: Floats) -> Floats:
    """Return the greatest score of each row."""
    greatest: Floats = _all(rows).max(axis=1)
    return greatest


def _risen(rows: Floats, begun: int) -> float:
    """Return the greatest score since a fault of what had not its alarm before."""
    scores = _all(rows)
    well = scores[max(0, begun - 1)] < 1.0 if begun else np.ones(scores.shape[1], dtype=bool)
    return float(scores[begun:, well].max(initial=0.0))
