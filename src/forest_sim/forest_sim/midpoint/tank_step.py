"""The tank line over a step: it takes what all valves return, and they see its pressure.

All of a step has the line's pressure in its middle (second order), foreseen from the flows at its
beginning. What the stages then return is what the line gets, so that no oil is lost between them.
The foresight is implicit, in what port valves do to the line, too: no line is too small for it.
"""

from typing import NamedTuple

from forest_sim.equations.plant import (
    AxisState,
    PlantState,
    Transmission,
    at_joints,
    motor_side,
    sides,
    transmissions,
)
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.equations.valve_ports import Ports, ports_at
from forest_sim.hydraulics.hydraulic_line import PortGuard, guard_conductance, guard_flow
from forest_sim.hydraulics.load_holding import AllLifts
from forest_sim.hydraulics.oil_volume import content
from forest_sim.hydraulics.port import Port, edge_flows, is_shut, port_pressure
from forest_sim.hydraulics.side import Side, side_rates
from forest_sim.hydraulics.spool_dynamics import Spools
from forest_sim.hydraulics.tank_line import TankState, pressure_at_midpoint


class Returned(NamedTuple):
    """What comes back into the tank line."""

    flow: float  # Q [m^3/s]
    yielding: float  # -dQ/dP_t of port valves over a step [m^3/(s Pa)]


def tank_at_midpoint(
    plant: PlantState, spools: Spools, lifts: AllLifts, tank: TankState, h: float, p: PlantParameters
) -> TankState:
    """Return the tank line with P_t in the middle of a step of h [s]; not inlined."""
    ports, half = ports_at(spools, p, lifts, tank.pressure), 0.5 * h
    plant, supply = at_joints(plant, p), plant.supply.pressure
    t_1, t_2, t_3 = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
    swing = _returned(motor_side(plant, p), t_1, ports[0], supply, p.swing, p.guard, half)
    boom = _returned(plant.boom, t_2, ports[1], supply, p.boom, p.guard, half)
    stick = _returned(plant.stick, t_3, ports[2], supply, p.stick, p.guard, half)
    flow = swing.flow + boom.flow + stick.flow
    yielding = swing.yielding + boom.yielding + stick.yielding
    return TankState(tank.pressure, pressure_at_midpoint(tank, flow, yielding, h, p.tank_line), tank.owed)


def returned_flow(plant: PlantState, ports: tuple[Ports, Ports, Ports], p: PlantParameters) -> float:
    """Return what all valves return at a state [m^3/s]; not inlined."""
    swing = _given_back(plant.swing, ports[0], plant.supply.pressure, p.guard)
    boom = _given_back(plant.boom, ports[1], plant.supply.pressure, p.guard)
    return swing + boom + _given_back(plant.stick, ports[2], plant.supply.pressure, p.guard)


def _given_back(s: AxisState, ports: Ports, supply: float, guard: PortGuard) -> float:
    tank = ports.port_1.tank
    through = tank_flow(s.pressure_1, s.flow_1, ports.port_1, supply)
    through += tank_flow(s.pressure_2, -s.flow_2, ports.port_2, supply)
    return through - guard_flow(s.pressure_1 - tank, guard) - guard_flow(s.pressure_2 - tank, guard)


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
