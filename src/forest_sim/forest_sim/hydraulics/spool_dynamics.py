"""How a spool follows its voltage: at once, with a first-order lag, as a second-order system, or not at all.

| symbol | name | unit |
|---|---|---|
| x, v | spool position, as the voltage that it stands for; its rate | V, V/s |
| w, zeta | natural frequency (first order: the cut-off); damping ratio | rad/s, 1 |

The laws are linear, so that a step under a held voltage is exact. Thesis section 3.2.2 leaves the
lag out and names the cut-off, 10 to 15 Hz.
"""

import math
from typing import NamedTuple

from forest_description.components.valve_parameters import Valve


class SpoolLag(NamedTuple):
    """Constants of the law; a frequency of inf follows at once, one of 0 is a stuck spool."""

    frequency: float  # w [rad/s]
    damping: float  # zeta; 0: first order


class Spool(NamedTuple):
    """Where a spool is and how fast it moves (second order only)."""

    position: float  # [V]
    rate: float  # [V/s]


Spools = tuple[Spool, Spool, Spool]
STUCK = SpoolLag(0.0, 0.0)
CENTRED = Spool(0.0, 0.0)


def spool_lag(valve: Valve) -> SpoolLag:
    """Return the kernel's constants of a valve's spool."""
    if valve.spool_bandwidth is None:
        return SpoolLag(math.inf, 0.0)
    return SpoolLag(2.0 * math.pi * valve.spool_bandwidth, valve.spool_damping or 0.0)


def spool_after(spool: Spool, voltage: float, time: float, lag: SpoolLag) -> Spool:
    """Return a spool after a time [s] under a held voltage [V].

    Thesis section 3.2.2. Differs: the thesis takes the spool to follow at once; so does a frequency
    of inf.
    """
    if lag.frequency == 0.0:
        return spool
    if lag.damping == 0.0:
        gap = (
            (spool.position - voltage) * math.exp(-lag.frequency * time) if lag.frequency < math.inf else 0.0
        )
        return Spool(voltage + gap, 0.0)
    return _second_order(spool, voltage, time, lag)


def _second_order(spool: Spool, voltage: float, time: float, lag: SpoolLag) -> Spool:
    """Return the exact solution of x'' + 2 zeta w x' + w^2 (x - V) = 0."""
    w, zeta = lag.frequency, lag.damping
    gap, rate = spool.position - voltage, spool.rate
    decay, split = zeta * w, w * math.sqrt(abs(zeta * zeta - 1.0))
    # c(t) and s(t) solve the equation; both limits meet at zeta = 1.
    fade = math.exp(-decay * time)
    if split * time < 1e-6:
        c, s = fade, fade * time
    elif zeta < 1.0:
        c, s = fade * math.cos(split * time), fade * math.sin(split * time) / split
    else:  # as two decays: cosh and sinh of a long time would overflow
        slow, fast = math.exp((split - decay) * time), math.exp(-(split + decay) * time)
        c, s = 0.5 * (slow + fast), 0.5 * (slow - fast) / split
    return Spool(
        voltage + gap * c + (rate + decay * gap) * s,
        rate * c - (w * w * gap + decay * rate) * s,
    )
