"""What segments say as a machine file: which numbers are told, which have drifted, whether to believe it.

A number is told if its interval is at most `NARROWER` of what was known before; else the start's stays. It
has drifted if the start's lies outside an interval so wide that all of them together miss by chance in 5 %.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_ident.estimators.parameter_estimate import Estimate, excitation_for, unit_of
from forest_ident.everyday import numbers
from forest_ident.everyday.segment_fit import Found
from forest_ident.everyday.segments import Segment
from forest_ident.measurements.parameter_path import part_of
from forest_ident.model_choice.held_out_comparison import SURE, Comparison
from forest_ident.output_error.fit_problem import Unknown
from forest_ident.refinement import possible_numbers, stated_numbers
from forest_ident.refinement.refinement_task import INERTIAS
from forest_ident.refinement.result import Result
from forest_ident.validation import prediction_error
from forest_ident.validation.prediction_error import Signal, over_limit
from forest_ident.validation.verdict import BUT_FOR, NOT_TRUSTED, TRUSTED, Verdict

NARROWER = 0.5  # times what was known before
MISSED = 0.05  # chance that one number or more is called drifted, and none has
ODD = 1.0 / 3.0  # of the segments


class Row(NamedTuple):
    """A number that the segments tell."""

    estimate: Estimate
    start: float
    drifted: bool

    @property
    def change(self) -> str:
        """The change in per cent of the start's number."""
        return f"{100.0 * (self.estimate.value / self.start - 1.0):+.2f} %"


class Told(NamedTuple):
    """What a fit from driving comes to."""

    result: Result
    rows: list[Row]
    untold: list[tuple[str, str]]  # numbers, and the motion that tells them


def told(start: Machine, found: Found, method: str) -> Told:
    """Return what is told, as a result for the machine file; method: of its sources."""
    result = Result(start, numbers.prepared(start))
    asked = [u for u in found.unknowns if u.begun]
    clear = [u for u in found.unknowns if found.errors[u.key] <= NARROWER * u.prior]
    result.estimates = {u.key: _estimate(u, found, method) for u in asked if u in clear}
    stated = [u for u in clear if u not in asked and u.key not in numbers.SENSORS]
    result.told = {u.key: _estimate(u, found, method) for u in stated}
    values = {e.key: e.value for e in (*result.estimates.values(), *result.told.values())}
    factors = {key.partition(".")[0]: values.pop(key) for key in INERTIAS if key in values}
    applied = possible_numbers.applied(result, values)
    result.machine = stated_numbers.with_inertias(applied, factors)
    far = float(scipy.stats.norm.ppf(1.0 - 0.5 * MISSED / max(len(asked), 1)))
    rows = [
        Row(
            result.estimates[u.key],
            u.start,
            abs(math.log(found.values[u.key] / u.start)) > far * found.errors[u.key],
        )
        for u in asked
        if u.key in result.estimates
    ]
    untold = [(u.key, excitation_for(u.key)) for u in asked if u not in clear]
    return Told(result, rows, untold)


def _estimate(u: Unknown, found: Found, method: str) -> Estimate:
    value, sd = found.values[u.key], found.errors[u.key]
    return Estimate(
        key=u.key,
        value=value,
        standard_error=sd * value if u.positive else sd,
        unit="1" if u.key in INERTIAS else unit_of(u.key),
        condition=1.0,
        method=method,
        positive=u.positive,
    )


def held_out_signals(machine: Machine, held_out: Sequence[Segment]) -> list[Signal]:
    """Return the signals of all held-out segments, one after the other, but for speeds.

    Raises:
        SessionError: a segment cannot be predicted.
    """
    every = (signal for one in held_out for signal in prediction_error.signals(machine, one.session))
    parts = [signal for signal in every if signal.name != "velocity"]  # of slow work mostly noise
    names = dict.fromkeys((s.axis, s.name, s.unit) for s in parts)
    return [
        Signal(
            *name, *(_joined([s for s in parts if (s.axis, s.name, s.unit) == name], side) for side in (3, 4))
        )
        for name in names
    ]


def _joined(parts: Sequence[Signal], side: int) -> Floats:
    return np.concatenate([np.asarray(part[side], dtype=np.float64) for part in parts])


def verdict(told: Told, found: Found, signals: Sequence[Signal], gain: Comparison) -> Verdict:
    """Return how far to trust what is told: by held-out segments, what was odd, the search, and friction."""
    reasons = [f"held-out segments: {text}" for text in over_limit(signals)]
    if gain.gain < -SURE * gain.error:
        reasons.append(f"{gain.told()} than with the start's numbers")
    if len(found.odd) > ODD * (found.segments + len(found.odd)):
        reasons.append(f"{len(found.odd)} of {found.segments + len(found.odd)} segments fit nothing")
    if not found.converged:
        reasons.append("the search was broken off")
    if sticking := [axis for axis in AXES if part_of(told.result.start, f"{axis}.friction")]:
        reasons.append(
            f"dry friction of {', '.join(sticking)}: intervals of such a crane come out too narrow"
        )
    doubts = dict.fromkeys(told.result.impossible, "its estimate is impossible")
    code = NOT_TRUSTED if reasons else BUT_FOR if doubts else TRUSTED
    return Verdict(code, tuple(reasons), doubts)
