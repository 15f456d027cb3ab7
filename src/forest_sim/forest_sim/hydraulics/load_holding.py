"""Load-holding valves: what stands at an actuator's port, between the hose and the oil's volume.

| symbol | name | unit |
|---|---|---|
| P | pressure in the actuator's volume, the load's | Pa |
| P_x | pilot pressure: of the other side | Pa |
| P_set, r, b | setting; pilot ratio; hysteresis | Pa, 1, Pa |
| R | opening range | Pa |
| s | force on the poppet beyond its spring's, as a share of R | 1 |
| z | lift of the poppet, 0 shut .. 1 open | 1 |
| tau | its time constant | s |
| C_R | resistance, C_Rmin/z^2 for oil from the actuator; a check valve's to it | Pa s^2/m^6 |

    counterbalance      s = (P + r P_x - P_set)/R
    pilot check         s = (r P_x - P - P_set)/R
    poppet              tau dz/dt = s - z while s > z,    s + b/R - z while s + b/R < z,    else 0

The poppet is a spring with damping and Coulomb friction between its seat and its stop: it cracks at
P_set, reseats at P_set - b, and leaves the seat or a standstill as it would without friction after.
Source: Merritt, Hydraulic Control Systems, 1967, section 9.2, for the poppet without mass; the
defaults of Hopsan's counterbalance valve for its dynamics.

The valve is vented: the pressure behind it does not act on its poppet. A hose-rupture valve is open
until more than its closing flow leaves the actuator; it then shuts, and stays so until oil comes to
the actuator.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.load_holding_parameters import (
    CounterbalanceValve,
    LoadHolding,
    RuptureValve,
)

NONE, PRESSED, RUPTURE = 0, 1, 2
"""Sorts of valve: none, one that pressures open, one that flow shuts."""
SEATED = 1e-6  # lift below which a valve is shut, without leakage
OPENING, SHUTTING = 2.0, -1.0  # what a hose-rupture valve's poppet goes for, beyond its stop and its seat


class HoldingValve(NamedTuple):
    """Constants of the law."""

    sort: int
    load: float  # 1: the load opens the valve; -1: it shuts it
    pilot_ratio: float
    setting: float  # [Pa]
    hysteresis: float  # [Pa]
    opening_range: float  # [Pa]
    closing_flow: float  # [m^3/s]
    resistance: float  # C_Rmin [Pa s^2/m^6] from the actuator
    check_resistance: float  # [Pa s^2/m^6] to the actuator
    response_time: float  # [s]


class Lifts(NamedTuple):
    """How far the valves at both ports of an axis, and its pressure compensator, are open, 0 .. 1."""

    one: float
    two: float
    compensator: float = 0.0
    felt: float = 0.0  # share of the last half step in which port 1 was open to the pump; negative: port 2


AllLifts = tuple[Lifts, Lifts, Lifts]
"""Of swing, boom and stick."""


class Restriction(NamedTuple):
    """What a load-holding valve is to the flow [Pa s^2/m^6]; inf: shut."""

    inward: float  # to the actuator
    outward: float  # from it


UNRESTRICTED = Restriction(0.0, 0.0)
NO_HOLDING = HoldingValve(NONE, 0.0, 0.0, 0.0, 0.0, 1.0, math.inf, 0.0, 0.0, 1.0)
SEATED_LIFTS = Lifts(0.0, 0.0)
NO_LIFTS: AllLifts = (SEATED_LIFTS, SEATED_LIFTS, SEATED_LIFTS)


def holding_valve(valve: LoadHolding | None) -> HoldingValve:
    """Return the kernel's constants of a load-holding valve."""
    if valve is None:
        return NO_HOLDING
    if isinstance(valve, RuptureValve):
        c_r = valve.minimum_resistance
        return NO_HOLDING._replace(
            sort=RUPTURE,
            closing_flow=valve.closing_flow,
            resistance=c_r,
            check_resistance=c_r,
            response_time=valve.response_time,
        )
    return HoldingValve(
        sort=PRESSED,
        load=1.0 if isinstance(valve, CounterbalanceValve) else -1.0,
        pilot_ratio=valve.pilot_ratio,
        setting=valve.setting,
        hysteresis=valve.hysteresis,
        opening_range=valve.opening_range,
        closing_flow=math.inf,
        resistance=valve.minimum_resistance,
        check_resistance=valve.check_resistance,
        response_time=valve.response_time,
    )


def resting_lift(v: HoldingValve) -> float:
    """Return the lift at which a machine starts: only a hose-rupture valve is open."""
    return 1.0 if v.sort == RUPTURE else 0.0


def lift_after(lift: float, load: float, pilot: float, flow: float, time: float, v: HoldingValve) -> float:
    """Return a poppet's lift after a time [s] under held pressures [Pa] and flow to the actuator [m^3/s]."""
    if v.sort == NONE:
        return lift
    target = _rupture_target(lift, flow, v) if v.sort == RUPTURE else _target(lift, load, pilot, v)
    moved = target + (lift - target) * math.exp(-time / v.response_time)
    return min(1.0, max(0.0, moved))


def lifts_along(a: AllLifts, b: AllLifts, w: float) -> AllLifts:
    """Return lifts a share w of the way from a to b, or beyond."""
    return _lifts_along(a[0], b[0], w), _lifts_along(a[1], b[1], w), _lifts_along(a[2], b[2], w)


def _lifts_along(a: Lifts, b: Lifts, w: float) -> Lifts:
    return Lifts(
        min(1.0, max(0.0, a.one + w * (b.one - a.one))),
        min(1.0, max(0.0, a.two + w * (b.two - a.two))),
        min(1.0, max(0.0, a.compensator + w * (b.compensator - a.compensator))),
        b.felt,
    )


def _target(lift: float, load: float, pilot: float, v: HoldingValve) -> float:
    """Return where pressures would bring a poppet: its friction lets it rest within its hysteresis."""
    opens = (v.load * load + v.pilot_ratio * pilot - v.setting) / v.opening_range
    return max(opens, min(opens + v.hysteresis / v.opening_range, lift))


def _rupture_target(lift: float, flow: float, v: HoldingValve) -> float:
    shuts = -flow > v.closing_flow or (lift < 1.0 and flow <= 0.0)
    return SHUTTING if shuts else OPENING


def restriction(lift: float, v: HoldingValve) -> Restriction:
    """Return what a valve at a lift is to the flow."""
    if v.sort == NONE:
        return UNRESTRICTED
    return Restriction(v.check_resistance, v.resistance / (lift * lift) if lift > SEATED else math.inf)


def holding_drop(flow: float, r: Restriction) -> float:
    """Return the pressure [Pa] that a valve takes from a flow [m^3/s] to the actuator."""
    return (r.inward if flow > 0.0 else r.outward) * abs(flow) * flow if flow != 0.0 else 0.0


def is_held(flow: float, r: Restriction) -> bool:
    """Tell whether a valve lets no oil out of the actuator, and none goes in [m^3/s]."""
    return r.outward == math.inf and flow <= 0.0
