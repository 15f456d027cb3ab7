"""Voltages with which a machine with another pump repeats a motion under the same load.

Machines that differ in their pump move differently under equal voltages: more goes through an
opening where more pressure is left to it. To compare their energy they have to move alike.

| symbol | name | unit |
|---|---|---|
| u | opening of a valve's direction, 0..1 | 1 |
| F | force of the actuator, A_1 P_1 - A_2 P_2 | N; N m |
| D | pressure that is left to the edges, as a force: A_1 P_s - F - A_2 P_t where port 1 is fed | N; N m |

Through two edges in series goes the same where u^2 D is the same: both drops are C_R Q^2. So the
other valve opens by u sqrt(D/D'), with u, F and D of the recorded motion and D' of the other pump.
A slow position loop takes back what spools, hoses and compressed oil add.
"""

import math

import numpy as np

from forest_description.hydraulics.valve_characteristic import (
    ValveLaw,
    opening_at,
    stroke,
    voltage_for_opening,
)
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_sim.equations.plant import PlantState, transmissions
from forest_sim.equations.plant_parameters import Axis, PlantParameters, plant_parameters
from forest_sim.simulation.open_loop import Block, Run, substeps
from forest_sim.simulation.voltage_profiles import ROUNDING, Voltages
from forest_sim.solver.compiled_plant import ready_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation, advance
from forest_sim.solver.state_recording import restore

GAIN = 3.0  # [1/s] of the position loop
LEAST = 1e-3  # opening below which a valve counts as shut


def following(machine: Machine, led: Machine, motion: Block, run: Run) -> Voltages:
    """Return the voltages that take a machine along a recorded motion.

    Args:
        machine: differs from the other in its pump.
        led: the machine that moved.
        motion: its whole run, one row per period.
        run: how finely.
    """
    p, before, count = plant_parameters(machine), plant_parameters(led), substeps(run)
    step, table = ready_advance() or advance, np.zeros((len(motion.time), 3))
    recorded = [restore(row) for row in motion.states]
    first = recorded[0].plant
    now = equilibrium((first.swing.angle, first.boom.angle, first.stick.angle), p)
    for row, there in enumerate(recorded):
        given = motion.voltages[row].tolist()
        volts = [_voltage(given[axis], axis, there, now, before, p) for axis in range(3)]
        table[row] = volts
        now = step(now, (volts[0], volts[1], volts[2]), run.step, count, p)

    def at(times: Floats) -> Floats:
        rows = np.floor((times + ROUNDING) * run.rate).astype(int)
        held: Floats = table[np.clip(rows, 0, len(table) - 1)]
        return held

    return Voltages("same motion", at, len(table) / run.rate)


def _voltage(
    given: float, axis: int, there: Simulation, now: Simulation, before: PlantParameters, p: PlantParameters
) -> float:
    """Return a valve's voltage, from that of the recorded motion [V]."""
    law, hydraulics = p.valves[axis].law, p.axes[axis]
    forward = given > 0.0
    direction = law.forward if forward else law.backward
    opening = opening_at(stroke(abs(given), direction), law.curve)
    state = there.plant.axes[axis]
    a = hydraulics.actuator
    force = a.displacement_1 * state.pressure_1 - a.displacement_2 * state.pressure_2
    left = _left(force, there.plant.supply.pressure, there.midpoint.tank.pressure, forward, hydraulics)
    here = _left(force, now.plant.supply.pressure, now.midpoint.tank.pressure, forward, hydraulics)
    if opening < LEAST or left <= 0.0 or here <= 0.0:
        return 0.0
    behind = _position(there.plant, axis, before) - _position(now.plant, axis, p)
    full = math.sqrt(here / _resisting(law, forward, hydraulics))  # speed at full opening
    wished = opening * math.sqrt(left / here) + math.copysign(GAIN / full, given) * behind
    return voltage_for_opening(math.copysign(min(1.0, max(0.0, wished)), given), law)


def _left(force: float, supply: float, tank: float, forward: bool, axis: Axis) -> float:
    """Return D [N; N m]."""
    one, two = axis.actuator.displacement_1, axis.actuator.displacement_2
    return one * supply - force - two * tank if forward else two * supply + force - one * tank


def _resisting(law: ValveLaw, forward: bool, axis: Axis) -> float:
    """Return D over the square of the actuator's speed at full opening."""
    one, two = axis.actuator.displacement_1, axis.actuator.displacement_2
    d = law.forward if forward else law.backward
    return d.resistance_1 * one**3 + d.resistance_2 * two**3


def _position(plant: PlantState, axis: int, p: PlantParameters) -> float:
    return transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)[axis].position
