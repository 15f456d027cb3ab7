"""The pressure compensator of a spool valve: how far it throttles what comes from the pump.

| symbol | name | unit |
|---|---|---|
| P_s, P | pressure in the manifold; behind the valve, the load's | Pa |
| P_LS | the greatest load of all axes that are open to the pump | Pa |
| D | drop over compensator and spool edge together, P_s - P | Pa |
| D_m | drop over the spool's edge alone, D C_R/(C_R + C_c) | Pa |
| x | opening, 0 shut .. 1 open | 1 |
| C_R, C_c | resistance of the spool's edge; of the compensator, C_cmin/x^2 | Pa s^2/m^6 |
| P_set, R | spring's setting; control range | Pa |
| tau | time constant | s |

    balance             R x = A - D_m(x),   0 <= x <= 1
    before the spool    A = P_set                        the edge's drop is P_set - R x
    after the spool     A = P_s - P_LS - P_set           the pressure behind the edge is P_LS + P_set + R x
    dynamics            tau dx/dt = x_balance - x

Before the spool each axis has a flow of its own until the pump cannot keep P_s above the load.
After the spool all edges have one drop, so that a pump that cannot serve all is shared in
proportion to the openings. Source: Jelali & Kroll, Hydraulic Servo-Systems, 2003, section 2.2, for
the balance of the compensator's spool; its flow forces are in the control range.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics import compensator_parameters as parameters

NONE, BEFORE, AFTER = 0, 1, 2
"""Sorts of compensator."""
LEAST = 1e-4  # opening of a shut one: its clearance; through it the load-sensing line fills
BALANCED = 1e-12  # [1] of an opening that Newton finds
BALANCING_STEPS = 60


class Compensator(NamedTuple):
    """Constants of the law."""

    sort: int
    setting: float  # [Pa]
    control_range: float  # [Pa]
    resistance: float  # C_cmin [Pa s^2/m^6]
    response_time: float  # [s]


NO_COMPENSATOR = Compensator(NONE, 0.0, 1.0, 0.0, 1.0)


def compensator(given: parameters.Compensator | None) -> Compensator:
    """Return the kernel's constants of a compensator."""
    if given is None:
        return NO_COMPENSATOR
    return Compensator(
        sort=BEFORE if isinstance(given, parameters.CompensatorBeforeSpool) else AFTER,
        setting=given.setting,
        control_range=given.control_range,
        resistance=given.minimum_resistance,
        response_time=given.response_time,
    )


def in_series(opening: float, c: Compensator) -> float:
    """Return C_c [Pa s^2/m^6] of a compensator."""
    passing = max(LEAST, opening)
    return c.resistance / (passing * passing)


def balance(drop: float, edge: float, supply: float, greatest: float, c: Compensator) -> float:
    """Return the opening at which a compensator's forces balance.

    Args:
        drop: D [Pa].
        edge: C_R of the spool's open edge; inf when shut [Pa s^2/m^6].
        supply: P_s [Pa].
        greatest: P_LS [Pa].
        c: the compensator.
    """
    aim = c.setting if c.sort == BEFORE else supply - greatest - c.setting
    ratio = c.resistance / edge
    if aim <= 0.0 or (ratio == 0.0 and drop >= aim):
        return 0.0
    if aim - _edge_drop(1.0, drop, ratio) >= c.control_range:
        return 1.0
    return _root(aim, drop, ratio, c.control_range)


def _edge_drop(x: float, drop: float, ratio: float) -> float:
    """Return D_m [Pa] at an opening x above 0; D where the spool is shut (ratio 0)."""
    return drop * x * x / (x * x + ratio)


def _root(aim: float, drop: float, ratio: float, control_range: float) -> float:
    """Return the x in 0..1 with R x + D_m(x) = A, whose left side grows, by Newton within a bracket."""
    low, high, x = 0.0, 1.0, 0.5
    for _ in range(BALANCING_STEPS):
        below = x * x + ratio
        off = control_range * x + drop * x * x / below - aim
        if off > 0.0:
            high = x
        else:
            low = x
        after = x - off / (control_range + 2.0 * drop * ratio * x / (below * below))
        if not low < after < high:
            after = 0.5 * (low + high)
        moved, x = after - x, after
        if abs(moved) <= BALANCED:
            break
    return x


def opening_after(opening: float, balanced: float, time: float, c: Compensator) -> float:
    """Return the opening after a time [s] in which the balance stands still."""
    return balanced + (opening - balanced) * math.exp(-time / c.response_time)
