"""Tracking limits: how far each valve opens, and joints that cannot follow.

| symbol | name | unit |
|---|---|---|
| V_r, V_d | rated voltage, deadband of the machine's file | V |
| d, k | what the driver has learnt (`valve_adaptation`) | V, - |
| R | opening ratio: opening at V_r over the file's, (V_r - V_d - d) / ((1 + k) (V_r - V_d)) | - |
| y | position of a spool by its first-order lag: the voltage that would hold it there | V |
| a, v, e | reference and measured joint rate, error of the joint against its reference | rad/s, rad/s, rad |
| c | ceiling: the rate that a joint whose valve is fully open can follow, abs v - h abs e | rad/s |
| h | catch-up rate: how quickly the joint comes back to its reference | 1/s |

The velocity scaling plans with R. What is not learnt, as a heavier load or a weak valve, shows in a
valve that is fully open while its joint falls behind. Then all joints wait for that one: its
reference goes slower than it moves, by h e, so it catches up. When the valve is no longer fully
open, c rises until it limits nothing. The spool's position counts, not its voltage: a spool on its
way gets all the voltage there is, and waiting would not help.
"""

import math
from typing import NamedTuple

from forest_control.valve.valve_adaptation import DirectionEstimate, ValveEstimate, gain
from forest_control.valve.valve_driver_parameters import Axes, AxisDriver, moved_spools
from forest_description.hydraulics.valve_characteristic import Direction
from forest_description.types import Vec3

Flags = tuple[bool, bool, bool]

LEAST = 0.2  # [1] smallest R that is believed: a weaker valve is a broken one; chosen
MOST = 1.0  # [1] greatest R: the driver opens no valve wider than the file's
CATCH_UP = 4.0  # [1/s] h, near the position gain of the coordinated scheme; chosen
FALL = 0.03  # [s] time constant with which a ceiling comes down; chosen, not measured
RISE = 0.5  # [s] in which a ceiling grows by the factor e; chosen, not measured
LOWEST = 0.01  # [rad/s] of a ceiling: a joint that is stuck is still asked to move
FAR = 1e-3  # [rad] of e, 6 mm of the tip at 6 m: nearer, the joint follows
STATUS_EVERY = 20  # [1] steps between two reports of the driver: 10 Hz
WIDE = 0.95  # [1] of the rated voltage, from which a valve is fully open: noise and the lag keep it below 1


class OpeningRatio(NamedTuple):
    """R of swing, boom, stick, in either direction."""

    forward: Vec3
    backward: Vec3


class TrackingLimit(NamedTuple):
    """One joint's ceiling."""

    ceiling: float = math.inf  # c [rad/s]
    side: float = 0.0  # direction of the rate that it holds for: 1, -1


class TrackingLimits(NamedTuple):
    """The ceilings of all joints, and where their spools are."""

    swing: TrackingLimit = TrackingLimit()
    boom: TrackingLimit = TrackingLimit()
    stick: TrackingLimit = TrackingLimit()
    spools: Vec3 = (0.0, 0.0, 0.0)  # [V]


class Valves(NamedTuple):
    """What the velocity scaling knows of the valves."""

    opening_ratio: OpeningRatio
    tracking_limits: TrackingLimits


FULL = OpeningRatio((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
NO_TRACKING_LIMIT = TrackingLimits()
AS_FILED = Valves(FULL, NO_TRACKING_LIMIT)


def opening_ratio(deadband: float, gained: float, edge: Direction) -> float:
    """Return R for a deadband [V] and a gain, 1/(1 + k), of a direction; 1 where they are no numbers."""
    ratio = gained * (edge.rated_voltage - deadband) / (edge.rated_voltage - edge.deadband_voltage)
    return bounded(ratio)


def bounded(ratio: float) -> float:
    """Return R within what is believed; 1 for what is no number."""
    return max(LEAST, min(MOST, ratio)) if math.isfinite(ratio) else 1.0


def learnt_opening_ratio(
    estimates: tuple[ValveEstimate, ValveEstimate, ValveEstimate], axes: Axes
) -> OpeningRatio:
    """Return R as the driver has learnt it."""
    one, two, three = estimates
    return OpeningRatio(
        (_ahead(one, axes[0]), _ahead(two, axes[1]), _ahead(three, axes[2])),
        (_back(one, axes[0]), _back(two, axes[1]), _back(three, axes[2])),
    )


def _ahead(learner: ValveEstimate, axis: AxisDriver) -> float:
    return _ratio(learner.forward, axis.valve.forward)


def _back(learner: ValveEstimate, axis: AxisDriver) -> float:
    return _ratio(learner.backward, axis.valve.backward)


def _ratio(way: DirectionEstimate, edge: Direction) -> float:
    return opening_ratio(edge.deadband_voltage + way.deadband, gain(way), edge)


def open_wide(spools: Vec3, rated: Vec3) -> Flags:
    """Tell which valves are fully open, by the positions of their spools and the rated voltages [V]."""
    return (
        abs(spools[0]) >= WIDE * rated[0],
        abs(spools[1]) >= WIDE * rated[1],
        abs(spools[2]) >= WIDE * rated[2],
    )


def updated_limits(
    limits: TrackingLimits, voltages: Vec3, rated: Vec3, axes: Axes, a: Vec3, e: Vec3, v: Vec3, dt: float
) -> TrackingLimits:
    """Return the joints' ceilings after dt [s].

    Args:
        limits: before.
        voltages: of the valves in that time [V].
        rated: their greatest voltages [V].
        axes: by which the spools' lags are known.
        a: reference rates of the last step [rad/s].
        e: references minus measured angles [rad].
        v: measured rates [rad/s].
        dt: [s].
    """
    spools = moved_spools(limits.spools, voltages, axes, dt)
    wide = open_wide(spools, rated)
    return TrackingLimits(
        _updated(limits.swing, wide[0], a[0], e[0], v[0], dt),
        _updated(limits.boom, wide[1], a[1], e[1], v[1], dt),
        _updated(limits.stick, wide[2], a[2], e[2], v[2], dt),
        spools,
    )


def _updated(limit: TrackingLimit, wide: bool, a: float, e: float, v: float, dt: float) -> TrackingLimit:
    """Return one joint's ceiling after dt [s]."""
    side = math.copysign(1.0, e)
    if wide and side * a > 0.0 and abs(e) > FAR:
        followed = max(LOWEST, side * v - CATCH_UP * abs(e))
        before = min(limit.ceiling, abs(a)) if limit.side == side else abs(a)
        ceiling = followed + math.exp(-dt / FALL) * (before - followed)
        return TrackingLimit(min(before, ceiling), side)
    return TrackingLimit(limit.ceiling * math.exp(dt / RISE), limit.side)


def ceiling(limit: TrackingLimit, rate: float) -> float:
    """Return the greatest rate [rad/s] in the direction of a rate."""
    return limit.ceiling if rate * limit.side > 0.0 else math.inf
