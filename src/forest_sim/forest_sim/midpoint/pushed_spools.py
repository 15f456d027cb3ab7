"""Flow forces over a step: what they push the spools by in its middle, from the states at its beginning.

A step's push is 3/2 of the force at its beginning less 1/2 of that a step before (Adams-Bashforth):
of second order, and without a word in the stages' equations. It is stable at any bandwidth as long as
the jets take less than half of a spool's stroke, which a machine file must obey.
"""

import math

from forest_sim.equations.plant import AxisState, PlantState
from forest_sim.equations.plant_parameters import PlantParameters, SpoolValve
from forest_sim.equations.valve_ports import valve_ports
from forest_sim.hydraulics.flow_force import AllJets, Jets, port_momentum
from forest_sim.hydraulics.spool_dynamics import Spools


def feels_jets(p: PlantParameters) -> bool:
    """Tell whether flow forces push a spool of the machine."""
    return p.valves[0].lag.jet + p.valves[1].lag.jet + p.valves[2].lag.jet != 0.0


def pushed(plant: PlantState, spools: Spools, jets: AllJets, tank: float, p: PlantParameters) -> AllJets:
    """Return what pushes the spools in a step that begins with them; not inlined."""
    supply = plant.supply.pressure
    return (
        _pushed(plant.swing, spools[0].position, jets[0], p.valves[0], supply, tank),
        _pushed(plant.boom, spools[1].position, jets[1], p.valves[1], supply, tank),
        _pushed(plant.stick, spools[2].position, jets[2], p.valves[2], supply, tank),
    )


def _pushed(s: AxisState, position: float, jets: Jets, valve: SpoolValve, supply: float, tank: float) -> Jets:
    if valve.lag.jet == 0.0:
        return jets
    ports = valve_ports(position, valve.law, -math.inf, tank)
    one = port_momentum(s.pressure_1, s.flow_1, ports.port_1, supply)
    two = port_momentum(s.pressure_2, -s.flow_2, ports.port_2, supply)
    force = valve.lag.jet * (one - two)
    return Jets(force, 1.5 * force - 0.5 * jets.force)
