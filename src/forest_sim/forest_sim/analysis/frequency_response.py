"""How a joint and its pressures answer a small oscillation of its spool, about a steady motion.

| symbol | name | unit |
|---|---|---|
| A | `modes.linearise` | 1/s |
| B | df/du of the spool's position, by central differences | |
| H(jw) | joint rate, of an elastic link's root, over spool position, c (jw - A)^-1 B | rad/(s V) |
| P(jw) | pressure at an actuator's port over spool position, alike | Pa/V |

It holds for amplitudes that keep the valve open and the pose near, and for load-holding valves, flow
forces and tank line that stand as they are (`modes`).
"""

import math
from typing import NamedTuple

import numpy as np

from forest_description.types import Complexes, Floats, Vec3
from forest_sim.analysis.modes import ROOTS, linearise, operating_point, rates_at, states, unguarded
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.hydraulics.spool_dynamics import Spool, SpoolLag
from forest_sim.mechanics.gear import without_play

DIFFERENCE = 1e-4  # [V] of a spool
RATE, PRESSURE_1, PRESSURE_2 = 1, 2, 3  # places among an axis' states; of a rate among a root's, too


class Response(NamedTuple):
    """What a joint answers, at some frequencies."""

    steady_rate: float  # [rad/s] in whose motion it answers
    rate: Complexes  # [n] H
    pressure_1: Complexes  # [n] P
    pressure_2: Complexes


def response_of(angles: Vec3, axis: int, voltage: float, p: PlantParameters, frequency: Floats) -> Response:
    """Return how a joint in steady motion answers its spool.

    Args:
        angles: pose through which the joint moves [rad].
        axis: that moves; the others' valves are shut.
        voltage: of its spool [V], beyond the overlap.
        p: the machine; port valves, stops, cushions and a gear's play are left out.
        frequency: [n] Hz.

    Raises:
        ValueError: the spool lies in its overlap.
    """
    p = unguarded(p)
    p = p._replace(drive=p.drive._replace(gear=without_play(p.drive.gear)))
    spools = [0.0, 0.0, 0.0]
    spools[axis] = voltage
    point = operating_point(angles, (spools[0], spools[1], spools[2]), p)
    a, kept = linearise(point, p)
    x = np.array([*states(point.plant), *(lifts.compensator for lifts in point.midpoint.lifts)])
    up, down = (rates_at(x, _moved(point.spools, axis, by), point, p) for by in (DIFFERENCE, -DIFFERENCE))
    b = (up - down)[list(kept)] / (2.0 * DIFFERENCE)
    if not b.any():
        raise ValueError(f"{voltage:g} V leave the valve shut; allowed: more than its deadband")
    elastic = p.elastic.links[axis].inertia > 0.0
    place = kept.index((ROOTS + 2 * axis if elastic else 6 * axis) + RATE)
    values, vectors = np.linalg.eig(a)
    places = [place, *(kept.index(6 * axis + port) for port in (PRESSURE_1, PRESSURE_2))]
    weights = vectors[places] * np.linalg.solve(vectors, b.astype(complex))
    s = 2j * math.pi * frequency[:, np.newaxis]
    answers = [np.sum(row / (s - values), axis=1) for row in weights]
    return Response(point.plant.axes[axis].rate, *answers)


def spool_response(lag: SpoolLag, frequency: Floats) -> Complexes:
    """Return the position of a spool over its voltage at some frequencies [Hz], by its lag alone."""
    late: Complexes = np.exp(-2j * math.pi * frequency * lag.dead_time)
    if lag.frequency == math.inf:
        return late
    s = 2j * math.pi * frequency / lag.frequency
    response: Complexes = 1.0 + s if lag.damping == 0.0 else 1.0 + 2.0 * lag.damping * s + s * s
    return late / response


def _moved(spools: tuple[Spool, Spool, Spool], axis: int, by: float) -> tuple[Spool, Spool, Spool]:
    one, two, three = (
        spool._replace(position=spool.position + by) if place == axis else spool
        for place, spool in enumerate(spools)
    )
    return one, two, three
