"""What a load-sensing line feels over a time step in which edges open or shut.

The line feels an axis from the moment its edge to the supply opens: what the pump's control follows
jumps. Taken at the ends of stages alone, that moment would be off by up to a step, and a step an
integration of first order. A port therefore has its share of the step with that edge open, and the
control follows the mean of the greatest load.
"""

import math

from forest_description.hydraulics.valve_characteristic import SHUT, Direction
from forest_description.types import Vec3
from forest_sim.equations.plant_parameters import PlantParameters, SpoolValve
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.spool_dynamics import Spools
from forest_sim.mechanics.manipulator import Pair


def sensed_over(
    ports: tuple[Ports, Ports, Ports], start: Spools, end: Spools, p: PlantParameters
) -> tuple[Ports, Ports, Ports]:
    """Return ports with their shares of a step over which the spools move from start to end."""
    return (
        _sensed_over(ports[0], start[0].position, end[0].position, p.valves[0]),
        _sensed_over(ports[1], start[1].position, end[1].position, p.valves[1]),
        _sensed_over(ports[2], start[2].position, end[2].position, p.valves[2]),
    )


def _sensed_over(ports: Ports, start: float, end: float, valve: SpoolValve) -> Ports:
    if valve.lag.frequency == math.inf:  # the spool is there at once
        start = end
    forward = open_share(start, end, valve.law.forward)
    shares = forward, open_share(-start, -end, valve.law.backward)
    return Ports(ports.port_1, ports.port_2, shares, ports.lifts)


def open_share(start: float, end: float, d: Direction) -> float:
    """Return the share of a straight way between two spool positions [V] on which an edge is open."""
    edge = d.deadband_voltage + SHUT * (d.rated_voltage - d.deadband_voltage)
    before, after = start - edge, end - edge
    if (before > 0.0) == (after > 0.0):
        return 1.0 if after > 0.0 else 0.0
    return max(before, after) / abs(after - before)


def open_halves(start: float, end: float, d: Direction) -> Pair:
    """Return the shares of the first and of the second half of such a way on which an edge is open."""
    edge = d.deadband_voltage + SHUT * (d.rated_voltage - d.deadband_voltage)
    before, after = start - edge, end - edge
    if (before > 0.0) == (after > 0.0):
        return (1.0, 1.0) if after > 0.0 else (0.0, 0.0)
    crossed = 2.0 * abs(before) / abs(after - before)
    if after > 0.0:
        return max(0.0, 1.0 - crossed), min(1.0, 2.0 - crossed)
    return min(1.0, crossed), max(0.0, crossed - 1.0)


def load_weights(loads: Vec3, shares: Vec3) -> Vec3:
    """Return how much each axis' load [Pa], felt for a share of a step, counts in the mean of the greatest.

    That is exact where one edge opens or shuts within the step.
    """
    greatest, weights = 0.0, (0.0, 0.0, 0.0)
    for i in range(3):
        if shares[i] == 1.0 and loads[i] > greatest:
            greatest, weights = loads[i], _counting(weights, i, 1.0)
    for i in range(3):
        if 0.0 < shares[i] < 1.0 and loads[i] > greatest:
            greatest += shares[i] * (loads[i] - greatest)
            weights = _counting(weights, i, shares[i])
    return weights


def _counting(weights: Vec3, axis: int, share: float) -> Vec3:
    """Return weights of which an axis takes a share."""
    left = 1.0 - share
    return (
        left * weights[0] + (share if axis == 0 else 0.0),
        left * weights[1] + (share if axis == 1 else 0.0),
        left * weights[2] + (share if axis == 2 else 0.0),
    )
