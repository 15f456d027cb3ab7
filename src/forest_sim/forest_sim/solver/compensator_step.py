"""The pressure compensators over a step: each follows the pressures around its valve.

Their openings are known half a step from the states, as load-holding valves are (`holding_step`):
all stages of a step have them as they are. A compensator is in series with whichever edge of its
spool is open to the pump. The load-sensing line has a relief valve: an axis at its end leaves the
others the pump's margin.
"""

import math

from forest_description.components.valve_characteristic import edges
from forest_sim.equations.plant import AxisState, PlantState
from forest_sim.equations.plant_parameters import Axis, PlantParameters, SpoolValve
from forest_sim.hydraulics.compensator import NONE, balance, opening_after
from forest_sim.hydraulics.load_holding import AllLifts, Lifts
from forest_sim.hydraulics.oil_volume import hose_drop
from forest_sim.hydraulics.spool_dynamics import Spools


def openings_after(
    plant: PlantState, lifts: AllLifts, spools: Spools, h: float, p: PlantParameters
) -> AllLifts:
    """Return the lifts with the compensators' openings with which a step of h [s] is made."""
    swing = _metering(plant.swing, spools[0].position, p.valves[0], p.swing)
    boom = _metering(plant.boom, spools[1].position, p.valves[1], p.boom)
    stick = _metering(plant.stick, spools[2].position, p.valves[2], p.stick)
    greatest = min(max(swing[1], boom[1], stick[1]), p.supply.set_pressure - p.supply.margin)
    supply = plant.supply.pressure
    return (
        _opened(lifts[0], swing, greatest, supply, h, p.valves[0]),
        _opened(lifts[1], boom, greatest, supply, h, p.valves[1]),
        _opened(lifts[2], stick, greatest, supply, h, p.valves[2]),
    )


def _metering(s: AxisState, spool: float, valve: SpoolValve, axis: Axis) -> tuple[float, float]:
    """Return C_R of the edge that is open to the pump, inf if none is, and the load behind it [Pa].

    A centred spool connects its compensator's load line to the tank.
    """
    edge = edges(spool, valve.law)
    if edge.supply_1 < math.inf:
        return edge.supply_1, s.pressure_1 + hose_drop(s.flow_1, axis.oil_1)
    if edge.supply_2 < math.inf:
        return edge.supply_2, s.pressure_2 + hose_drop(-s.flow_2, axis.oil_2)
    return math.inf, 0.0


def _opened(
    lifts: Lifts, metering: tuple[float, float], greatest: float, supply: float, h: float, valve: SpoolValve
) -> Lifts:
    c = valve.compensator
    if c.sort == NONE:
        return lifts
    balanced = balance(supply - metering[1], metering[0], supply, greatest, c)
    return Lifts(lifts.one, lifts.two, opening_after(lifts.compensator, balanced, h, c))
