"""Free swings of an axis: the simulator's answer to a kick, valves shut."""

import numpy as np

from forest_sim.analysis.modes import operating_point, unguarded
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver.compiled_plant import compiled_advance

SHUT = (0.0, 0.0, 0.0)


def rates_after(machine, axis, kick, seconds, h=2.5e-4):
    """An axis' rates [rad/s] every h [s] after a kick [rad/s] of it, valves shut."""
    p = unguarded(plant_parameters(machine))
    now, advance = operating_point(start_angles(machine), SHUT, p), compiled_advance()
    kicked = getattr(now.plant, axis)._replace(rate=kick)
    now = now._replace(plant=now.plant._replace(**{axis: kicked}))
    rates = []
    for _ in range(round(seconds / h)):
        now = advance(now, SHUT, h, 1, p)
        rates.append(getattr(now.plant, axis).rate)
    return np.array(rates)
