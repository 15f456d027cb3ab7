"""A hose between a valve's port (`port`) and an actuator, and the port valves that protect it.

'T' line of Thesis fig. 3.5: the inertance I on the valve's side, the capacitance C in the middle,
the resistance on the actuator's side (it belongs to the actuator's law, see `actuator`). Relief and
anti-cavitation valves sit at the capacitance, where a shut valve would otherwise trap an impossible
pressure.

| symbol | name | unit |
|---|---|---|
| P | pressure in the capacitance | Pa |
| p | pressure in the valve's port, between its edges and the inertance | Pa |
| Q | flow from the valve into the hose | m^3/s |
| q | flow from the hose into the actuator | m^3/s |
| P_s | supply pressure | Pa |
| I, C | inertance; capacitance | Pa s^2/m^3; m^3/Pa |

Flows count from the valve towards the actuator here, for both hoses. The thesis counts hose 2 the
other way: its callers pass -Q_2 and -q_2.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.hose import Line
from forest_sim.hydraulics.port import (
    Port,
    apply_load_check,
    edge_conductance,
    edge_flows,
    is_shut,
    port_conductance,
    port_flow,
    port_pressure,
    solve_port,
    without_supply,
)


class PortGuard(NamedTuple):
    """Relief and anti-cavitation valves, straight characteristics; a conductance of zero leaves one out."""

    relief_pressure: float  # [Pa] at which the relief valve opens
    relief_conductance: float  # [m^3/(s Pa)]
    anticavitation_pressure: float  # [Pa] below which the check valve lets tank oil in
    anticavitation_conductance: float  # [m^3/(s Pa)]


class LineSolution(NamedTuple):
    """A hose at the end of an implicit stage."""

    pressure: float  # [Pa]
    flow: float  # [m^3/s]
    stiffness: float  # -dP/dq [Pa s/m^3], how the pressure answers the actuator's flow
    flow_gain: float  # dQ/dq, how much of that flow comes through the valve
    port_pressure: float  # p [Pa]
    port_stiffness: float  # -dp/dq [Pa s/m^3]
    slope: float  # dP/dQ [Pa s/m^3], how the oil between valve and actuator yields


class Coupling(NamedTuple):
    """How a hose at the end of a stage and the supply feel each other."""

    draw: float  # flow from the supply S [m^3/s]
    conductance: float  # dS/dP_s [m^3/(s Pa)]
    gain: float  # dP/dP_s, which by reciprocity is also dS/dq
    feed: float  # dQ/dP_s [m^3/(s Pa)]
    port_gain: float  # dp/dP_s


def guard_flow(pressure: float, guard: PortGuard) -> float:
    """Return the flow [m^3/s] that the port valves let into the hose (negative: relieved to tank).

    Args:
        pressure: in the hose, above that of the tank line [Pa].
        guard: the valves.
    """
    if pressure > guard.relief_pressure:
        return guard.relief_conductance * (guard.relief_pressure - pressure)
    if pressure < guard.anticavitation_pressure:
        return guard.anticavitation_conductance * (guard.anticavitation_pressure - pressure)
    return 0.0


def guard_conductance(pressure: float, guard: PortGuard) -> float:
    """Return -d(flow)/d(pressure) [m^3/(s Pa)] of `guard_flow`."""
    if pressure > guard.relief_pressure:
        return guard.relief_conductance
    return guard.anticavitation_conductance if pressure < guard.anticavitation_pressure else 0.0


def pressure_rate(
    pressure: float, flow: float, actuator_flow: float, line: Line, guard: PortGuard, tank: float = 0.0
) -> float:
    """Return dP/dt [Pa/s] = (Q - q + port valves)/C, these above P_t [Pa]. Thesis eq. 3.7, 3.13, 4.6."""
    return (flow - actuator_flow + guard_flow(pressure - tank, guard)) / line.capacitance


def flow_rate(pressure: float, flow: float, port: Port, supply: float, line: Line) -> float:
    """Return dQ/dt [m^3/s^2] = (p - P)/I; behind one edge p = P_v - C_R Q|Q|.

    Thesis eq. 3.1, 3.7, 3.13, 4.5a. Behind shut edges the flow is zero and stays zero; any other
    would have to stop at once (an infinite rate). Differs: 3.7 prints P_i for P_s, and 3.7 and 3.13
    C_R for C_R' on the return line.
    """
    if is_shut(apply_load_check(flow, port, supply)):
        return 0.0 if flow == 0.0 else -math.copysign(math.inf, flow)
    return (port_pressure(pressure, flow, port, supply) - pressure) / line.inertance


def solve_line(
    pressure: float,
    flow: float,
    actuator_flow: float,
    leakage: float,
    port: Port,
    supply: float,
    line: Line,
    guard: PortGuard,
    step: float,
) -> LineSolution:
    """Solve one implicit stage of a hose exactly, for any opening.

    P = pressure + step dP/dt and Q = flow + step dQ/dt, with q = actuator_flow + leakage P. Given
    which port valve is open, P is linear in Q and the hose takes Q = a + y p. P falls monotonically
    with what the port valves let out, so trying shut first and then the one valve that it calls for
    is exact.

    Args:
        pressure: the stage's known part of P [Pa].
        flow: the stage's known part of Q [m^3/s].
        actuator_flow: q at P = 0 [m^3/s].
        leakage: dq/dP of the actuator [m^3/(s Pa)].
        port: the valve at the hose's other end.
        supply: P_s [Pa].
        line: the hose's lumped elements.
        guard: the port's relief and anti-cavitation valves.
        step: the stage's implicit step gamma h [s].
    """
    shut = _solve_with_port_valve(pressure, flow, actuator_flow, leakage, port, supply, line, step)
    relieved, fed = guard.relief_pressure + port.tank, guard.anticavitation_pressure + port.tank
    if shut.pressure > relieved and guard.relief_conductance > 0.0:
        conductance, opening = guard.relief_conductance, relieved
    elif shut.pressure < fed and guard.anticavitation_conductance > 0.0:
        conductance, opening = guard.anticavitation_conductance, fed
    else:
        return shut
    outflow = actuator_flow - conductance * opening
    return _solve_with_port_valve(pressure, flow, outflow, leakage + conductance, port, supply, line, step)


def _solve_with_port_valve(
    pressure: float,
    flow: float,
    outflow: float,
    leakage: float,
    port: Port,
    supply: float,
    line: Line,
    step: float,
) -> LineSolution:
    """Solve the stage with all outflow linear: outflow + leakage P."""
    # Of step and constants alone come all quotients here: compiled, they are taken once for many steps.
    yielding = line.capacitance + step * leakage
    slope, retained = step / yielding, line.capacitance / yielding  # dP/dQ; dP/d(pressure)
    offset = retained * pressure - slope * outflow  # P at Q = 0
    if is_shut(port):
        return _behind_shut_port(offset, slope)
    gain = step / line.inertance
    share = 1.0 / (1.0 + gain * slope)
    intercept, admittance = share * (flow - gain * offset), share * gain
    checked = apply_load_check(intercept + admittance * supply, port, supply)
    if is_shut(checked):
        return _behind_shut_port(offset, slope)
    p, passed = solve_port(intercept, admittance, checked, supply)
    if p < checked.vapour:
        q = port_flow(checked.vapour, checked, supply)
        return _behind_torn_oil(offset + slope * q, q, checked.vapour, slope)
    q = intercept + admittance * p
    flow_gain = passed * admittance * slope
    return LineSolution(
        pressure=offset + slope * q,
        flow=q,
        stiffness=slope * (1.0 - flow_gain),
        flow_gain=flow_gain,
        port_pressure=p,
        port_stiffness=slope * (1.0 - passed),
        slope=slope,
    )


def _behind_shut_port(pressure: float, slope: float) -> LineSolution:
    """Return a hose into which nothing flows; its port has its pressure."""
    return LineSolution(
        pressure=pressure,
        flow=0.0,
        stiffness=slope,
        flow_gain=0.0,
        port_pressure=pressure,
        port_stiffness=slope,
        slope=slope,
    )


def _behind_torn_oil(pressure: float, flow: float, vapour: float, slope: float) -> LineSolution:
    """Return a hose behind a port in which the oil is torn: its pressure stands at the vapour's."""
    return LineSolution(
        pressure=pressure,
        flow=flow,
        stiffness=slope,
        flow_gain=0.0,
        port_pressure=vapour,
        port_stiffness=0.0,
        slope=slope,
    )


def with_outflow(line: LineSolution, flow: float) -> LineSolution:
    """Return a hose from which the actuator takes more by a small flow [m^3/s], to first order.

    What the pressure yields is what the valve does not deliver, so that no oil is lost or made.
    """
    return LineSolution(
        pressure=line.pressure - line.stiffness * flow,
        flow=line.flow + line.flow_gain * flow,
        stiffness=line.stiffness,
        flow_gain=line.flow_gain,
        port_pressure=line.port_pressure - line.port_stiffness * flow,
        port_stiffness=line.port_stiffness,
        slope=line.slope,
    )


def supply_coupling(solution: LineSolution, port: Port, supply: float, line: Line, step: float) -> Coupling:
    """Return how a solved hose and the supply feel each other.

    Args:
        solution: what `solve_line` found.
        port: as given to it.
        supply: P_s [Pa], as given to it.
        line: as given to it.
        step: as given to it [s].
    """
    p = solution.port_pressure
    if port.load_check != 0 and p > supply:
        port = without_supply(port)
    if is_shut(port):
        return Coupling(0.0, 0.0, 0.0, 0.0, 0.0)
    to_supply = edge_conductance(supply - p, port.to_supply) + (port.leakage + port.skew)
    if p <= port.vapour:  # torn: the port's pressure stands still
        return Coupling(edge_flows(solution.flow, p, port, supply)[0], to_supply, 0.0, to_supply, 0.0)
    conductance = port_conductance(p, port, supply)
    gain = step / line.inertance
    admittance = gain / (1.0 + gain * solution.slope)
    p_per_supply = to_supply / (conductance + admittance)
    feed = admittance * p_per_supply
    return Coupling(
        draw=edge_flows(solution.flow, p, port, supply)[0],
        conductance=to_supply * (1.0 - p_per_supply),
        gain=solution.slope * feed,
        feed=feed,
        port_gain=p_per_supply,
    )
