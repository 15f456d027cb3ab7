"""The spool as the driver knows it: play, then a first-order lag whose rate is limited; and their inverses.

| symbol | name | unit |
|---|---|---|
| V | voltage | V |
| u | what the spool goes for, V behind the play | V |
| b | width of the play, the hysteresis | V |
| y | position of the spool, as the voltage that would hold it there | V |
| T, S | time constant of the lag; slew limit of the rate | s, V/s |

The laws are those of the machine file's keys `hysteresis`, `spool_bandwidth` and `spool_slew_limit`:

    u stays while |V - u| <= b/2, else follows V at that distance;      dy/dt = (u - y)/T, at most S

A dead time shifts all of it: y is then the position at the time at which the next voltage starts to act.
Play is what Coulomb friction F on a centring spring k does, b = 2 F/k (Prandtl's element). Its
inverse adds b/2 along the motion of u (Kuhnen, *Modeling, identification and compensation of
complex hysteretic nonlinearities*, European Journal of Control 9, 2003). The inverse jumps by b at
each reversal. So reversals up to `LEFT` b are left alone: noise would make a jump of each of its own.
"""

import math
from typing import NamedTuple

from forest_description.types import Vec3

LEFT = 0.05  # [1] of the play that stays: a tenth of the half-width by which the command is off; chosen


class SpoolLaw(NamedTuple):
    """Constants of one spool."""

    lag: float = 0.0  # T [s]; 0: at once
    play: float = 0.0  # b [V]
    slew: float = math.inf  # S [V/s]


class Spools(NamedTuple):
    """The spools of swing, boom, stick."""

    positions: Vec3 = (0.0, 0.0, 0.0)  # y [V]
    targets: Vec3 = (0.0, 0.0, 0.0)  # u [V]


CENTRED = Spools()


def behind_play(target: float, voltage: float, play: float) -> float:
    """Return u [V] after the voltage [V] has come to a value, from the u before it [V]."""
    return max(voltage - 0.5 * play, min(voltage + 0.5 * play, target))


def before_play(target: float, wanted: float, voltage: float, play: float) -> float:
    """Return the voltage [V] that brings u from a target to a wanted one [V]: the play's inverse.

    Args:
        target: u, by now.
        wanted: u, to come.
        voltage: given last; it stays where u shall stay, within `LEFT` of the play.
        play: b; 0: the voltage is what is wanted.
    """
    if play == 0.0:
        return wanted
    if abs(wanted - target) <= LEFT * play:
        return voltage
    return wanted + math.copysign(0.5 * play, wanted - target)


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
