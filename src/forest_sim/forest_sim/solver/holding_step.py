"""The load-holding valves over a step: their poppets follow the pressures, and shut ones stop the oil.

Lifts are known half a step from the states: a step's pressures are those in the middle of a
poppet's step (leapfrog, second order), and all stages of a step have the valves as they are. Pilot
and load couple both sides of an axis without a word in the stages' equations. It is stable as long
as a poppet is slower than the step: `response_time` is 2 ms or more.
"""

import math

from forest_sim.equations.plant import AxisState, PlantState, metered, valve_ports
from forest_sim.equations.plant_parameters import Axis, PlantParameters, SpoolValve
from forest_sim.hydraulics.load_holding import AllLifts, HoldingValve, Lifts, is_held, lift_after, restriction
from forest_sim.hydraulics.port import Port, port_pressure
from forest_sim.hydraulics.spool_dynamics import Spools


def lifts_after(
    plant: PlantState, lifts: AllLifts, spools: Spools, tank: float, h: float, p: PlantParameters
) -> AllLifts:
    """Return the lifts with which a step of h [s] is made, with the tank line at P_t [Pa]; not inlined."""
    supply = plant.supply.pressure
    return (
        _moved(plant.swing, lifts[0], spools[0].position, p.valves[0], supply, tank, h, p.swing),
        _moved(plant.boom, lifts[1], spools[1].position, p.valves[1], supply, tank, h, p.boom),
        _moved(plant.stick, lifts[2], spools[2].position, p.valves[2], supply, tank, h, p.stick),
    )


def _moved(
    s: AxisState,
    lifts: Lifts,
    spool: float,
    valve: SpoolValve,
    supply: float,
    tank: float,
    h: float,
    axis: Axis,
) -> Lifts:
    if axis.holds == 0:
        return lifts
    pilot_1, pilot_2 = s.pressure_2, s.pressure_1
    if axis.holding_1.sort != 0 and axis.holding_2.sort != 0:
        ports = metered(valve_ports(spool, valve.law, -math.inf, tank), lifts, valve)
        pilot_1 = _line_pressure(-s.flow_2, ports.port_2, supply)
        pilot_2 = _line_pressure(s.flow_1, ports.port_1, supply)
    return Lifts(
        lift_after(lifts.one, s.pressure_1, pilot_1, s.flow_1, h, axis.holding_1),
        lift_after(lifts.two, s.pressure_2, pilot_2, -s.flow_2, h, axis.holding_2),
        lifts.compensator,
    )


def _line_pressure(flow: float, port: Port, supply: float) -> float:
    """Return the pressure [Pa] in the hose before a load-holding valve: the tank's behind a shut spool."""
    return port_pressure(port.tank, flow, port, supply)


def flowing(flow: float, lift: float, v: HoldingValve) -> float:
    """Return a flow to the actuator [m^3/s] with which a step begins: none from it through a shut valve."""
    return 0.0 if is_held(flow, restriction(lift, v)) else flow
