"""The tank line over a step: it takes what all valves return, and they see its pressure.

Its pressure is known half a step from the states, as the lifts of `holding_step` are: a step's
flows are those in the middle of the line's step (leapfrog, second order). The line itself is
implicit, and so is what port valves do to it, so that no line is too small for the step.
"""

from typing import NamedTuple

from forest_sim.equations.plant import (
    AxisState,
    PlantState,
    Ports,
    Transmission,
    motor_side,
    ports_at,
    sides,
    transmissions,
)
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.hydraulics.hydraulic_line import PortGuard, guard_conductance, guard_flow
from forest_sim.hydraulics.load_holding import NO_LIFTS
from forest_sim.hydraulics.oil_volume import content
from forest_sim.hydraulics.port import Port, edge_flows, is_shut, port_pressure
from forest_sim.hydraulics.side import Side, side_rates
from forest_sim.hydraulics.spool_dynamics import Spools
from forest_sim.hydraulics.tank_line import pressure_after


class Returned(NamedTuple):
    """What comes back into the tank line."""

    flow: float  # Q [m^3/s]
    yielding: float  # -dQ/dP_t of port valves over a step [m^3/(s Pa)]


def tank_after(plant: PlantState, spools: Spools, tank: float, h: float, p: PlantParameters) -> float:
    """Return P_t [Pa] with which a step of h [s] is made; not inlined."""
    ports, supply = ports_at(spools, p, NO_LIFTS, tank), plant.supply.pressure
    t_1, t_2, t_3 = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
    swing = _returned(motor_side(plant, p), t_1, ports[0], supply, p.swing, p.guard, h)
    boom = _returned(plant.boom, t_2, ports[1], supply, p.boom, p.guard, h)
    stick = _returned(plant.stick, t_3, ports[2], supply, p.stick, p.guard, h)
    flow = swing.flow + boom.flow + stick.flow
    return pressure_after(tank, flow, swing.yielding + boom.yielding + stick.yielding, h, p.tank_line)


def _returned(
    s: AxisState, t: Transmission, ports: Ports, supply: float, axis: Axis, guard: PortGuard, h: float
) -> Returned:
    side_1, side_2 = sides(s, t, ports, axis)
    one, two = _by_port(side_1, supply, guard, h), _by_port(side_2, supply, guard, h)
    return Returned(one.flow + two.flow, one.yielding + two.yielding)


def _by_port(side: Side, supply: float, guard: PortGuard, h: float) -> Returned:
    """Return what a port's edge and its open port valve give back over a step.

    The volume behind a port valve fills within the step, by which its flow falls: it is that at the
    end of an implicit step.
    """
    through = tank_flow(side.pressure, side.flow, side.port, supply)
    above = side.pressure - side.port.tank
    conductance = guard_conductance(above, guard)
    if conductance == 0.0:
        return Returned(through, 0.0)
    volume = side.line.capacitance
    if side.oil.yields:
        volume = content(side.pressure, side.position, side.oil).capacitance
    filled = h * conductance / (volume + h * conductance)
    filling = volume * side_rates(side, supply, guard).pressure
    guarded = guard_flow(above, guard) - filled * filling
    return Returned(through - guarded, (1.0 - filled) * conductance)


def tank_flow(pressure: float, flow: float, port: Port, supply: float) -> float:
    """Return what goes to the tank through a port's edge and past its land [m^3/s]."""
    if is_shut(port):
        return 0.0
    return edge_flows(flow, port_pressure(pressure, flow, port, supply), port, supply)[1]
