"""A load that changes between two steps: what a log that is grasped or dropped does to the machine.

A log that is grasped lies still, and joins the head plastically: in no time, and without bouncing.
Between log and head act only their own forces, and all others are finite. So crane and log keep
their momentum in every coordinate, to which the log has brought none:

    M_after q'_after = M_before q'_before

Angles, pressures and flows stay. A log that is dropped leaves with the velocity that it has: all
rates stay. The crane's spring back is then the work of the oil that the log has pressed.
"""

from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.equations.multibody import Mechanics, mechanics, solve, times
from forest_sim.equations.plant import PlantState
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.mechanics.manipulator import Pair
from forest_sim.mechanics.potential_energy import pendulum_potential_energy, potential_energy
from forest_sim.solver.integrator import Simulation


class LoadChange(NamedTuple):
    """A machine after its load has changed, and where its links' energy has gone."""

    simulation: Simulation
    joining: float  # lost to the plastic impact [J]
    carried_off: float  # that a dropped log takes along, less what a grasped one brings [J]


def changed_load(simulation: Simulation, before: PlantParameters, after: PlantParameters) -> LoadChange:
    """Return the machine as its load becomes another one.

    Args:
        simulation: the machine between two steps.
        before: its parameters until then.
        after: and from then on, with another log in its head.
    """
    plant, joined = simulation.plant, simulation.plant
    joining = 0.0
    if _carried_mass(after) > _carried_mass(before):
        joined = _joined(plant, before, after)
        joining = kinetic_energy(plant, before) - kinetic_energy(joined, after)
    carried_off = link_energy(plant, before) - link_energy(joined, after) - joining
    return LoadChange(simulation._replace(plant=joined), joining, carried_off)


def kinetic_energy(plant: PlantState, p: PlantParameters) -> float:
    """Return the links' 1/2 q'^T M q' [J]."""
    rates, head_rates = _rates(plant)
    momentum, head_momentum = times(_mechanics(plant, p).inertia, rates, head_rates)
    pairs = zip((*rates, *head_rates), (*momentum, *head_momentum), strict=True)
    return 0.5 * sum(rate * of for rate, of in pairs)


def link_energy(plant: PlantState, p: PlantParameters) -> float:
    """Return the links' kinetic and potential energy [J]; zero is a mass at rest at the boom's pivot."""
    q, head = _angles(plant), (plant.head.alpha, plant.head.beta)
    height = potential_energy(q, p.body) + pendulum_potential_energy(q, head, p.head, p.body)
    return kinetic_energy(plant, p) + height


def _carried_mass(p: PlantParameters) -> float:
    return p.body.stick_mass + p.head.mass


def _joined(plant: PlantState, before: PlantParameters, after: PlantParameters) -> PlantState:
    """Return the plant with the rates that keep its momentum."""
    momentum, head_momentum = times(_mechanics(plant, before).inertia, *_rates(plant))
    rates, head_rates = solve(_mechanics(plant, after).inertia, momentum, head_momentum)
    return plant._replace(
        swing=plant.swing._replace(rate=rates[0]),
        boom=plant.boom._replace(rate=rates[1]),
        stick=plant.stick._replace(rate=rates[2]),
        head=plant.head._replace(alpha_rate=head_rates[0], beta_rate=head_rates[1]),
    )


def _mechanics(plant: PlantState, p: PlantParameters) -> Mechanics:
    return mechanics(_angles(plant), _rates(plant)[0], plant.head, p)


def _angles(plant: PlantState) -> Vec3:
    return plant.swing.angle, plant.boom.angle, plant.stick.angle


def _rates(plant: PlantState) -> tuple[Vec3, Pair]:
    """Return the rates of the joints and of the hanging head [rad/s]."""
    head_rates = plant.head.alpha_rate, plant.head.beta_rate
    return (plant.swing.rate, plant.boom.rate, plant.stick.rate), head_rates
