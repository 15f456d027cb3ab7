"""The pressure compensators over a step: each follows the pressures around its valve.

Their openings are known half a step from the states, as load-holding valves are (`holding_step`).
What the load-sensing line feels jumps as an edge opens: a step has the mean of its time. A
compensator is in series with whichever edge of its spool is open to the pump; behind a centred
spool it goes shut. The load-sensing line has a relief valve: an axis at its end leaves the others
the pump's margin.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.valve_characteristic import edges
from forest_description.types import Vec3
from forest_sim.equations.plant import AxisState, PlantState
from forest_sim.equations.plant_parameters import Axis, PlantParameters, SpoolValve
from forest_sim.hydraulics.compensator import NONE, balance, opening_after
from forest_sim.hydraulics.load_holding import AllLifts, Lifts
from forest_sim.hydraulics.oil_volume import hose_drop
from forest_sim.hydraulics.spool_dynamics import Spools
from forest_sim.midpoint.load_sensing import open_halves


class Metering(NamedTuple):
    """What a spool does to its compensator, and to those of others."""

    resistance: float  # C_R of the edge that is open to the pump [Pa s^2/m^6], inf if none is
    load: float  # behind it; behind a centred spool the tank's [Pa]
    sensed: float  # that the load-sensing line feels while the edge is open [Pa]
    early: float  # share of the step's first half in which port 1 is open to the pump; negative: port 2
    late: float  # of its second half


class GreatestLoads(NamedTuple):
    """The greatest loads between which a step of the compensators lies."""

    steady: float  # of the axes that are open to the pump all the time [Pa]
    greatest: float  # of all that are open at some time [Pa]
    share: float  # of the time in which that one is open


def openings_after(
    plant: PlantState, lifts: AllLifts, spools: Spools, end: Spools, h: float, p: PlantParameters
) -> AllLifts:
    """Return the lifts with the compensators' openings with which a step of h [s] is made.

    Args:
        plant: at the step's beginning.
        lifts: of the step before.
        spools: at the step's beginning.
        end: at its end.
        h: the step [s].
        p: the machine.
    """
    swing = _metering(plant.swing, lifts[0].felt, spools[0].position, end[0].position, p.valves[0], p.swing)
    boom = _metering(plant.boom, lifts[1].felt, spools[1].position, end[1].position, p.valves[1], p.boom)
    stick = _metering(plant.stick, lifts[2].felt, spools[2].position, end[2].position, p.valves[2], p.stick)
    felt = (
        0.5 * abs(lifts[0].felt + swing.early),
        0.5 * abs(lifts[1].felt + boom.early),
        0.5 * abs(lifts[2].felt + stick.early),
    )
    loads = _greatest_loads(
        (swing.sensed, boom.sensed, stick.sensed), felt, p.supply.set_pressure - p.supply.margin
    )
    supply = plant.supply.pressure
    return (
        _opened(lifts[0], swing, felt[0], loads, supply, h, p.valves[0]),
        _opened(lifts[1], boom, felt[1], loads, supply, h, p.valves[1]),
        _opened(lifts[2], stick, felt[2], loads, supply, h, p.valves[2]),
    )


def _greatest_loads(loads: Vec3, felt: Vec3, relieved: float) -> GreatestLoads:
    """Return the greatest loads over a step, at most what the line's relief valve leaves [Pa]."""
    steady = greatest = share = 0.0
    for i in range(3):
        if felt[i] == 1.0:
            steady = max(steady, loads[i])
    for i in range(3):
        if 0.0 < felt[i] < 1.0 and loads[i] > steady:
            greatest = max(greatest, loads[i])
            share = max(share, felt[i])
    return GreatestLoads(min(steady, relieved), min(greatest, relieved), share)


def _metering(s: AxisState, felt: float, start: float, end: float, valve: SpoolValve, axis: Axis) -> Metering:
    """Return what a spool on its way from `start` to `end` [V] does to compensators; `felt` as in `Lifts`."""
    if valve.lag.frequency == math.inf:  # the spool is there at once
        start = end
    one, two = open_halves(start, end, valve.law.forward), open_halves(-start, -end, valve.law.backward)
    early, late = one[0] - two[0], one[1] - two[1]
    edge = edges(start, valve.law)
    before_1, before_2 = (
        s.pressure_1 + hose_drop(s.flow_1, axis.oil_1),
        s.pressure_2 + hose_drop(-s.flow_2, axis.oil_2),
    )
    sensed = before_1 if felt + early > 0.0 else before_2
    if edge.supply_1 < math.inf:
        return Metering(edge.supply_1, before_1, sensed, early, late)
    if edge.supply_2 < math.inf:
        return Metering(edge.supply_2, before_2, sensed, early, late)
    return Metering(math.inf, 0.0, sensed, early, late)


def _opened(
    lifts: Lifts, m: Metering, felt: float, loads: GreatestLoads, supply: float, h: float, valve: SpoolValve
) -> Lifts:
    """Return the lifts with the compensator moved on by h [s]; `felt`: share of the time, 0..1."""
    c, drop = valve.compensator, supply - m.load
    if c.sort == NONE:
        return Lifts(lifts.one, lifts.two, lifts.compensator, m.late)
    if felt < 1.0:  # behind a centred spool it goes shut
        balanced = felt * balance(drop, m.resistance, supply, max(loads.steady, loads.greatest), c)
    else:
        balanced = balance(drop, m.resistance, supply, loads.steady, c)
        if loads.share > 0.0:
            balanced += loads.share * (balance(drop, m.resistance, supply, loads.greatest, c) - balanced)
    return Lifts(lifts.one, lifts.two, opening_after(lifts.compensator, balanced, h, c), m.late)
