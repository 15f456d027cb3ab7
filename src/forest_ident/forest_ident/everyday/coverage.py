"""Choose the parts that tell most within a budget of simulated time, and hold some out to judge by.

    gain = sum over kinds of log(1 + seconds of that kind), per second of the part

A kind is an axis, a direction and a third of the valve's opening. So the third hour of the same motion gains
little beside the first minute of another.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.types import Floats
from forest_ident.everyday.segments import Segment
from forest_ident.measurements.session import Session

BUDGET = 240.0  # [s] that is fitted: longer, and a fit takes minutes
EVERY = 5  # one of so many is held out
EDGES = (0.0, 1.0 / 3.0, 2.0 / 3.0, np.inf)  # of the opening


class Chosen(NamedTuple):
    """Parts for the fit, and parts to judge it by."""

    fitted: list[Segment]
    held_out: list[Segment]
    unused: float  # [s] of parts beyond the budget

    def left_out(self) -> list[str]:
        """Return in words what the budget leaves out."""
        return [f"{self.unused:.0f} s of parts like those that were used"] if self.unused > 0.0 else []


def chosen(machine: Machine, found: Sequence[Segment], budget: float = BUDGET) -> Chosen:
    """Return the parts that tell most, in the order in which they were driven."""
    kinds = np.array([seconds_by_kind(machine, one.session) for one in found])
    lengths = np.array([one.session.time[-1] for one in found])
    told, picked, left = np.zeros(kinds.shape[1]), list[int](), list(range(len(found)))
    while left and float(lengths[picked].sum()) < budget:
        gains = [float(np.sum(np.log1p(told + kinds[k]) - np.log1p(told))) / lengths[k] for k in left]
        best = left.pop(int(np.argmax(gains)))
        picked.append(best)
        told = told + kinds[best]
    held = {k for place, k in enumerate(picked) if place % EVERY == EVERY - 1}
    return Chosen(
        fitted=[found[k] for k in sorted(set(picked) - held)],
        held_out=[found[k] for k in sorted(held)],
        unused=float(lengths[left].sum()),
    )


def seconds_by_kind(machine: Machine, session: Session) -> Floats:
    """Return how long each axis was open each way, by thirds of the opening [s]."""
    seconds = []
    for axis in range(3):
        law = machine.valve_of(axis).law
        for sign, way in ((1.0, law.forward), (-1.0, law.backward)):
            opening = (sign * session.voltages[:, axis] - way.deadband_voltage) / (
                way.rated_voltage - way.deadband_voltage
            )
            rows, _ = np.histogram(opening[opening > 0.0], EDGES)
            seconds += [session.period * float(count) for count in rows]
    return np.array(seconds)
