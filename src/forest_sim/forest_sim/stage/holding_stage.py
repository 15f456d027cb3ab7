"""A hose with a load-holding valve behind it, as a hose alone within an implicit stage.

The valve takes C_R Q|Q| from the pressure. Along the tangent at a flow q that is C_R (2 |q| Q -
q |q|): what an inertance greater by 2 h C_R |q| and another known flow do to a stage. The tangent is
moved until it is within `TOLERANCE`. A shut valve is an infinite inertance at rest.
"""

import math

from forest_description.hydraulics.hose import Line
from forest_sim.hydraulics.hydraulic_line import LineSolution
from forest_sim.hydraulics.load_holding import Restriction
from forest_sim.hydraulics.oil_volume import StageHose
from forest_sim.hydraulics.port import Port

TOLERANCE = 100.0  # [Pa] of a tangent
LEAST = 1e-12  # [m^3/s] of a flow that has a direction


def held_hose(hose: StageHose, flow: float, held: Restriction, step: float) -> StageHose:
    """Return a hose with its load-holding valve along the tangent at a flow.

    Args:
        hose: without the valve.
        flow: of the tangent [m^3/s]; its sign is the direction.
        held: the valve.
        step: the stage's implicit step [s].
    """
    resistance = held.inward if flow > 0.0 else held.outward
    line = hose.line
    if resistance == math.inf:
        shut = Line(line.resistance, math.inf, line.capacitance)
        return StageHose(hose.pressure, 0.0, shut, hose.density)
    dropped = step * resistance * abs(flow)
    inertance = line.inertance + 2.0 * dropped
    known = (line.inertance * hose.flow + dropped * flow) / inertance
    return StageHose(hose.pressure, known, Line(line.resistance, inertance, line.capacitance), hose.density)


def first_flow(flow: float, pressure: float, port: Port, held: Restriction, supply: float) -> float:
    """Return the flow [m^3/s] of the first tangent: the one before, or else that without inertia.

    That of spool and valve alone is about the stage's where the valve is nearly shut. Elsewhere any
    flow is near enough.

    Args:
        flow: before the stage, for its direction [m^3/s].
        pressure: in the volume [Pa].
        port: of the spool.
        held: the valve.
        supply: P_s [Pa].
    """
    if flow > 0.0 or (flow < 0.0 and held.outward < math.inf):
        return flow
    feeding = port.to_supply < math.inf
    source = supply if feeding else port.tank
    inward = flow == 0.0 and source > pressure
    valve = held.inward if inward else held.outward
    total = valve + (port.to_supply if feeding else port.to_tank)
    size = max(LEAST, math.sqrt(abs(source - pressure) / total)) if total < math.inf else LEAST
    return size if inward else -size


def next_flow(solution: LineSolution, flow: float, port: Port, held: Restriction, supply: float) -> float:
    """Return the flow [m^3/s] of the next tangent; the same one if it has been good enough.

    Args:
        solution: of the hose along the tangent at a flow.
        flow: that one [m^3/s].
        port: of the spool.
        held: the valve.
        supply: P_s [Pa].
    """
    resistance = held.inward if flow > 0.0 else held.outward
    if resistance == math.inf:
        opens = solution.port_pressure > solution.pressure
        return first_flow(LEAST, solution.pressure, port, held, supply) if opens else flow
    if solution.flow * flow < 0.0:
        return first_flow(solution.flow, solution.pressure, port, held, supply)
    missed = solution.flow - flow
    return flow if resistance * missed * missed <= TOLERANCE else solution.flow
