"""A motor's leakage, learnt while its valve is shut: by how much the file's is off.

Leakage goes with the oil's viscosity, which its temperature takes from a tenth to thrice. Through a shut
valve nothing flows, so what motion and compression leave over is leakage:

    o + (f - 1) l = 0

| symbol | name | unit |
|---|---|---|
| o | opening for the measured flow, with the file's leakage in it (`valve_flow`) | - |
| l | part of it that the file's leakage makes | - |
| f | leakage over the file's | - |

f is found by recursive least squares with forgetting. Without a load nothing leaks and nothing is learnt.
"""

import math
from typing import NamedTuple

from forest_control.valve.valve_flow import FlowParameters, LowPassed, correlated_samples, opening_variance

SPREAD = 1.0  # [1] standard deviation of f: oil between 20 and 70 degrees Celsius; chosen
MOST = 5.0  # [1] that f is kept within
SHUT = 0.95  # [1] of the low-pass' memory in which the valve must surely have been shut; chosen


class LeakageEstimate(NamedTuple):
    """The estimate; its variance is relative to what it starts from."""

    factor: float = 1.0  # f
    variance: float = 1.0


def opening(low: LowPassed, leakage: LeakageEstimate) -> float:
    """Return the low-passed opening for the measured flow with the leakage that is learnt."""
    return low.opening_2 + (leakage.factor - 1.0) * low.leaking_2


def spread(low: LowPassed, leakage: LeakageEstimate) -> float:
    """Return the standard deviation of that opening by the leakage's."""
    return SPREAD * math.sqrt(leakage.variance) * abs(low.leaking_2)


def updated_leakage(
    leakage: LeakageEstimate, low: LowPassed, flow: FlowParameters, forgetting_time: float, dt: float
) -> LeakageEstimate:
    """Return the estimate after one more sample, dt [s] after the last one."""
    if low.shut_2 < SHUT:
        return leakage
    seen = SPREAD * low.leaking_2
    noise = opening_variance(low, flow, dt) * correlated_samples(dt)
    total = noise + leakage.variance * seen * seen
    if total == 0.0:
        return leakage
    share = leakage.variance * seen / total
    factor = leakage.factor - SPREAD * share * opening(low, leakage)
    variance = math.exp(dt / forgetting_time) * leakage.variance * (1.0 - share * seen)
    return LeakageEstimate(max(0.0, min(MOST, factor)), min(1.0, variance))
