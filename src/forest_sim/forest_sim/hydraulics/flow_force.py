"""Flow forces: what the oil's jets do to a spool.

| symbol | name | unit |
|---|---|---|
| Q, C_R | flow through an edge, its orifice resistance | m^3/s, Pa s^2/m^6 |
| v | the jet's speed, sqrt(2 dP/rho) = Q sqrt(2 C_R/rho) | m/s |
| theta | angle of the jet to the spool's axis, 69 degrees | rad |
| k | centring spring's force for each volt of stroke | N/V |
| x, u | spool position, what it goes for (`spool_dynamics`) | V |

    F = rho Q v cos(theta) = Q^2 sqrt(2 rho C_R) cos(theta)

The steady flow force is the momentum that leaves along the spool's axis. It closes the edge,
whichever way the oil flows. Merritt, Hydraulic Control Systems, 1967, section 5.6; von Mises' angle,
a jet as fast as the whole drop makes it. The spool then goes for u - F/k:

    x'' + 2 zeta w x' + w^2 (x - u + F/k) = 0

The transient force, that of oil speeding up along the spool, is left out: it is a damper of either
sign, small beside a pilot-operated spool's own.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.valve_parameters import JET_ANGLE
from forest_sim.hydraulics.port import Port, edge_flows, is_shut, port_pressure


class Jets(NamedTuple):
    """What flow forces do to a spool, as a voltage F/k [V]."""

    force: float  # when the last step began
    push: float  # in that step's middle


AllJets = tuple[Jets, Jets, Jets]
STILL = Jets(0.0, 0.0)
NO_JETS = (STILL, STILL, STILL)


def jet_factor(density: float, centring_force: float) -> float:
    """Return sqrt(2 rho) cos(theta)/k [V s^2/(m^6 sqrt(Pa s^2/m^6))] of a density [kg/m^3] and k [N/V]."""
    return math.sqrt(2.0 * density) * math.cos(JET_ANGLE) / centring_force


def edge_momentum(flow: float, resistance: float) -> float:
    """Return Q^2 sqrt(C_R) of an edge; none of a shut one."""
    return flow * flow * math.sqrt(resistance) if resistance < math.inf else 0.0


def port_momentum(pressure: float, flow: float, port: Port, supply: float) -> float:
    """Return Q^2 sqrt(C_R) of a port's edge to the supply less that of its edge to the tank.

    Args:
        pressure: in the hose [Pa].
        flow: into the hose [m^3/s].
        port: what the valve connects.
        supply: P_s [Pa].
    """
    if is_shut(port):
        return 0.0
    p = port_pressure(pressure, flow, port, supply)
    from_supply, to_tank = edge_flows(flow, p, port, supply)
    return edge_momentum(from_supply, port.to_supply) - edge_momentum(to_tank, port.to_tank)
