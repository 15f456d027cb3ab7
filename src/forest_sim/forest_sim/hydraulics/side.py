"""One side of an axis: a valve's port, the hose behind it, the oil in hose and chamber.

Flows count from the valve towards the actuator, on both sides.
"""

from typing import NamedTuple

from forest_description.hydraulics.hose import Line
from forest_sim.hydraulics.hydraulic_line import PortGuard, flow_rate, guard_flow, pressure_rate
from forest_sim.hydraulics.load_holding import UNRESTRICTED, Restriction, holding_drop, is_held
from forest_sim.hydraulics.oil_law import density, enthalpy
from forest_sim.hydraulics.oil_volume import OilVolume, content, hose_drop
from forest_sim.hydraulics.port import Port, port_pressure

TORN = 1.0  # [Pa] above the vapour's pressure in the port


class Side(NamedTuple):
    """One side of an axis at a state."""

    pressure: float  # P [Pa]
    flow: float  # Q from the valve [m^3/s]
    taken: float  # what the actuator takes, at tank pressure's density [m^3/s]
    position: float  # x of the actuator [m; rad]
    speed: float  # [m/s; rad/s]
    port: Port
    line: Line
    oil: OilVolume
    holding: Restriction = UNRESTRICTED  # its load-holding valve


class SideRates(NamedTuple):
    """How a side changes."""

    pressure: float  # dP/dt [Pa/s]
    flow: float  # dQ/dt [m^3/s^2]


class Storage(NamedTuple):
    """What a side's oil takes up [W]."""

    stored: float  # in the inertance, the oil and the hose's wall
    compression: float  # (P - h) dn/dt, what P Q tells too much of the oil's flow


def side_rates(s: Side, supply: float, guard: PortGuard) -> SideRates:
    """Return how a side changes.

    Args:
        s: the side.
        supply: P_s [Pa].
        guard: its relief and anti-cavitation valves.
    """
    line, outflow = s.line, s.taken
    if s.oil.yields:
        line = Line(line.resistance, line.inertance, content(s.pressure, s.position, s.oil).capacitance)
        if s.oil.area != 0.0:  # a piston takes oil at the density that it has
            outflow = density(s.pressure, s.oil.oil).ratio * s.taken
    flow = 0.0
    if not is_held(s.flow, s.holding):
        beyond = s.pressure + hose_drop(s.flow, s.oil) + holding_drop(s.flow, s.holding)
        flow = flow_rate(beyond, s.flow, s.port, supply, line)
    return SideRates(pressure_rate(s.pressure, s.flow, outflow, line, guard, s.port.tank), flow)


def storage(s: Side, supply: float, guard: PortGuard) -> Storage:
    """Return what a side's oil takes up; arguments as `side_rates`.

    A flow brings h dn/dt, the piston takes P dV/dt. P Q counts the flow at P instead of h; the
    difference is given back where the oil leaves.
    """
    rates = side_rates(s, supply, guard)
    inertial = s.line.inertance * s.flow * rates.flow
    if not s.oil.yields:
        return Storage(inertial + s.line.capacitance * s.pressure * rates.pressure, 0.0)
    brought, widened = s.flow + guard_flow(s.pressure - s.port.tank, guard), s.oil.area * s.speed
    if s.oil.area == 0.0:
        brought -= s.taken
    h = enthalpy(s.pressure, s.oil.oil)
    return Storage(inertial + h * brought - s.pressure * widened, (s.pressure - h) * brought)


def is_torn(s: Side, supply: float) -> bool:
    """Tell whether the oil between a side's valve and its hose is torn: the port holds vapour."""
    return port_pressure(s.pressure, s.flow, s.port, supply) <= s.port.vapour + TORN
