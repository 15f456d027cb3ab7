"""How far the valves go: the part of the file's opening that each reaches, and joints that cannot follow.

| symbol | name | unit |
|---|---|---|
| V_r, V_d | rated voltage, deadband of the machine's file | V |
| d, k | what the driver has learnt (`valve_adaptation`) | V, - |
| R | reach: opening at V_r over the file's, (V_r - V_d - d) / ((1 + k) (V_r - V_d)) | - |
| y | where a spool is by its first-order lag: the voltage that would hold it there | V |
| a, v, e | wished and measured joint rate, error of the joint against its reference | rad/s, rad/s, rad |
| c | ceiling: the wish that a joint whose valve is open wide can follow, abs v - h abs e | rad/s |
| h | how quickly it comes back to its reference | 1/s |

The governor plans with R. What nobody knows, a heavier load or a weak valve that is not learnt yet, shows
in a valve that is open wide while its joint falls behind. Then all joints wait for that one, whose reference
goes slower than it moves, by h e: so it comes back to it. When the valve is no longer short, c rises and
vanishes. Open is what the spool is, not what its voltage asks for: a spool that is on its way is hurried by
all the voltage there is, a slow one for seconds, and nobody would gain by waiting for it.
"""

import math
from typing import NamedTuple

from forest_control.valve.valve_adaptation import Learner, WayEstimate, gain
from forest_control.valve.valve_driver_parameters import Axes, AxisDriver, moved_spools
from forest_description.components.valve_characteristic import Direction
from forest_description.types import Vec3

Flags = tuple[bool, bool, bool]

LEAST, MOST = 0.2, 1.0  # R: the driver opens no valve wider than the file's
CATCH_UP = 4.0  # [1/s] h
FALL, RISE = 0.03, 0.5  # [s] in which a ceiling comes down, and grows by e
LOWEST = 0.01  # [rad/s] of a ceiling: a joint that is stuck is still asked to move
SPENT = 2.0  # [rad/s] a ceiling that has risen so far is none
FAR = 1e-3  # [rad] of e: nearer, nothing is wrong
SAID_EVERY = 20  # steps of the driver's node
WIDE = 0.95  # of the rated voltage: noise lets a voltage come away from it, and a spool comes there slowly


class Reach(NamedTuple):
    """R of swing, boom, stick, in either direction."""

    forward: Vec3
    backward: Vec3


class Strain(NamedTuple):
    """One joint's ceiling."""

    ceiling: float = math.inf  # c [rad/s]
    side: float = 0.0  # direction of the wish that it holds for: 1, -1


class Strains(NamedTuple):
    """Of all joints, and where their spools are."""

    swing: Strain = Strain()
    boom: Strain = Strain()
    stick: Strain = Strain()
    spools: Vec3 = (0.0, 0.0, 0.0)  # y [V]


class Valves(NamedTuple):
    """What the governor is told of the valves."""

    reach: Reach
    strains: Strains


FULL = Reach((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
RELAXED = Strains()
AS_FILED = Valves(FULL, RELAXED)


def reached(deadband: float, gained: float, edge: Direction) -> float:
    """Return R for a deadband [V] and a gain, 1/(1 + k), of a direction; 1 where they are no numbers."""
    share = gained * (edge.rated_voltage - deadband) / (edge.rated_voltage - edge.deadband_voltage)
    return bounded(share)


def bounded(share: float) -> float:
    """Return R within what is believed; 1 for what is no number."""
    return max(LEAST, min(MOST, share)) if math.isfinite(share) else 1.0


def learnt_reach(learners: tuple[Learner, Learner, Learner], axes: Axes) -> Reach:
    """Return R as the driver has learnt it."""
    one, two, three = learners
    return Reach(
        (_ahead(one, axes[0]), _ahead(two, axes[1]), _ahead(three, axes[2])),
        (_back(one, axes[0]), _back(two, axes[1]), _back(three, axes[2])),
    )


def _ahead(learner: Learner, axis: AxisDriver) -> float:
    return _reached(learner.forward, axis.valve.forward)


def _back(learner: Learner, axis: AxisDriver) -> float:
    return _reached(learner.backward, axis.valve.backward)


def _reached(way: WayEstimate, edge: Direction) -> float:
    return reached(edge.deadband_voltage + way.deadband, gain(way), edge)


def open_wide(spools: Vec3, rated: Vec3) -> Flags:
    """Tell which valves are open as far as they go, by where their spools are and the rated voltages [V]."""
    return (
        abs(spools[0]) >= WIDE * rated[0],
        abs(spools[1]) >= WIDE * rated[1],
        abs(spools[2]) >= WIDE * rated[2],
    )


def strained(
    strains: Strains, voltages: Vec3, rated: Vec3, axes: Axes, a: Vec3, e: Vec3, v: Vec3, dt: float
) -> Strains:
    """Return the joints' ceilings after dt [s].

    Args:
        strains: before.
        voltages: of the valves in that time [V].
        rated: their greatest voltages [V].
        axes: by which the spools' lags are known.
        a: governed rates wished last [rad/s].
        e: references minus measured angles [rad].
        v: measured rates [rad/s].
        dt: [s].
    """
    spools = moved_spools(strains.spools, voltages, axes, dt)
    wide = open_wide(spools, rated)
    return Strains(
        _strained(strains.swing, wide[0], a[0], e[0], v[0], dt),
        _strained(strains.boom, wide[1], a[1], e[1], v[1], dt),
        _strained(strains.stick, wide[2], a[2], e[2], v[2], dt),
        spools,
    )


def _strained(strain: Strain, wide: bool, a: float, e: float, v: float, dt: float) -> Strain:
    """Return one joint's ceiling after dt [s]."""
    side = math.copysign(1.0, e)
    if wide and side * a > 0.0 and abs(e) > FAR:
        followed = max(LOWEST, side * v - CATCH_UP * abs(e))
        before = min(strain.ceiling, abs(a)) if strain.side == side else abs(a)
        ceiling = followed + math.exp(-dt / FALL) * (before - followed)
        return Strain(min(before, ceiling), side)
    if strain.ceiling == math.inf:
        return Strain(math.inf, 0.0)
    risen = strain.ceiling * math.exp(dt / RISE)
    return Strain(risen, strain.side) if risen < SPENT else Strain(math.inf, 0.0)


def ceiling(strain: Strain, wished: float) -> float:
    """Return the greatest rate [rad/s] for a wish in its direction."""
    return strain.ceiling if wished * strain.side > 0.0 else math.inf
