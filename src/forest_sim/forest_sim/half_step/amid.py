"""What a step knows of its middle, from the states at its beginning: it is no state of the stages.

Flow forces come first, since they push the spools over the step. Poppets, compensators and the tank
line follow, which see where the spools end.
"""

from typing import NamedTuple

from forest_sim.equations.plant import PlantState
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.equations.valve_ports import holds_loads, is_compensated
from forest_sim.half_step.compensator_step import openings_after
from forest_sim.half_step.holding_step import lifts_after
from forest_sim.half_step.pushed_spools import feels_jets, pushed
from forest_sim.half_step.tank_step import tank_amid
from forest_sim.hydraulics.flow_force import NO_JETS, AllJets
from forest_sim.hydraulics.load_holding import NO_LIFTS, AllLifts
from forest_sim.hydraulics.spool_dynamics import Spools
from forest_sim.hydraulics.tank_line import DRAINED, TankState


class Amid(NamedTuple):
    """A machine's parts that are known half a step from its states."""

    lifts: AllLifts  # of load-holding valves and compensators
    jets: AllJets  # flow forces on the spools, where they have any
    tank: TankState


NOTHING_AMID = Amid(NO_LIFTS, NO_JETS, DRAINED)


def with_jets(amid: Amid, plant: PlantState, spools: Spools, p: PlantParameters) -> Amid:
    """Return what was known a step ago, but for the flow forces in the middle of this one."""
    if not feels_jets(p):
        return amid
    return Amid(amid.lifts, pushed(plant, spools, amid.jets, amid.tank.seen, p), amid.tank)


def amid_after(
    amid: Amid, plant: PlantState, spools: Spools, end: Spools, h: float, p: PlantParameters
) -> Amid:
    """Return what is known of the middle of a step of h [s].

    Args:
        amid: of the step before; with this step's flow forces.
        plant: the states with which it begins.
        spools: with which it begins.
        end: the spools at its end.
        h: its length [s].
        p: the machine.
    """
    lifts, tank = amid.lifts, amid.tank
    if holds_loads(p):
        lifts = lifts_after(plant, lifts, spools, tank.seen, h, p)
    if is_compensated(p):
        lifts = openings_after(plant, lifts, spools, end, h, p)
    if p.tank_line.capacitance > 0.0:
        tank = tank_amid(plant, spools, lifts, tank, h, p)
    return Amid(lifts, amid.jets, tank)
