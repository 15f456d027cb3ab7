"""The spool as the driver knows it: a first-order lag whose rate is limited.

| symbol | name | unit |
|---|---|---|
| u | voltage that the spool goes for | V |
| y | position of the spool, as the voltage that would hold it there | V |
| T, S | time constant of the lag; slew limit of the rate | s, V/s |

The law is that of the machine file's keys `spool_bandwidth` and `spool_slew_limit`:

    dy/dt = (u - y)/T, at most S

A dead time shifts all of it: y is then the position at the time at which the next voltage starts to act.
Hysteresis is no part of it: dither takes it out (`valve_driver`).
"""

import math
from typing import NamedTuple


class SpoolLaw(NamedTuple):
    """Constants of one spool."""

    lag: float = 0.0  # T [s]; 0: at once
    slew: float = math.inf  # S [V/s]


def left(lag: float, dt: float) -> float:
    """Return the part of its way that a spool has left after dt [s]."""
    return 0.0 if lag == 0.0 else math.exp(-dt / lag)


def after(position: float, target: float, law: SpoolLaw, dt: float) -> float:
    """Return y [V] after u [V] was in force for dt [s]: the ramp at S, and from u - y = S T on the lag."""
    gap = target - position
    ramp = max(0.0, abs(gap) / law.slew - law.lag)
    if ramp == 0.0:
        return target + left(law.lag, dt) * (position - target)
    if ramp >= dt:
        return position + math.copysign(law.slew * dt, gap)
    return target - math.copysign(law.slew * law.lag, gap) * left(law.lag, dt - ramp)
