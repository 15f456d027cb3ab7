"""How finely a machine is stepped: long steps mostly, short ones after a command has jumped.

What an even step of 1 ms gets wrong is the ring of the hoses (91 Hz) after a jump of a spool;
elsewhere the motion is slow, and steps of 1.67 ms do as well. On the work of `benchmarks/`, 12 400
steps so spent leave 3.3e-6 rad and 0.028 MPa, 20 000 even ones 7.2e-6 rad and 0.036 MPa. The jumps
are those of the commands: what else makes hoses ring, a piston on its stop or a relief valve that
opens, meets the long steps.
"""

import math
from typing import NamedTuple

import numpy as np

from forest_description.types import Bools, Floats

LONGEST = 5e-3 / 3.0  # [s] of a step
FINER = 3  # short steps in a long one
RING = 0.04  # [s] for which they stay short
JUMP = 0.3  # [V] from one long step to the next: more than a lever's or a fast sinusoid's way
ROUNDING = 1e-9


class StepSchedule(NamedTuple):
    """How many steps of which length every row of a record has."""

    steps: Floats  # [N] s
    counts: Floats  # [N], whole numbers


def even(step: float, rows: int, count: int) -> StepSchedule:
    """Return the same steps [s] for all rows."""
    return StepSchedule(np.full(rows, step), np.full(rows, float(count)))


def schedule_of(schedule: StepSchedule | float, rows: int, steps: int) -> StepSchedule:
    """Return a schedule as it is, or the one of even steps [s] that has so many steps in so many rows."""
    return schedule if isinstance(schedule, StepSchedule) else even(schedule, rows, steps // rows)


def long_steps(period: float) -> int:
    """Return how many long steps a row of a period [s] has."""
    return max(1, math.ceil(period / LONGEST - ROUNDING))


def ringing_rows(period: float) -> int:
    """Return for how many rows of a period [s] the steps stay short."""
    return max(1, math.ceil(RING / period - ROUNDING))


def jumps(table: Floats, before: Floats, rows: int) -> Bools:
    """Return which rows begin or contain a jump of a command.

    Args:
        table: voltages of all rows' long steps [V], shape (steps, 3).
        before: those of the step before them [V], shape (3,).
        rows: how many there are.
    """
    moves = np.abs(np.diff(table, axis=0, prepend=before[np.newaxis, :])).max(axis=1)
    found: Bools = (moves > JUMP).reshape(rows, -1).any(axis=1)
    return found


def after_jumps(jumped: Bools, period: float) -> StepSchedule:
    """Return the schedule of rows of a period [s], given which of them begin or contain a jump."""
    ringing = np.convolve(jumped, np.ones(ringing_rows(period)))[: len(jumped)] > 0.5
    counts = np.where(ringing, FINER, 1.0) * long_steps(period)
    return StepSchedule(period / counts, counts)


def middles(schedule: StepSchedule, start: float) -> Floats:
    """Return the time [s] in the middle of every step; rows follow each other from `start` [s] on."""
    counts = schedule.counts.astype(np.int64)
    begins = start + np.cumsum(schedule.steps * schedule.counts) - schedule.steps * schedule.counts
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    middle: Floats = np.repeat(begins, counts) + (within + 0.5) * np.repeat(schedule.steps, counts)
    return middle
