"""Name the physics that a model lacks, from what a fit left over.

For each record and each candidate the simulator tells how its readings would change with the candidate's
usual size. Residuals are compared with that pattern, over time and all channels together:

    s = (r d)^2 / ((r r)(d d)),  a = r d / (d d)

| symbol | name |
|---|---|
| r | residuals over their RMS, without what the record's own parameters and offsets could still explain |
| d | change of the prediction with the candidate, the same taken out |
| s | share of the residuals' squares that the candidate explains |
| a | its size over the usual one |

What the valve's rig shows is named from its records alone: on the crane, many things look like it.
So a step at zero speed and an oscillation after a stop are told apart by all rows at once, not by one plot.
"""

import contextlib
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from forest_description.config.parameter import MachineError
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.estimators import calibration
from forest_ident.measurements.parameter_path import part_of, value_of, with_values
from forest_ident.measurements.session import SessionError
from forest_ident.model_choice.candidates import CANDIDATES, Candidate
from forest_ident.output_error.prediction import predict
from forest_ident.refinement import data_quality, refinement
from forest_ident.refinement.refinement_task import task
from forest_ident.refinement.result import Refined, Result

SAID = 0.3  # share of the squares from which a candidate is named
SIZES = 0.1, 10.0  # over the usual one: another pattern than the candidate's, if beyond
LEFT = 1.5  # times a sensor's noise: smaller residuals leave nothing to name
DIFFERENCE = 1e-2  # relative, of a parameter


class Finding(NamedTuple):
    """What a record's residuals look like."""

    record: str
    candidate: Candidate
    share: float  # s
    size: float  # a

    def sentence(self) -> str:
        """Return it in words, with what to try."""
        c = self.candidate
        return (
            f"{self.record}: {100.0 * self.share:.0f} % of what the model leaves over looks like {c.physics} "
            f"({c.pattern}); try `--allow {c.name}`"
        )


def times_noise(refined: Refined) -> float:
    """Return the greatest residual of a record's channels over what noise and stated numbers leave."""
    return max((test.times for test in refined.tests), default=0.0)


def findings(result: Result) -> list[Finding]:
    """Return the best candidate of each record that one explains, the clearest first.

    A record of which nothing can be said is left out: a finished fit is not lost by it.
    """
    found = []
    for refined in result.refined:
        if times_noise(refined) <= LEFT:
            continue
        with contextlib.suppress(SessionError), data_quality.evaluated(refined.session):
            ranked = ranking(result.machine, refined)
            usual = [one for one in ranked if SIZES[0] <= one.size <= SIZES[1]]
            found += [one for one in usual[:1] if one.share >= SAID]
    return sorted(found, key=lambda one: -one.share)


def ranking(machine: Machine, refined: Refined) -> list[Finding]:
    """Return what every candidate that the machine lacks explains of a record, the best first."""
    session, scale = refined.session, refined.fit.noise
    channels = [name for name in scale if session.has(name)]
    corrected = calibration.corrected(session, machine)

    def readings(model: Machine) -> list[Floats]:
        columns = predict(refinement.prepared(model, session), corrected)
        return [columns[name] / scale[name] for name in channels]

    base = readings(machine)
    seen = [np.isfinite(refined.fit.residuals[name]) for name in channels]
    residual = np.concatenate(
        [
            (session.column(name) / scale[name] - column)[rows]
            for name, column, rows in zip(channels, base, seen, strict=True)
        ]
    )

    def change(model: Machine) -> Floats:
        after = readings(model)
        return np.concatenate([(a - b)[rows] for a, b, rows in zip(after, base, seen, strict=True)])

    known = [change(with_values(machine, {key: _moved(machine, key)})) for key in _told(machine, refined)]
    rest = _without(np.array([*_offsets(seen), *known]))
    r = rest(residual)
    found = []
    for candidate in CANDIDATES:
        if session.on_rig != candidate.rig:
            continue
        try:
            richer = candidate.add(machine)
            d = rest(change(richer)) if richer != machine else np.zeros(0)
        except MachineError:  # this crane cannot have it
            continue
        if len(d) and (power := float(d @ d)) > 0.0:
            along = float(r @ d)
            found.append(Finding(session.name, candidate, along**2 / (power * float(r @ r)), along / power))
    return sorted(found, key=lambda one: -one.share)


def _told(machine: Machine, refined: Refined) -> list[str]:
    """Return the machine's numbers that the record's fit may move, or knows only within their errors."""
    work = task(machine, refined.session)
    keys = (*refined.free, *(work.carried if work is not None else ()))
    # An axis' own valve that was tried and not taken is no part of the machine.
    return [key for key in dict.fromkeys(keys) if isinstance(part_of(machine, key), float)]


def _moved(machine: Machine, key: str) -> float:
    value = value_of(machine, key)
    return value * (1.0 + DIFFERENCE) if value else DIFFERENCE


def _offsets(seen: Sequence[Floats]) -> list[Floats]:
    """Return the pattern of a constant offset of each channel."""
    ends = np.cumsum([0, *(int(rows.sum()) for rows in seen)])
    found = []
    for first, last in pairwise(ends.tolist()):
        row = np.zeros(ends[-1])
        row[first:last] = 1.0
        found.append(row)
    return found


def _without(patterns: Floats) -> Callable[[Floats], Floats]:
    """Return what takes out of a row all that is along some patterns."""
    directions, sizes, _ = np.linalg.svd(patterns.T, full_matrices=False)
    basis = directions[:, sizes > 1e-9 * max(float(sizes[0]), 1e-300)]
    return lambda row: np.asarray(row - basis @ (basis.T @ row))
