"""What a spool's four edges connect an axis' hoses to. Thesis eq. 3.1, 3.2, fig. 2.5.

A positive spool position connects port 1 to the supply and port 2 to the tank (Appendix B's only
case); a negative one the reverse. Spools, poppets, compensators and the tank line are no states of
a stage: `midpoint` knows them beforehand, and the ports tell how they stand.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.valve_characteristic import ValveLaw, edges, leakage_at
from forest_sim.equations.plant_parameters import PlantParameters, SpoolValve
from forest_sim.hydraulics.compensator import NONE, in_series
from forest_sim.hydraulics.load_holding import NO_LIFTS, SEATED_LIFTS, AllLifts, Lifts
from forest_sim.hydraulics.port import Port, with_resistance
from forest_sim.hydraulics.spool_dynamics import Spools
from forest_sim.mechanics.manipulator import Pair


class Ports(NamedTuple):
    """What the spool's four edges connect the hoses of one axis to, and what holds its load behind them."""

    port_1: Port
    port_2: Port
    sensed: Pair = (0.0, 0.0)  # share of a step in which port 1, 2 is open to the supply
    lifts: Lifts = SEATED_LIFTS  # of its load-holding valves, if any


def valve_ports(spool_position: float, law: ValveLaw, vapour: float = -math.inf, tank: float = 0.0) -> Ports:
    """Return both ports at a spool position; shut inside the overlap. Thesis eq. 3.1, 3.2, fig. 2.5.

    Args:
        spool_position: [V].
        law: of the valve.
        vapour: pressure at which the oil boils [Pa].
        tank: P_t in the tank line [Pa].
    """
    e, leakage = edges(spool_position, law), leakage_at(spool_position, law)
    return Ports(
        Port(e.supply_1, e.tank_1, leakage.mean, law.load_check, vapour, leakage.skew, tank),
        Port(e.supply_2, e.tank_2, leakage.mean, law.load_check, vapour, -leakage.skew, tank),
        (1.0 if e.supply_1 < math.inf else 0.0, 1.0 if e.supply_2 < math.inf else 0.0),
    )


def ports_at(
    spools: Spools, p: PlantParameters, lifts: AllLifts = NO_LIFTS, tank: float = 0.0
) -> tuple[Ports, Ports, Ports]:
    """Return the ports of swing, boom and stick at the positions of spools and of load-holding valves.

    Args:
        spools: of the valves.
        p: the machine.
        lifts: of its load-holding valves.
        tank: P_t in the tank line [Pa].
    """
    vapour = -p.supply.oil.above_vapour
    ports = (
        valve_ports(spools[0].position, p.valves[0].law, vapour, tank),
        valve_ports(spools[1].position, p.valves[1].law, vapour, tank),
        valve_ports(spools[2].position, p.valves[2].law, vapour, tank),
    )
    return _with_lifts(ports, lifts, p) if has_poppets(p) else ports


def with_tank(ports: tuple[Ports, Ports, Ports], tank: float) -> tuple[Ports, Ports, Ports]:
    """Return ports with another P_t in the tank line [Pa]."""
    one, two, three = ports
    return _with_tank(one, tank), _with_tank(two, tank), _with_tank(three, tank)


def _with_tank(ports: Ports, tank: float) -> Ports:
    return ports._replace(port_1=ports.port_1._replace(tank=tank), port_2=ports.port_2._replace(tank=tank))


def _with_lifts(
    ports: tuple[Ports, Ports, Ports], lifts: AllLifts, p: PlantParameters
) -> tuple[Ports, Ports, Ports]:
    """Return ports with their load-holding valves and compensators at other lifts."""
    if is_compensated(p):
        ports = (
            metered(ports[0], lifts[0], p.valves[0]),
            metered(ports[1], lifts[1], p.valves[1]),
            metered(ports[2], lifts[2], p.valves[2]),
        )
    return (
        Ports(ports[0].port_1, ports[0].port_2, ports[0].sensed, lifts[0]),
        Ports(ports[1].port_1, ports[1].port_2, ports[1].sensed, lifts[1]),
        Ports(ports[2].port_1, ports[2].port_2, ports[2].sensed, lifts[2]),
    )


def metered(ports: Ports, lifts: Lifts, valve: SpoolValve) -> Ports:
    """Return ports with their compensator in series with the edge that is open to the supply."""
    if valve.compensator.sort == NONE:
        return ports
    more = in_series(lifts.compensator, valve.compensator)
    one, two = with_resistance(ports.port_1, more), with_resistance(ports.port_2, more)
    return Ports(one, two, ports.sensed, ports.lifts)


def has_poppets(p: PlantParameters) -> bool:
    """Tell whether a machine has load-holding valves or compensators, which pressures open."""
    return holds_loads(p) or is_compensated(p)


def is_compensated(p: PlantParameters) -> bool:
    """Tell whether a machine has pressure compensators."""
    return p.valves[0].compensator.sort + p.valves[1].compensator.sort + p.valves[2].compensator.sort != NONE


def holds_loads(p: PlantParameters) -> bool:
    """Tell whether a machine has load-holding valves."""
    return p.swing.holds + p.boom.holds + p.stick.holds != 0
