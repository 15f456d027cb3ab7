"""Oil that must be pressed first, behind a compensator: its valve gives a flow, and heeds no pressure.

At steady speed v the inlet takes A v. Twice it takes more, and the actuator lags unless it gets it:

- Its ports are empty after a rest. The air in them must be pressed until the actuator breaks loose.
- A load-holding valve at the outlet is still shut. The piston hangs between two springs of oil, and
  moves both: the inlet takes A v (1 + k_out/k_in).

| symbol | name | unit (cylinder; motor) |
|---|---|---|
| A | displacement at the inlet | m^2; m^3/rad |
| C | oil of hose and chamber at a port, dV/dP without its air | m^3/Pa |
| k | spring of oil, A^2/C | N/m; N m/rad |
| P_in, P_out | pressures at the actuator's ports, over the tank's | Pa |
| P_s, m, n | setting, weight of the load, and pilot ratio of a load-holding valve | Pa, 1, 1 |

A counterbalance valve is open while m P_out + n P_in exceeds P_s, with m = 1; a pilot check has m = -1.
The air is isothermal, as in `forest_sim.hydraulics.oil_law`. Merritt, Hydraulic Control Systems, section 3.1.
"""

import math
from typing import NamedTuple

from forest_description.derived.actuator_kinematics import displacements
from forest_description.hydraulics.load_holding_parameters import (
    LoadHolding,
    PilotCheckValve,
    RuptureValve,
)
from forest_description.machine import Machine
from forest_description.mechanics.drives import BearingFriction

NEARLY_OPEN = 0.25  # [1] of its setting: a holding valve that lacks less counts as partly open; chosen


class FreeAir(NamedTuple):
    """Air in the oil of an actuator."""

    volume: float = 0.0  # [Pa] at tank pressure, over C
    tank_pressure: float = 1e5  # [Pa] absolute
    loose: float = 0.0  # [Pa] over the tank's, at which an actuator without load breaks loose


class Holding(NamedTuple):
    """A load-holding valve, as far as its port's pressures open it; one that is not there is open."""

    reseat: float = -math.inf  # [Pa] P_s less the hysteresis
    load: float = 1.0  # [1] m
    pilot: float = 0.0  # [1] n


def free_air(machine: Machine, axis: int) -> FreeAir:
    """Return the air of an axis."""
    oil, friction = machine.oil, machine.drives[axis].friction
    if oil is None or oil.air is None:
        return FreeAir()
    force = 0.0
    if isinstance(friction, BearingFriction):
        force = friction.breakaway_torque
    elif friction is not None:
        force = friction.breakaway_force
    return FreeAir(
        volume=oil.air.share * oil.bulk_modulus,
        tank_pressure=oil.air.tank_pressure,
        loose=force / min(displacements(machine, axis)),
    )


def holding(valve: LoadHolding | None) -> Holding:
    """Return when a load-holding valve is open; a rupture valve is."""
    if valve is None or isinstance(valve, RuptureValve):
        return Holding()
    load = -1.0 if isinstance(valve, PilotCheckValve) else 1.0
    return Holding(valve.setting - valve.hysteresis, load, valve.pilot_ratio)


def shut_share(inlet: float, outlet: float, valve: Holding) -> float:
    """Return how far shut a load-holding valve at the outlet is, 0..1, by both ports' pressures [Pa]."""
    lacking = valve.reseat - valve.load * outlet - valve.pilot * inlet
    return max(0.0, min(1.0, lacking / (NEARLY_OPEN * valve.reseat))) if lacking > 0.0 else 0.0


def lacking_oil(pressure: float, air: FreeAir) -> float:
    """Return the oil over C [Pa] that presses air from a pressure [Pa] until the actuator breaks loose."""
    tank = air.tank_pressure
    return max(0.0, air.volume * (tank / (tank + max(0.0, pressure)) - tank / (tank + air.loose)))
