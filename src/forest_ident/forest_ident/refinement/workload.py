"""The share of a fit that is done, by simulations: those counted, and those that are still expected.

    share = done / (done + rest of r * this record + r * later records)

| symbol | name |
|---|---|
| done | simulations counted, times their records' lengths |
| r | simulations counted over expected, of the records so far and `PRIOR` that went as expected |

How many simulations a search takes, only its end tells: a plant that sticks takes twice as many as another.
"""

from collections.abc import Sequence

import numpy as np

from forest_description.machine import Machine
from forest_ident.measurements.session import Session
from forest_ident.refinement.refinement_task import simulations

PRIOR = 2.0  # records
UNENDED = 0.25  # of what a record was expected to take, that is left at least until its search ends


class Workload:
    """Simulations of the records of a fit, in the order in which they are fitted."""

    def __init__(self, machine: Machine, sessions: Sequence[Session]) -> None:
        """Estimate what each record takes.

        Args:
            machine: to be fitted.
            sessions: in their order.
        """
        self._rows = np.array([float(len(s.time)) for s in sessions])
        self._expected = np.array([simulations(machine, s) for s in sessions])
        self._counted = np.zeros(len(sessions))

    def count(self, place: int) -> int:
        """Count a simulation of the record at a place; return how many it has had."""
        self._counted[place] += 1
        return int(self._counted[place])

    def share(self, place: int) -> float:
        """Return the share of all that is done, while the record at a place is fitted."""
        rows, expected, counted = self._rows, self._expected, self._counted
        weights = rows * expected
        prior = PRIOR * float(np.mean(weights))
        known, taken = (prior + float(rows[:place] @ column[:place]) for column in (expected, counted))
        here = max(taken / known * expected[place] - counted[place], UNENDED * expected[place])
        over = max(float(counted[place] - expected[place]), 0.0)
        later = (taken + rows[place] * over) / known * float(np.sum(weights[place + 1 :]))
        done = float(rows @ counted)
        return float(done / (done + rows[place] * here + later))
