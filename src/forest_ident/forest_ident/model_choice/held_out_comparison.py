"""Does a richer model predict held-out records better? It is kept only then.

    d_b = sum over signals of (e_b^2 - f_b^2) / mean e^2,  over blocks b of `BLOCK` seconds

| symbol | name |
|---|---|
| e, f | error of a signal predicted by the model as it is, and by the richer one |
| gain | mean of d_b over the number of signals: share of the squared error that is gone |

Blocks are taken as independent. Angles do not count: they sum up the errors of speeds, so that blocks depend
on each other.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.measurements.session import Session
from forest_ident.validation.prediction_error import Signal, signals

BLOCK = 2.0  # [s] longer than what rings after a change of speed
LEAST = 0.02  # share of the squared error that must be gone
SURE = 2.0  # standard errors


class Comparison(NamedTuple):
    """How much better the richer model predicts."""

    gain: float
    error: float  # its standard error
    blocks: int

    @property
    def better(self) -> bool:
        """Whether the richer model is to be kept."""
        return self.gain > max(LEAST, SURE * self.error)

    def told(self) -> str:
        """Return the gain in words."""
        way = "lower" if self.gain >= 0.0 else "higher"
        return (
            f"squared errors of the held-out records are {100.0 * abs(self.gain):.0f} % {way} "
            f"(standard error {100.0 * self.error:.0f} %)"
        )


def compare(poorer: Machine, richer: Machine, held_out: Sequence[Session]) -> Comparison:
    """Return how much better a model predicts held-out records than another.

    Args:
        poorer: the model as it is.
        richer: the one that must be better to be kept.
        held_out: records of the crane that neither was fitted to.

    Raises:
        SessionError: a record cannot be predicted.
        ValueError: there is none.
    """
    if not held_out:
        raise ValueError("no held-out record; allowed: one at least, as `validation`")
    gains = np.concatenate([_gains(signals(poorer, one), signals(richer, one), one) for one in held_out])
    error = float(np.std(gains, ddof=1)) / math.sqrt(len(gains)) if len(gains) > 1 else math.inf
    return Comparison(float(np.mean(gains)), error, len(gains))


def _gains(before: list[Signal], after: list[Signal], session: Session) -> Floats:
    """Return d_b over the number of signals."""
    rows = max(1, round(BLOCK / session.period))
    pairs = [(e, f) for e, f in zip(before, after, strict=True) if e.name != "angle"]
    gains = [_gain(e.measured - e.predicted, f.measured - f.predicted, rows) for e, f in pairs]
    return np.asarray(np.mean(gains, axis=0), dtype=np.float64)


def _gain(e: Floats, f: Floats, rows: int) -> Floats:
    whole = len(e) // rows * rows
    squares = [np.mean((error[:whole] ** 2).reshape(-1, rows), axis=1) for error in (e, f)]
    return np.asarray((squares[0] - squares[1]) / np.mean(squares[0]))
