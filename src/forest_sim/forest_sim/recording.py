"""Steps with a record: the state after every period, and the energy that passed through every part within it.

`record` stays in the subset of Python that Numba compiles (`compiled`); without Numba it is interpreted.
The power flows of `power` are integrated over the integrator's own steps with the trapezoidal rule.

| array | shape | holds |
|---|---|---|
| voltages | M, 3 | V at the valves, one row per step |
| states | N, 36 | what `STATE` names, one row per period of M/N steps |
| energies | N, 42 | J over the period through what `ENERGY` names |
"""

import numpy as np
from numpy.typing import NDArray

from forest_sim.integrator import Events, Simulation, step
from forest_sim.mechanics import HeadState
from forest_sim.parameters import PlantParameters
from forest_sim.plant import AxisState, PlantState
from forest_sim.power import AxisPower, PowerFlows, SupplyPower, power_flows
from forest_sim.spool import Spool
from forest_sim.supply import SupplyState

Floats = NDArray[np.float64]

AXES = ("swing", "boom", "stick")
STATE = (
    *(f"{axis}_{field}" for axis in AXES for field in AxisState._fields),
    *(f"supply_{field}" for field in SupplyState._fields),
    *(f"head_{field}" for field in HeadState._fields),
    *(f"{axis}_spool_{field}" for axis in AXES for field in Spool._fields),
    *(f"{axis}_acceleration" for axis in AXES),
    *Events._fields,
)
ENERGY = (
    *(f"pump_{field}" for field in SupplyPower._fields),
    *(f"{axis}_{field}" for axis in AXES for field in AxisPower._fields),
)
_HEAD, _SPOOLS, _ACCELERATIONS, _EVENTS = 20, 24, 30, 33  # columns
_PUMP, _AXIS = len(SupplyPower._fields), len(AxisPower._fields)


def record(
    simulation: Simulation, voltages: Floats, h: float, p: PlantParameters, states: Floats, energies: Floats
) -> Simulation:
    """Advance the machine by one step of h [s] for each row of voltages; fill `states` and `energies`."""
    substeps = voltages.shape[0] // states.shape[0]
    before = power_flows(simulation, p)
    for row in range(states.shape[0]):
        for k in range(row * substeps, (row + 1) * substeps):
            simulation = step(simulation, (voltages[k, 0], voltages[k, 1], voltages[k, 2]), h, p)
            after = power_flows(simulation, p)
            _add(energies[row], before, after, 0.5 * h)
            before = after
        store(simulation, states[row])
    return simulation


def _add(total: Floats, before: PowerFlows, after: PowerFlows, weight: float) -> None:
    for i in range(_PUMP):
        total[i] += weight * (before.pump[i] + after.pump[i])
    for i in range(_AXIS):
        total[_PUMP + i] += weight * (before.swing[i] + after.swing[i])
        total[_PUMP + _AXIS + i] += weight * (before.boom[i] + after.boom[i])
        total[_PUMP + 2 * _AXIS + i] += weight * (before.stick[i] + after.stick[i])


def store(simulation: Simulation, row: Floats) -> None:
    """Write a machine's state into a row of 36 numbers."""
    plant, spools, events = simulation.plant, simulation.spools, simulation.events
    for i in range(6):
        row[i] = plant.swing[i]
        row[6 + i] = plant.boom[i]
        row[12 + i] = plant.stick[i]
    row[18], row[19] = plant.supply.pressure, plant.supply.reference
    for i in range(4):
        row[_HEAD + i] = plant.head[i]
    for i in range(3):
        row[_SPOOLS + 2 * i] = spools[i].position
        row[_SPOOLS + 2 * i + 1] = spools[i].rate
        row[_ACCELERATIONS + i] = simulation.accelerations[i]
        row[_EVENTS + i] = events[i]


def restore(row: Floats) -> Simulation:
    """Return the machine that `store` wrote."""
    v = row.tolist()
    spools = Spool(*v[24:26]), Spool(*v[26:28]), Spool(*v[28:30])
    axes = AxisState(*v[0:6]), AxisState(*v[6:12]), AxisState(*v[12:18])
    plant = PlantState(*axes, SupplyState(*v[18:20]), HeadState(*v[20:24]))
    events = Events(int(v[33]), int(v[34]), int(v[35]))
    return Simulation(plant, spools, events, (v[30], v[31], v[32]))
