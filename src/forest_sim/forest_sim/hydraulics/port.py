"""A valve's port: the two edges of the spool that connect it, what leaks past them, the load check before it.

| symbol | name | unit |
|---|---|---|
| p | pressure in the port, between its edges and the hose's inertance | Pa |
| Q | flow from the port into the hose | m^3/s |
| P | pressure in the hose's capacitance | Pa |
| P_s | supply pressure | Pa |
| P_t | pressure in the tank line, zero without one | Pa |
| C_R | an edge's resistance, inf when shut | Pa s^2/m^6 |

A load check sits between supply and spool. Without it, oil goes back into the manifold whenever the
pumps cannot keep its pressure above the load's: a heavy axis sinks while a light one moves. Where
the spool is underlapped, each port has a check of its own here.

Oil that runs on behind a closing edge tears where the edge cannot feed it: in the port is vapour
then, and the hose takes what the edges pass towards that. The column stops at once, as behind a
shut valve; how far it would have run on is not modelled.
"""

import math
from typing import NamedTuple

ROOT_ITERATIONS = 100
ROOT_TOLERANCE = 1e-14  # of the pressures at play
TINY_RESISTANCE = 1e-3  # [Pa s/m^3] of an open edge at zero flow, where its true slope is zero


class Port(NamedTuple):
    """What a valve's port is connected to: through its two edges, and by what leaks past each of them."""

    to_supply: float  # C_R [Pa s^2/m^6], inf when shut
    to_tank: float  # C_R [Pa s^2/m^6], inf when shut
    leakage: float  # g [m^3/(s Pa)] past either edge, the mean of both
    load_check: int = 0  # not 0: no oil goes back through the edge to the supply
    vapour: float = -math.inf  # [Pa] pressure at which the oil boils
    skew: float = 0.0  # k [m^3/(s Pa)]: g + k leak past the supply's edge, g - k past the tank's
    tank: float = 0.0  # P_t [Pa]


class PortSolution(NamedTuple):
    """A port whose flow is that of its hose."""

    pressure: float  # p [Pa]
    flow_gain: float  # dQ/d(intercept), 0 behind a shut port .. 1 behind a wide one


def is_shut(port: Port) -> bool:
    """Tell whether nothing flows through a port."""
    return port.to_supply == math.inf and port.to_tank == math.inf and port.leakage == 0.0


def port_pressure(pressure: float, flow: float, port: Port, supply: float) -> float:
    """Return p [Pa] of a port whose hose holds P and Q; behind shut edges that is P itself.

    A load check opens when the supply is above the hose, and not before.
    """
    checked = apply_load_check(flow, port, supply)
    waiting = checked.load_check != 0 and flow == 0.0 and checked.to_tank == math.inf and pressure >= supply
    if is_shut(checked) or (waiting and checked.leakage == 0.0):
        return pressure
    return max(checked.vapour, solve_port(flow, 0.0, checked, supply).pressure)


def apply_load_check(flow: float, port: Port, supply: float) -> Port:
    """Return a port as its load check leaves it: shut towards the supply where oil would go back.

    Oil goes back where p would have to be above P_s; at p = P_s the port passes what the other ways
    take. What leaks past the lands leaks past the check.

    Args:
        flow: what the hose takes at p = P_s [m^3/s].
        port: the port with its check, if any.
        supply: P_s [Pa].
    """
    if port.load_check == 0:
        return port
    back = port.tank - supply
    if flow >= edge_flow(back, port.to_tank) + (port.leakage - port.skew) * back:
        return port
    return without_supply(port)


def without_supply(port: Port) -> Port:
    """Return a port without its edge to the supply."""
    return port._replace(to_supply=math.inf)


def with_resistance(port: Port, more: float) -> Port:
    """Return a port with another resistance [Pa s^2/m^6] in series with its edge to the supply."""
    return port._replace(to_supply=port.to_supply + more)


def port_flow(p: float, port: Port, supply: float) -> float:
    """Return Q [m^3/s] through a port at the pressure p [Pa]: both edges and what leaks past them."""
    return (
        edge_flow(supply - p, port.to_supply)
        + edge_flow(port.tank - p, port.to_tank)
        + port.leakage * (supply + port.tank - 2.0 * p)
        + port.skew * (supply - port.tank)
    )


def edge_flows(flow: float, p: float, port: Port, supply: float) -> tuple[float, float]:
    """Return what comes from the supply and what goes to the tank [m^3/s]; their difference is the flow.

    The one that has to pass an open edge alone is taken from the flow, which is exact where the
    drop is tiny.

    Args:
        flow: Q [m^3/s].
        p: the port's pressure at this flow [Pa].
        port: what the valve connects.
        supply: P_s [Pa].
    """
    from_supply = (port.leakage + port.skew) * (supply - p)
    to_tank = (port.leakage - port.skew) * (p - port.tank)
    if port.load_check != 0 and p > supply:
        port = without_supply(port)
    if port.to_tank == math.inf:
        return flow + to_tank, to_tank
    if port.to_supply == math.inf:
        return from_supply, from_supply - flow
    through_supply, through_tank = (
        edge_flow(supply - p, port.to_supply),
        edge_flow(p - port.tank, port.to_tank),
    )
    return from_supply + through_supply, to_tank + through_tank


def edge_flow(drop: float, resistance: float) -> float:
    """Return Q [m^3/s] = sgn(dP) sqrt(|dP|/C_R). Thesis eq. 3.1."""
    return math.copysign(math.sqrt(abs(drop) / resistance), drop)


def solve_port(intercept: float, admittance: float, port: Port, supply: float) -> PortSolution:
    """Return the pressure at which the port passes the flow of the hose, intercept + admittance p.

    With one edge open, o through it obeys o + (2 g + y) C_R o|o| = Y, whose root 2 Y/(1 + sqrt(1 +
    4 (2 g + y) C_R |Y|)) holds at zero flow too (g: leakage, y: admittance). With both edges open p
    is found by Newton within a bracket.

    Args:
        intercept: the hose's flow at p = 0 [m^3/s].
        admittance: [m^3/(s Pa)], not negative; zero only if the port is not shut.
        port: what the valve connects.
        supply: P_s [Pa].
    """
    if port.to_supply == math.inf and port.to_tank == math.inf:
        yielding = 2.0 * port.leakage + admittance
        leaked = _leaked(port, supply)
        return PortSolution((leaked - intercept) / yielding, 2.0 * port.leakage / yielding)
    if port.to_tank == math.inf:
        return _one_edge(intercept, admittance, port.to_supply, supply, port, supply)
    if port.to_supply == math.inf:
        return _one_edge(intercept, admittance, port.to_tank, port.tank, port, supply)
    return _two_edges(intercept, admittance, port, supply)


def _leaked(port: Port, supply: float) -> float:
    """Return what leaks into a port at zero pressure [m^3/s]."""
    return (port.leakage + port.skew) * supply + (port.leakage - port.skew) * port.tank


def _one_edge(
    intercept: float, admittance: float, resistance: float, source: float, port: Port, supply: float
) -> PortSolution:
    """Solve a port with one edge open, from the pressure `source`; leakage is linear and goes along."""
    yielding = 2.0 * port.leakage + admittance
    y = intercept - _leaked(port, supply) + yielding * source
    root = math.sqrt(1.0 + 4.0 * yielding * resistance * abs(y))  # = 1 + yielding d(drop)/do
    o = 2.0 * y / (1.0 + root)
    slope = 2.0 * resistance * abs(o)  # d(drop)/do
    return PortSolution(source - resistance * o * abs(o), 1.0 - admittance * slope / root)


def _two_edges(intercept: float, admittance: float, port: Port, supply: float) -> PortSolution:
    """Solve a port with both edges open, as an underlapped valve has them near its centre."""
    reach = max(port.to_supply, port.to_tank) * intercept * intercept
    low, high = min(port.tank, supply) - reach, max(port.tank, supply) + reach
    p = 0.5 * (low + high)
    conductance, moved = 0.0, high - low
    for _ in range(ROOT_ITERATIONS):
        error = port_flow(p, port, supply) - intercept - admittance * p
        if error > 0.0:
            low = p
        else:
            high = p
        conductance = port_conductance(p, port, supply)
        newton = error / (admittance + conductance)
        if abs(newton) <= ROOT_TOLERANCE * (abs(p) + abs(supply)):
            break
        # Beside an edge without drop, where its slope is infinite, Newton jumps to and fro: halve there.
        halve = abs(newton) > 0.5 * abs(moved) or not low < p + newton < high
        after = 0.5 * (low + high) if halve else p + newton
        moved, p = after - p, after
    return PortSolution(p, conductance / (conductance + admittance))


def port_conductance(p: float, port: Port, supply: float) -> float:
    """Return -dQ/dp [m^3/(s Pa)] of a port."""
    return (
        edge_conductance(supply - p, port.to_supply)
        + edge_conductance(port.tank - p, port.to_tank)
        + 2.0 * port.leakage
    )


def edge_conductance(drop: float, resistance: float) -> float:
    """Return dQ/d(dP) [m^3/(s Pa)] of an edge; large, not infinite, at zero flow."""
    if resistance == math.inf:
        return 0.0
    return 1.0 / (2.0 * math.sqrt(resistance * abs(drop)) + TINY_RESISTANCE)
