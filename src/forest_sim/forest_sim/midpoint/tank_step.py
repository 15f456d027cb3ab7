"""The tank line in a stage: it takes what all valves return, and they see its pressure.

They see it at the stage's end, foreseen from the flows before the stage. The oil behind an open port
valve comes to that pressure. What the stage then returns is what the line gets, so that no oil is
lost between them. The foresight is implicit, in what port valves do to the line, too: a small line
stays stable.
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
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.hydraulic_line import PortGuard, guard_conductance, guard_flow
from forest_sim.hydraulics.oil_volume import content
from forest_sim.hydraulics.port import Port, edge_flows, is_shut, port_pressure
from forest_sim.hydraulics.side import Side, side_rates
from forest_sim.hydraulics.tank_line import TankState, pressure_at_stage


class Returned(NamedTuple):
    """What comes back into the tank line."""

    flow: float  # Q [m^3/s]
    yielding: float  # -dQ/dP_t of port valves [m^3/(s Pa)]


def tank_at_stage(
    plant: PlantState, ports: tuple[Ports, Ports, Ports], tank: TankState, h: float, p: PlantParameters
) -> TankState:
    """Return the tank line with P_t at a stage's end; not inlined.

    Args:
        plant: the stage's known part.
        ports: what the valves connect at its end.
        tank: the stage's known part of the line.
        h: its implicit step [s].
        p: the machine.
    """
    back = returned(plant, ports, p)
    if back.yielding > 0.0:
        back = _as_volumes_fill(back, plant, ports, h, p)
    seen = pressure_at_stage(tank, back.flow, back.yielding, h, p.tank_line)
    return TankState(tank.pressure, seen, tank.owed)


def returned(plant: PlantState, ports: tuple[Ports, Ports, Ports], p: PlantParameters) -> Returned:
    """Return what all valves return at a state; not inlined."""
    swing = _given_back(plant.swing, ports[0], plant.supply.pressure, p.guard)
    boom = _given_back(plant.boom, ports[1], plant.supply.pressure, p.guard)
    stick = _given_back(plant.stick, ports[2], plant.supply.pressure, p.guard)
    return _sum(swing, boom, stick)


def _given_back(s: AxisState, ports: Ports, supply: float, guard: PortGuard) -> Returned:
    above_1, above_2 = s.pressure_1 - ports.port_1.tank, s.pressure_2 - ports.port_2.tank
    through = tank_flow(s.pressure_1, s.flow_1, ports.port_1, supply)
    through += tank_flow(s.pressure_2, -s.flow_2, ports.port_2, supply)
    return Returned(
        through - guard_flow(above_1, guard) - guard_flow(above_2, guard),
        guard_conductance(above_1, guard) + guard_conductance(above_2, guard),
    )


def _as_volumes_fill(
    back: Returned, plant: PlantState, ports: tuple[Ports, Ports, Ports], h: float, p: PlantParameters
) -> Returned:
    """Return what valves return as the volumes behind open port valves fill within a stage; not inlined."""
    plant, supply = at_joints(plant, p), plant.supply.pressure
    t_1, t_2, t_3 = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
    swing = _refused(motor_side(plant, p), t_1, ports[0], supply, p.swing, p.guard, h)
    boom = _refused(plant.boom, t_2, ports[1], supply, p.boom, p.guard, h)
    stick = _refused(plant.stick, t_3, ports[2], supply, p.stick, p.guard, h)
    refused = _sum(swing, boom, stick)
    return Returned(back.flow + refused.flow, back.yielding - refused.yielding)


def _refused(
    s: AxisState, t: Transmission, ports: Ports, supply: float, axis: Axis, guard: PortGuard, h: float
) -> Returned:
    side_1, side_2 = sides(s, t, ports, axis)
    one, two = _by_volume(side_1, supply, guard, h), _by_volume(side_2, supply, guard, h)
    return Returned(one.flow + two.flow, one.yielding + two.yielding)


def _by_volume(side: Side, supply: float, guard: PortGuard, h: float) -> Returned:
    """Return by how much less a volume takes through its port valve at a stage's end, and yields to P_t."""
    conductance = guard_conductance(side.pressure - side.port.tank, guard)
    if conductance == 0.0:
        return Returned(0.0, 0.0)
    volume = side.line.capacitance
    if side.oil.yields:
        volume = content(side.pressure, side.position, side.oil).capacitance
    filled = h * conductance / (volume + h * conductance)
    return Returned(filled * volume * side_rates(side, supply, guard).pressure, filled * conductance)


def _sum(a: Returned, b: Returned, c: Returned) -> Returned:
    return Returned(a.flow + b.flow + c.flow, a.yielding + b.yielding + c.yielding)


def tank_flow(pressure: float, flow: float, port: Port, supply: float) -> float:
    """Return what goes to the tank through a port's edge and past its land [m^3/s]."""
    if is_shut(port):
        return 0.0
    return edge_flows(flow, port_pressure(pressure, flow, port, supply), port, supply)[1]
