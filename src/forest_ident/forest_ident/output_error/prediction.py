"""What a machine would have read during a session: free simulation from its first row on, same voltages.

The start is at rest where the session starts: angles and pressures are means over the rows before the first
voltage. The oil's temperature is the measured one, second by second. Exact sensors but for the flow meters'
lag, which Table 4.2 tells.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.measurements.readings import Columns, lagged, true_columns
from forest_ident.measurements.session import THERMOCOUPLES, Session
from forest_ident.output_error.temperature_interpolation import plants_at
from forest_sim.sensors.sensor_readings import surroundings
from forest_sim.solver.compiled_plant import fastest_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.plant_parameters import PlantParameters, plant_parameters
from forest_sim.solver.state_recording import STATE, store
from forest_sim.solver.step_schedule import even

BLOCK = 1.0  # [s] over which the oil has one temperature
STEP = 1e-3  # [s] of the integrator
REST_ROWS = 200  # at most, that the mean of the start is taken over
REDRAWN = 8  # times


class Offsets(NamedTuple):
    """What the model may have to be told wrong by the sensors: true minus read."""

    swing: float = 0.0  # [rad]
    boom: float = 0.0  # [rad]
    stick: float = 0.0  # [rad]
    temperature: float = 0.0  # [K]


TRUE = Offsets()
AS_READ: Mapping[str, float] = {}


def predict(
    machine: Machine,
    session: Session,
    bench: bool,
    offsets: Offsets = TRUE,
    valves: bool = False,
    begun: Mapping[str, float] = AS_READ,
) -> Columns:
    """Return the predicted readings, by channel.

    Args:
        machine: the model; for a rig, the rig's.
        session: whose voltages drive it, from whose start it goes on.
        bench: whether the session was on a rig of `bench`.
        offsets: of the sensors.
        valves: whether pressures at the valves are wanted; a rig's always are.
        begun: pressures at the start [Pa], true minus read, by channel.
    """
    count, period = len(session.time), session.period
    plants = _plants(machine, session, bench, offsets.temperature)
    states = np.zeros((count, len(STATE)))
    simulation = _start(session, plants[0][2], bench, offsets, begun)
    store(simulation, states[0])
    substeps = max(1, round(period / STEP))
    record = fastest_record()
    around = surroundings(machine)
    parts = []
    for first, last, p in plants:
        rows = slice(first + 1, min(last, count - 1) + 1)
        volts = np.repeat(session.voltages[first : rows.stop - 1], substeps, axis=0)
        if len(volts) > 0:
            steps = even(period / substeps, rows.stop - rows.start, substeps)
            simulation = record(simulation, volts, steps, p, states[rows], None)
        seen = slice(0 if first == 0 else first + 1, rows.stop)
        parts.append(true_columns(states[seen], p, around, bench, bench or valves))
    of = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    meter = machine.sensors.flow_meter
    # Exact meters of the simulator (`--exact`) do not lag.
    lag = meter.time_constant if meter is not None and not session.is_exact else 0.0
    for name in ("swing_flow", "stick_flow"):
        of[name] = lagged(of[name], lag, period)
    for axis, offset in zip(AXES, offsets[:3], strict=True):
        of[f"{axis}_resolver"] = of[f"{axis}_resolver"] - offset
    return of


def _plants(
    machine: Machine, session: Session, bench: bool, offset: float
) -> list[tuple[int, int, PlantParameters]]:
    """Return (first row, row after the last, plant) of the blocks of one temperature."""
    count, warm = len(session.time), session.temperature()
    if bench or machine.oil is None or warm is None:
        return [(0, count, plant_parameters(machine))]
    per_block = max(1, round(BLOCK / session.period))
    firsts = list(range(0, count, per_block))
    means = [float(np.mean(warm[first : first + per_block])) + offset for first in firsts]
    plants = plants_at(machine, means)
    return [(first, min(first + per_block, count), p) for first, p in zip(firsts, plants, strict=True)]


def redrawn(machine: Machine, session: Session) -> list[Session]:
    """Return a session some times over, each time with the thermocouples' noise once more on their readings.

    The measured temperature drives a prediction: what its noise does, does not show in the residuals. Empty
    where the temperature drives nothing, or its sensors are exact.
    """
    part = machine.sensors.thermocouple
    noise = 0.0 if part is None or session.is_exact else part.noise or 0.0
    if noise == 0.0 or machine.oil is None:
        return []
    names, generator = [name for name in THERMOCOUPLES if session.has(name)], np.random.default_rng(0)
    found = []
    for _ in range(REDRAWN if names else 0):
        more = {name: generator.normal(session.column(name), noise) for name in names}
        found.append(dataclasses.replace(session, readings={**session.readings, **more}))
    return found


def rest(session: Session, creeps: bool = True) -> slice:
    """Return the rows at rest of which the start is the mean.

    Args:
        session: of the crane.
        creeps: whether it is asked for an axis that moves with its valve shut. If no voltage ever comes, a
            creep is what the session is about, and it may begin with the first row.
    """
    moving = np.flatnonzero(np.any(session.voltages != 0.0, axis=1))
    if len(moving) == 0:
        return slice(0, 1 if creeps else min(REST_ROWS, len(session.time)))
    return slice(0, max(1, min(int(moving[0]), REST_ROWS)))


def _start(
    session: Session, p: PlantParameters, bench: bool, offsets: Offsets, begun: Mapping[str, float]
) -> Simulation:
    """Return the plant at rest where the session starts."""
    if bench:
        return equilibrium((0.0, 0.5, -1.5), p)
    rests = [rest(session, axis == "swing") for axis in AXES]
    columns = [session.column(f"{axis}_resolver") for axis in AXES]
    angles = [float(np.mean(column[rows])) for column, rows in zip(columns, rests, strict=True)]
    rows = rests[0]
    true = tuple(angle + offset for angle, offset in zip(angles, offsets[:3], strict=True))
    at_rest = equilibrium((true[0], true[1], true[2]), p)
    plant = at_rest.plant
    for axis in AXES:
        ports = [f"{axis}_pressure_{port}_actuator" for port in (1, 2)]
        if session.has(*ports):
            one, two = (float(np.mean(session.column(port)[rows])) + begun.get(port, 0.0) for port in ports)
            state = getattr(plant, axis)._replace(pressure_1=one, pressure_2=two)
            plant = plant._replace(**{axis: state})
    return at_rest._replace(plant=plant)
