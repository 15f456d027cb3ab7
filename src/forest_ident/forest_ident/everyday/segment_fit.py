"""Fit the machine's numbers to all segments at once: each is predicted by itself, from its own rest on.

What a prediction gets wrong at its start (a crane that still rocks, the mean of noisy angles) stays within
its segment: `clusters` counts it in the intervals.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_ident.everyday import clusters, numbers
from forest_ident.everyday.segments import Segment
from forest_ident.measurements.parameter_path import with_values
from forest_ident.measurements.session import SessionError
from forest_ident.output_error import noise_model
from forest_ident.output_error.fit_problem import Channel, Columns, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import EMPTY
from forest_ident.output_error.output_error import BLOCK, REFUSED
from forest_ident.output_error.prediction import Offsets, predict
from forest_ident.output_error.search import Search
from forest_ident.refinement.refinement_task import INERTIAS
from forest_ident.refinement.stated_numbers import with_inertias

PORTS = tuple(f"{axis}_pressure_{port}_actuator" for axis in AXES for port in (1, 2))
CHANNELS = (
    *(f"{axis}_resolver" for axis in AXES),
    *(f"{axis}_transducer" for axis in AXES[1:]),
    *PORTS,
    *("swing_flow", "stick_flow", "supply_pressure", "case_drain"),
)
COUNTED = 0.1  # [s] between two rows that count: what a start leaves lasts longer
BEGINNING = 1.5  # [s] of motion
LEFT = 10.0  # times a sensor's noise, that a prediction may leave: the search goes on until then
ROCKING = 2e4  # [Pa] of the ports' pressures in a crane that rocks a little at the start
STEPS = 12  # of a search; what is left then counts in the intervals
ODD = 5.0  # times the usual mean square of a segment's residuals, and 1: something else happened there


class Found(NamedTuple):
    """What the segments say."""

    unknowns: list[Unknown]
    values: dict[str, float]
    errors: dict[str, float]  # standard errors; of positive numbers relative
    odd: list[Segment]  # left out: nothing that was fitted explains them
    segments: int  # that were fitted
    converged: bool

    def left_out(self) -> list[str]:
        """Return in words which segments were left out."""
        return [f"{one.bag} at {one.begin:.0f} s: nothing that was fitted explains it" for one in self.odd]


def found(
    machine: Machine,
    segments: Sequence[Segment],
    stated: Mapping[str, float],
    progress: Callable[[], None] = lambda: None,
) -> Found:
    """Return what segments say of a prepared machine; those that fit nothing are left out once.

    The search begins with the segments' beginnings, in which errors of a far-off start have not summed up:
    where much has drifted it takes a third of the time.

    Args:
        machine: prepared (`numbers.prepared`).
        segments: of it.
        stated: half-widths [SI] of the 95 % intervals that the start's file states, by dotted key.
        progress: called after every simulation of all segments.

    Raises:
        SessionError: no sensor reads all the time.
    """
    unknowns = numbers.unknowns(machine, stated, segments[0].session)
    begun = [u for u in unknowns if u.begun]
    early, _ = _fitted(machine, [_beginning(one) for one in segments], begun, progress)
    later = [u._replace(start=early.values.get(u.key, u.start), begun=False) for u in unknowns]
    first, squares = _fitted(machine, segments, later, progress)
    first = first._replace(unknowns=unknowns)
    is_odd = squares > max(1.0, ODD * float(np.median(squares)))
    if not is_odd.any():
        return first
    odd, kept = (
        [one for one, is_so in zip(segments, is_odd, strict=True) if is_so == side] for side in (True, False)
    )
    return _fitted(machine, kept, later, progress)[0]._replace(unknowns=unknowns, odd=odd)


def _beginning(segment: Segment) -> Segment:
    last = segment.opening + round(BEGINNING / segment.session.period)
    return segment._replace(session=segment.session.part(0, last))


def _fitted(
    machine: Machine, segments: Sequence[Segment], unknowns: list[Unknown], progress: Callable[[], None]
) -> tuple[Found, Floats]:
    """Return what segments say, and the mean square of the residuals of each, over their channels' noise."""
    channels = _channels(machine, segments)
    measured = _stacked(segments, [_measured(one, channels) for one in segments], channels)
    problem = Problem(measured=measured, channels=channels, unknowns=unknowns, block=BLOCK, prior=EMPTY)

    def model(values: Mapping[str, float]) -> Columns:
        return _stacked(segments, predicted(machine, segments, values), channels)

    search = Search(model, model, problem, unknowns, channels, progress, (), (), most=STEPS)
    end = search.end(np.zeros((len(problem.names), 0)))
    theta, columns = end.at.theta, end.at.predicted
    starts = _starts(segments)
    told = clusters.normal(problem, theta, columns, end.jacobian, starts)
    away = problem.known @ (theta - problem.mean)
    sds = clusters.errors(told, problem.known, away)[: problem.count].tolist()
    errors = {u.key: sd for u, sd in zip(unknowns, sds, strict=True)}
    residuals = np.array(list(problem.residuals(theta, columns).values()))
    squares = np.array([float(np.nanmean(part**2)) for part in np.split(residuals, starts[1:], axis=1)])
    values = problem.values(theta)
    left = clusters.untaken(told, problem.known, away)
    ended = end.converged or left.promise < REFUSED * problem.cost(theta, columns)
    return Found(unknowns, values, errors, [], len(segments), ended), squares


def _starts(segments: Sequence[Segment]) -> list[int]:
    """Return the first row of each segment among those that count."""
    lengths = [len(one.session.time[:: _every(one)]) for one in segments]
    return [int(first) for first in np.cumsum([0, *lengths[:-1]])]


def _every(segment: Segment) -> int:
    """Return after how many rows the next one counts."""
    return max(1, round(COUNTED / segment.session.period))


def predicted(
    machine: Machine, segments: Sequence[Segment], values: Mapping[str, float]
) -> list[dict[str, Floats]]:
    """Return what a machine with these values would have read in each segment."""
    offsets = Offsets(*(values.get(name, 0.0) for name in numbers.SENSORS))
    return [predict(with_numbers(machine, values), one.session, offsets) for one in segments]


def with_numbers(machine: Machine, values: Mapping[str, float]) -> Machine:
    """Return the machine with other numbers; factors of inertia count as such, errors of sensors not."""
    factors = {key.partition(".")[0]: values[key] for key in INERTIAS if key in values}
    own = {key: value for key, value in values.items() if key not in (*INERTIAS, *numbers.SENSORS)}
    # The load chart moves nothing, and would refuse lengths that are moved a little.
    return with_inertias(with_values(dataclasses.replace(machine, capacity=None), own), factors)


def _channels(machine: Machine, segments: Sequence[Segment]) -> list[Channel]:
    """Return the channels that all segments have; a start's angle is read, so it cancels a static error.

    Raises:
        SessionError: there is no joint's.
    """
    there = [name for name in CHANNELS if all(one.session.has(name) for one in segments)]
    channels = [noise_model.channel(machine, segments[0].session, name) for name in there]
    if not all(f"{axis}_resolver" in there for axis in AXES):
        raise SessionError("a fit from driving takes the angles of all joints")
    freed = [c._replace(offset=0.0, run="") if c.run else c for c in channels]
    return [c._replace(noise=LEFT * max(c.noise, ROCKING if c.name in PORTS else 0.0)) for c in freed]


def _measured(segment: Segment, channels: Sequence[Channel]) -> dict[str, Floats]:
    """Return what the channels read; at rest pressures are the prediction's start, and do not count."""
    columns = {c.name: segment.session.column(c.name) for c in channels}
    rest = np.arange(len(segment.session.time)) < segment.opening
    return {name: np.where(rest, np.nan, y) if name in PORTS else y for name, y in columns.items()}


def _stacked(
    segments: Sequence[Segment], parts: Sequence[Mapping[str, Floats]], channels: Sequence[Channel]
) -> dict[str, Floats]:
    """Return the columns of all segments, one after the other, as far as rows count."""
    pairs = [(part, _every(one)) for one, part in zip(segments, parts, strict=True)]
    return {c.name: np.concatenate([part[c.name][::every] for part, every in pairs]) for c in channels}
