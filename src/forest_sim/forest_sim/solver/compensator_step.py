"""The pressure compensators over a step: each follows the pressures around its valve.

Their openings are known half a step from the states, as load-holding valves are (`holding_step`):
all stages of a step have them as they are. A compensator is in series with whichever edge of its
spool is open to the pump.
"""

import math

from forest_sim.equations.plant import AxisState, PlantState, valve_ports
from forest_sim.equations.plant_parameters import Axis, PlantParameters, SpoolValve
from forest_sim.hydraulics.compensator import NONE, balance, opening_after
from forest_sim.hydraulics.load_holding import AllLifts, Lifts
from forest_sim.hydraulics.oil_volume import hose_drop
from forest_sim.hydraulics.spool_dynamics import Spools


def openings_after(
    plant: PlantState, lifts: AllLifts, spools: Spools, h: float, p: PlantParameters
) -> AllLifts:
    """Return the lifts with the compensators' openings with which a step of h [s] is made."""
    x, supply = (spools[0].position, spools[1].position, spools[2].position), plant.supply.pressure
    swing = _metering(plant.swing, x[0], p.valves[0], p.swing)
    boom = _metering(plant.boom, x[1], p.valves[1], p.boom)
    stick = _metering(plant.stick, x[2], p.valves[2], p.stick)
    greatest = max(swing[1], boom[1], stick[1])
    return (
        _opened(lifts[0], swing, greatest, supply, h, p.valves[0]),
        _opened(lifts[1], boom, greatest, supply, h, p.valves[1]),
        _opened(lifts[2], stick, greatest, supply, h, p.valves[2]),
    )


def _metering(s: AxisState, spool: float, valve: SpoolValve, axis: Axis) -> tuple[float, float]:
    """Return C_R of the edge that is open to the pump, inf if none is, and the load behind it [Pa].

    A centred spool connects its compensator's load line to the tank.
    """
    ports = valve_ports(spool, valve.law)
    if ports.port_1.to_supply < math.inf:
        return ports.port_1.to_supply, s.pressure_1 + hose_drop(s.flow_1, axis.oil_1)
    if ports.port_2.to_supply < math.inf:
        return ports.port_2.to_supply, s.pressure_2 + hose_drop(-s.flow_2, axis.oil_2)
    return math.inf, 0.0


def _opened(
    lifts: Lifts, metering: tuple[float, float], greatest: float, supply: float, h: float, valve: SpoolValve
) -> Lifts:
    c = valve.compensator
    if c.sort == NONE:
        return lifts
    balanced = balance(supply - metering[1], metering[0], supply, greatest, c)
    return Lifts(lifts.one, lifts.two, opening_after(lifts.compensator, balanced, h, c))
