"""The load-holding valves over a step: their poppets follow the pressures, and shut ones stop the oil.

Lifts are known half a step from the states: a step's pressures are those in the middle of a
poppet's step (leapfrog, second order). Both stages of a step have the valves on a straight line
through its middle and that of the step before. Pilot and load couple both sides of an axis without
a word in the stages' equations. It is stable as long as a poppet is slower than the step:
`response_time` is 2 ms or more.
"""

import math

from forest_description.hydraulics.valve_characteristic import ValveLaw
from forest_sim.equations.plant import AxisState, PlantState
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.equations.valve_ports import valve_ports
from forest_sim.hydraulics.load_holding import (
    AllLifts,
    HoldingValve,
    Lifts,
    Restriction,
    holding_drop,
    is_held,
    lift_after,
    restriction,
)
from forest_sim.hydraulics.oil_volume import OilVolume, hose_drop
from forest_sim.hydraulics.port import Port, port_pressure
from forest_sim.hydraulics.spool_dynamics import Spools


def lifts_after(
    plant: PlantState, lifts: AllLifts, spools: Spools, tank: float, h: float, p: PlantParameters
) -> AllLifts:
    """Return the lifts with which a step of h [s] is made, with the tank line at P_t [Pa]; not inlined."""
    supply = plant.supply.pressure
    return (
        _moved(plant.swing, lifts[0], spools[0].position, p.valves[0].law, supply, tank, h, p.swing),
        _moved(plant.boom, lifts[1], spools[1].position, p.valves[1].law, supply, tank, h, p.boom),
        _moved(plant.stick, lifts[2], spools[2].position, p.valves[2].law, supply, tank, h, p.stick),
    )


def _moved(
    s: AxisState,
    lifts: Lifts,
    spool: float,
    law: ValveLaw,
    supply: float,
    tank: float,
    h: float,
    axis: Axis,
) -> Lifts:
    if axis.holds == 0:
        return lifts
    pilot_1, pilot_2 = s.pressure_2, s.pressure_1
    if axis.holding_1.sort != 0 and axis.holding_2.sort != 0:
        ports = valve_ports(spool, law, -math.inf, tank)
        held_1, held_2 = restriction(lifts.one, axis.holding_1), restriction(lifts.two, axis.holding_2)
        pilot_1 = _line_pressure(s.pressure_2, -s.flow_2, ports.port_2, supply, axis.oil_2, held_2)
        pilot_2 = _line_pressure(s.pressure_1, s.flow_1, ports.port_1, supply, axis.oil_1, held_1)
    return Lifts(
        lift_after(lifts.one, s.pressure_1, pilot_1, s.flow_1, h, axis.holding_1),
        lift_after(lifts.two, s.pressure_2, pilot_2, -s.flow_2, h, axis.holding_2),
        lifts.compensator,
        lifts.felt,
    )


def _line_pressure(
    pressure: float, flow: float, port: Port, supply: float, oil: OilVolume, held: Restriction
) -> float:
    """Return the pressure [Pa] in the hose before a load-holding valve: the tank's behind a shut spool.

    Oil that flows to the actuator tells it by the volume's pressure, whatever a compensator takes. It is
    no higher while none does: the valve lets oil in.

    Args:
        pressure: in the volume behind the valve [Pa].
        flow: to it [m^3/s].
        port: of the spool, without its compensator.
        supply: P_s [Pa].
        oil: the volume.
        held: the valve.
    """
    if flow > 0.0:
        return pressure + hose_drop(flow, oil) + holding_drop(flow, held)
    return min(pressure, port_pressure(port.tank, flow, port, supply))


def flowing(flow: float, lift: float, v: HoldingValve) -> float:
    """Return a flow to the actuator [m^3/s] with which a step begins: none from it through a shut valve."""
    return 0.0 if is_held(flow, restriction(lift, v)) else flow
