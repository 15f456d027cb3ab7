"""Laws of hydraulics as textbooks print them, written here anew: nothing of the simulator is used.

Pressures are above the tank's [Pa], C_R are resistances of a turbulent orifice, dP/Q^2 [Pa s^2/m^6].
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from scipy.optimize import brentq


class Spring(NamedTuple):
    """What a compensator's spool stands between."""

    setting: float  # [Pa]
    control_range: float  # [Pa] from shut to open
    resistance: float  # C_R of the open spool


def effective_modulus(pressure: float, liquid: float, air: float, dissolved: float, tank: float) -> float:
    """Return -V/(dV/dP) [Pa] of oil with isothermal bubbles that dissolve.

    Merritt, Hydraulic Control Systems, 1967, section 2-3; how much air is free: MathWorks, Isothermal
    Liquid Properties, air dissolution.

    Args:
        pressure: [Pa].
        liquid: bulk modulus of the oil alone [Pa].
        air: room of the bubbles at tank pressure over the oil's [1].
        dissolved: from which no air is free [Pa].
        tank: absolute pressure of the tank [Pa].
    """
    s = min(1.0, max(0.0, pressure / dissolved))
    free, freed = 1.0 - 3.0 * s**2 + 2.0 * s**3, 6.0 * (s**2 - s) / dissolved
    oil, bubbles = math.exp(-pressure / liquid), air * tank / (tank + pressure)
    return (oil + free * bubbles) / (oil / liquid + bubbles * (free / (tank + pressure) - freed))


def oil_spring(area: float, volume: float, modulus: float, wall: float) -> float:
    """Return A^2/(V/beta + C_w) [N/m] of the oil before a piston, and a hose's wall. Merritt, section 6-2."""
    return area**2 / (volume / modulus + wall)


def counterbalance_flow(
    load: float, pilot: float, setting: float, ratio: float, opening_range: float, resistance: float
) -> float:
    """Return what a vented counterbalance valve lets down to the tank [m^3/s].

    Force balance of load and pilot against the spring, orifice as wide as the lift. Jelali & Kroll,
    Hydraulic Servo-Systems, 2003, section 2.2.
    """
    lift = min(1.0, max(0.0, (load + ratio * pilot - setting) / opening_range))
    return lift * math.sqrt(load / resistance)


def lugre(z: float, v: float, sliding: float, stiffness: float, damping: float) -> tuple[float, float]:
    """Return dz/dt and F of LuGre's bristles.

    Canudas de Wit, Olsson, Astrom and Lischinsky, A new model for control of systems with friction, IEEE
    Trans. Automatic Control 40, 1995, eq. 1 to 3.

    Args:
        z: deflection [rad].
        v: speed [rad/s].
        sliding: g(v), the friction in steady sliding [N m].
        stiffness: sigma_0 [N m/rad].
        damping: sigma_1 [N m s/rad].
    """
    rate = v - stiffness * abs(v) / sliding * z
    return rate, stiffness * z + damping * rate


def metered_flow(drop: float, edge: float, aim: float, spring: Spring) -> float:
    """Return the flow [m^3/s] through a compensator and the edge of a spool, one behind the other.

    The flow whose drop over the edge leaves the compensator the opening at which it takes the rest.

    Args:
        drop: over both [Pa].
        edge: C_R of the edge.
        aim: drop over the edge at which the compensator is just shut [Pa].
        spring: the compensator's.
    """
    if drop <= 0.0 or aim <= 0.0:
        return 0.0

    def missing(flow: float) -> float:
        opening = min(1.0, (aim - edge * flow**2) / spring.control_range)
        return edge * flow**2 + spring.resistance * (flow / opening) ** 2 - drop

    most = math.sqrt(min(drop, aim * (1.0 - 1e-12)) / edge)
    return brentq(missing, 0.0, most, xtol=1e-15)


def shared_flows(pump: float, loads: Sequence[float], edges: Sequence[float], spring: Spring) -> list[float]:
    """Return what compensators behind the spools (LUDV) make of a pump that is too small [m^3/s].

    All hold the pressure behind their edges at the greatest load: the manifold's is the one at which
    they take what the pump gives. Jelali & Kroll, section 2.2.
    """

    def taken(supply: float) -> list[float]:
        aim = supply - max(loads) - spring.setting
        return [metered_flow(supply - p, c_r, aim, spring) for p, c_r in zip(loads, edges, strict=True)]

    supply = brentq(lambda p: sum(taken(p)) - pump, max(loads), max(loads) + 1e8, xtol=1e-3)
    return taken(supply)
