"""A hose between valve and actuator, with the port valves that protect it.

'T' line of Thesis fig. 3.5: the inertance I on the valve's side, the capacitance C in the middle, the
resistance on the actuator's side (it belongs to the actuator's law, see `actuator`). Relief and
anti-cavitation valves sit at the capacitance, where a shut valve would otherwise trap an impossible pressure.

| symbol | name | unit |
|---|---|---|
| P | pressure in the capacitance | Pa |
| Q | flow from the valve into the hose | m^3/s |
| q | flow from the hose into the actuator | m^3/s |
| P_v, C_R | pressure behind the spool's orifice; the orifice's resistance, inf when shut | Pa; Pa s^2/m^6 |
| I, C | inertance; capacitance | Pa s^2/m^3; m^3/Pa |

Flows count from the valve towards the actuator here, for both hoses. The thesis counts hose 2 the other way:
its callers pass -Q_2 and -q_2.
"""

import math
from typing import NamedTuple

from forest_description.machine import Line


class PortGuard(NamedTuple):
    """Relief and anti-cavitation valves, straight characteristics; a conductance of zero leaves one out."""

    relief_pressure: float  # [Pa] at which the relief valve opens
    relief_conductance: float  # [m^3/(s Pa)]
    anticavitation_pressure: float  # [Pa] below which the check valve lets tank oil in
    anticavitation_conductance: float  # [m^3/(s Pa)]


class Orifice(NamedTuple):
    """One edge of a spool as its hose sees it."""

    resistance: float  # C_R [Pa s^2/m^6], inf when shut
    source_pressure: float  # P_v [Pa], supply or tank


class LineSolution(NamedTuple):
    """A hose at the end of an implicit stage."""

    pressure: float  # [Pa]
    flow: float  # [m^3/s]
    stiffness: float  # -dP/dq [Pa s/m^3], how the pressure answers the actuator's flow


def guard_flow(pressure: float, guard: PortGuard) -> float:
    """Return the flow [m^3/s] that the port valves let into the hose (negative: relieved to tank)."""
    if pressure > guard.relief_pressure:
        return guard.relief_conductance * (guard.relief_pressure - pressure)
    if pressure < guard.anticavitation_pressure:
        return guard.anticavitation_conductance * (guard.anticavitation_pressure - pressure)
    return 0.0


def pressure_rate(pressure: float, flow: float, actuator_flow: float, line: Line, guard: PortGuard) -> float:
    """Return dP/dt [Pa/s] = (Q - q + port valves)/C. Thesis eq. 3.7, 3.13, 4.6."""
    return (flow - actuator_flow + guard_flow(pressure, guard)) / line.capacitance


def flow_rate(pressure: float, flow: float, orifice: Orifice, line: Line) -> float:
    """Return dQ/dt [m^3/s^2] = (P_v - C_R Q|Q| - P)/I. Thesis eq. 3.1, 3.7, 3.13, 4.5a.

    Behind a shut orifice the flow is zero and stays zero; any other would have to stop at once (an infinite
    rate). Differs: 3.7 prints P_i for P_s, and 3.7 and 3.13 C_R for C_R' on the return line.
    """
    if orifice.resistance == math.inf:
        return 0.0 if flow == 0.0 else -math.copysign(math.inf, flow)
    return (orifice.source_pressure - orifice.resistance * flow * abs(flow) - pressure) / line.inertance


def solve_line(
    pressure: float,
    flow: float,
    actuator_flow: float,
    leakage: float,
    orifice: Orifice,
    line: Line,
    guard: PortGuard,
    step: float,
) -> LineSolution:
    """Solve one implicit stage of a hose exactly, for any opening, without iteration.

    P = pressure + step dP/dt and Q = flow + step dQ/dt, with q = actuator_flow + leakage P. Given which port
    valve is open, P is linear in Q; what is left, alpha Q + kappa Q|Q| = y, has the root 2y / (alpha +
    sqrt(alpha^2 + 4 kappa |y|)), which holds at zero flow and for a shut orifice (kappa = inf) alike. P falls
    monotonically with what the port valves let out, so trying shut first and then the one valve that it calls
    for is exact.

    Args:
        pressure: the stage's known part of P [Pa].
        flow: the stage's known part of Q [m^3/s].
        actuator_flow: q at P = 0 [m^3/s].
        leakage: dq/dP of the actuator [m^3/(s Pa)].
        orifice: the spool's edge at the hose's other end.
        line: the hose's lumped elements.
        guard: the port's relief and anti-cavitation valves.
        step: the stage's implicit step gamma h [s].
    """
    shut = _solve_with_port_valve(pressure, flow, actuator_flow, leakage, orifice, line, step)
    if shut.pressure > guard.relief_pressure and guard.relief_conductance > 0.0:
        conductance, opening = guard.relief_conductance, guard.relief_pressure
    elif shut.pressure < guard.anticavitation_pressure and guard.anticavitation_conductance > 0.0:
        conductance, opening = guard.anticavitation_conductance, guard.anticavitation_pressure
    else:
        return shut
    return _solve_with_port_valve(
        pressure, flow, actuator_flow - conductance * opening, leakage + conductance, orifice, line, step
    )


def _solve_with_port_valve(
    pressure: float,
    flow: float,
    outflow: float,
    leakage: float,
    orifice: Orifice,
    line: Line,
    step: float,
) -> LineSolution:
    """Solve the stage with all outflow linear: outflow + leakage P."""
    yielding = line.capacitance + step * leakage
    slope = step / yielding  # dP/dQ
    offset = (line.capacitance * pressure - step * outflow) / yielding  # P at Q = 0
    if orifice.resistance == math.inf:
        return LineSolution(offset, 0.0, slope)
    gain = step / line.inertance
    alpha = 1.0 + gain * slope
    kappa = gain * orifice.resistance
    y = flow + gain * (orifice.source_pressure - offset)
    root = math.sqrt(alpha * alpha + 4.0 * kappa * abs(y))
    q = 2.0 * y / (alpha + root)
    return LineSolution(offset + slope * q, q, slope * (1.0 - slope * gain / root))
