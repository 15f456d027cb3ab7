"""What a step knows of its middle, from the states at its beginning: it is no state of the stages.

Flow forces come first, since they push the spools over the step. Poppets and compensators follow,
which see where the spools end. The tank line follows the stages (`tank_step`).
"""

from typing import NamedTuple

from forest_sim.equations.plant import PlantState
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.equations.valve_ports import holds_loads, is_compensated
from forest_sim.hydraulics.flow_force import NO_JETS, AllJets
from forest_sim.hydraulics.load_holding import NO_LIFTS, AllLifts
from forest_sim.hydraulics.spool_dynamics import Spools
from forest_sim.hydraulics.tank_line import DRAINED, TankState
from forest_sim.midpoint.compensator_step import openings_after
from forest_sim.midpoint.holding_step import lifts_after
from forest_sim.midpoint.pushed_spools import feels_jets, pushed


class MidpointState(NamedTuple):
    """A machine's parts that are known half a step from its states."""

    lifts: AllLifts  # of load-holding valves and compensators
    jets: AllJets  # flow forces on the spools, where they have any
    tank: TankState


NO_MIDPOINT = MidpointState(NO_LIFTS, NO_JETS, DRAINED)


def with_jets(
    midpoint: MidpointState, plant: PlantState, spools: Spools, p: PlantParameters
) -> MidpointState:
    """Return what was known a step ago, but for the flow forces in the middle of this one."""
    if not feels_jets(p):
        return midpoint
    return MidpointState(
        midpoint.lifts, pushed(plant, spools, midpoint.jets, midpoint.tank.seen, p), midpoint.tank
    )


def midpoint_after(
    midpoint: MidpointState, plant: PlantState, spools: Spools, end: Spools, h: float, p: PlantParameters
) -> MidpointState:
    """Return what is known of the middle of a step of h [s].

    Args:
        midpoint: of the step before; with this step's flow forces.
        plant: the states with which it begins.
        spools: with which it begins.
        end: the spools at its end.
        h: its length [s].
        p: the machine.
    """
    lifts, tank = midpoint.lifts, midpoint.tank
    if holds_loads(p):
        lifts = lifts_after(plant, lifts, spools, tank.seen, h, p)
    if is_compensated(p):
        lifts = openings_after(plant, lifts, spools, end, h, p)
    return MidpointState(lifts, midpoint.jets, tank)
