"""Predict the readings of a session: free simulation from its first row on, driven by its voltages.

The simulation starts at rest: angles and pressures are means over the rows before the first voltage. The
oil's temperature is the measured one, second by second. Sensors are exact but for the flow meters' lag
(Table 4.2).

A record of a warming crane needs another plant every second, some hundred times in a fit. All that
the oil changes is smooth in its temperature. So plants are made at multiples of `GRID`, and their numbers are
interpolated by parabolas between three of them. The viscosity, which bends the most, is then right to 2e-6.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_compile import flat_layout
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES, Floats, Vec3
from forest_ident.measurements.readings import Columns, lagged, true_columns
from forest_ident.measurements.session import THERMOCOUPLES, Session
from forest_sim.equations.plant import at_joints
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors.sensor_readings import surroundings
from forest_sim.solver.compiled_plant import fastest_run
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.oil_temperature import parameters_at
from forest_sim.solver.state_recording import STATE, store
from forest_sim.solver.step_schedule import StepSchedule, even

BLOCK = 1.0  # [s] over which the oil has one temperature; 2 s leave 1.7 times the noise of a ringing boom
STEP = 1e-3  # [s] of the integrator
ROUGH = 2.5e-3  # [s] of the integrator where only a change of the readings is asked for, half as long to make
REST_ROWS = 200  # at most, that the mean of the start is taken over
REDRAWN = 4  # times
GRID = 0.5  # [K]


class Offsets(NamedTuple):
    """Static errors of the sensors, true minus read."""

    swing: float = 0.0  # [rad]
    boom: float = 0.0  # [rad]
    stick: float = 0.0  # [rad]
    temperature: float = 0.0  # [K]


TRUE = Offsets()
AS_READ: Mapping[str, float] = {}


def predict(
    machine: Machine,
    session: Session,
    offsets: Offsets = TRUE,
    start: Mapping[str, float] = AS_READ,
    step: float = STEP,
) -> Columns:
    """Return the predicted readings, by channel.

    Args:
        machine: the model; for a rig, the rig's.
        session: whose voltages drive it, from whose start it goes on.
        offsets: of the sensors.
        start: pressures [Pa] and angles [rad] at the start, true minus read, by channel.
        step: of the integrator [s], at most.
    """
    count, period, bench = len(session.time), session.period, session.on_rig
    firsts, plants = _plants(machine, session, offsets.temperature)
    lengths = np.diff([*firsts, count])
    p = _over_time(plants, lengths)
    states = np.empty((count, len(STATE)))
    simulation = _start(session, _layout()[1](plants[0].tolist()), offsets, start)
    store(simulation, states[0])
    substeps = max(1, round(period / step))
    volts, run = np.repeat(session.voltages[:-1], substeps, axis=0), fastest_run(simulation)
    steps = even(period / substeps, count, substeps)
    for first, length, plant in zip(firsts, lengths.tolist(), plants, strict=True):
        end = min(first + length, count - 1)
        part = StepSchedule(steps.steps[first:end], steps.counts[first:end])
        run(volts[substeps * first : substeps * end], part, plant, states[first + 1 : end + 1])
    columns = true_columns(states, p, surroundings(machine), bench, bench)
    meter = machine.sensors.flow_meter
    # Exact meters of the simulator (`--exact`) do not lag.
    lag = meter.time_constant if meter is not None and not session.is_exact else 0.0
    for name in ("swing_flow", "stick_flow"):
        columns[name] = lagged(columns[name], lag, period)
    for axis, offset in zip(AXES, offsets[:3], strict=True):
        columns[f"{axis}_resolver"] = columns[f"{axis}_resolver"] - offset
    return columns


def _plants(machine: Machine, session: Session, offset: float) -> tuple[list[int], Floats]:
    """Return the first row of every block of one temperature, and its plant (blocks, numbers)."""
    count, warm = len(session.time), session.temperature()
    if session.on_rig or machine.oil is None or warm is None:
        return [0], np.array([_layout()[0](plant_parameters(machine))], dtype=np.float64)
    per_block = max(1, round(BLOCK / session.period))
    firsts = list(range(0, count, per_block))
    means = [float(np.mean(warm[first : first + per_block])) + offset for first in firsts]
    return firsts, plants_at(machine, means)


def _over_time(plants: Floats, lengths: NDArray[np.int64]) -> PlantParameters:
    """Return a plant whose numbers are columns, a row of each for every row of a record, where they change.

    Args:
        plants: of the blocks (blocks, numbers).
        lengths: rows of each block. A block's state at its end belongs to it: the first block has one more.
    """
    rows = lengths.copy()
    rows[0] += len(rows) > 1
    rows[-1] -= len(rows) > 1
    same = np.all(plants == plants[0], axis=0).tolist()
    columns = [
        float(plants[0, k]) if still else np.repeat(plants[:, k], rows) for k, still in enumerate(same)
    ]
    return _layout()[1](columns)


def plants_at(machine: Machine, temperatures: Sequence[float]) -> Floats:
    """Return the plant's numbers at several temperatures [K] of the oil (temperatures, numbers).

    They are laid out flat, and interpolated on `GRID`.
    """
    places = np.asarray(temperatures) / GRID
    nearest = np.round(places).astype(np.int64)
    pack, _ = _layout()
    made = {
        k: np.array(pack(parameters_at(machine, k * GRID)), dtype=np.float64)
        for k in {*nearest.tolist(), *(nearest - 1).tolist(), *(nearest + 1).tolist()}
    }
    low, middle, high = (np.array([made[k] for k in (nearest + d).tolist()]) for d in (-1, 0, 1))
    x = (places - nearest)[:, np.newaxis]
    # Infinite ones, and whole numbers, stay as they are.
    below, above = (
        np.subtract(side, middle, out=np.zeros_like(middle), where=side != middle) for side in (low, high)
    )
    return np.asarray(middle + 0.5 * x * ((above - below) + x * (above + below)))


@lru_cache(maxsize=1)
def _layout() -> tuple[Callable[[Any], flat_layout.Row], Callable[[Any], PlantParameters]]:
    example = parameters_at(load_machine("c180_hoses"), 313.15)
    return flat_layout.packer(example), flat_layout.unpacker(example)


def redrawn(machine: Machine, session: Session) -> list[Session]:
    """Return copies of a session, each with the thermocouples' noise drawn once more on their readings.

    The measured temperature drives a prediction; the effect of its noise does not show in the residuals.
    Empty where the temperature drives nothing, or its sensors are exact.
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


def _start(session: Session, p: PlantParameters, offsets: Offsets, start: Mapping[str, float]) -> Simulation:
    """Return the plant at rest where the session starts."""
    if session.on_rig:
        return equilibrium((0.0, 0.5, -1.5), p)
    rests = [rest(session, axis == "swing") for axis in AXES]
    columns = [session.column(f"{axis}_resolver") for axis in AXES]
    angles = [
        float(np.mean(column[rows])) + start.get(f"{axis}_resolver", 0.0)
        for axis, column, rows in zip(AXES, columns, rests, strict=True)
    ]
    rows = rests[0]
    true = tuple(angle + offset for angle, offset in zip(angles, offsets[:3], strict=True))
    at_rest = resting_at((true[0], true[1], true[2]), p)
    plant = at_rest.plant
    for axis in AXES:
        ports = [f"{axis}_pressure_{port}_actuator" for port in (1, 2)]
        if session.has(*ports):
            one, two = (float(np.mean(session.column(port)[rows])) + start.get(port, 0.0) for port in ports)
            state = getattr(plant, axis)._replace(pressure_1=one, pressure_2=two)
            plant = plant._replace(**{axis: state})
    return at_rest._replace(plant=plant)


def resting_at(joints: Vec3, p: PlantParameters) -> Simulation:
    """Return the plant at rest with its joints at angles [rad], as resolvers read them; within 0.1 urad.

    Args:
        joints: angles [rad]; links that bend hang below them.
        p: the plant.
    """
    links = joints
    for _ in range(2 if p.elastic.present else 0):  # bending hardly changes over its own way: 1 % each time
        held = at_joints(equilibrium(links, p).plant, p)
        away = [joint - axis.angle for joint, axis in zip(joints, held.axes, strict=True)]
        links = links[0] + away[0], links[1] + away[1], links[2] + away[2]
    return equilibrium(links, p)
