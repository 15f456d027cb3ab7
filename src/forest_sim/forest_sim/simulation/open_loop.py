"""A machine driven by given voltages, without a graph: in blocks, so that a day of it fits into memory.

One row per sampling period, at its end, and one for the start. Times are multiples of the period.
The oil warms from block to block by what the machine loses.
"""

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from forest_description.derived.limits import joint_limits, start_tip, workspace_limits
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import Machine
from forest_description.types import AXES, Floats, Vec3
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.simulation.changing_plant import ChangingPlant
from forest_sim.simulation.disturbance import UNDISTURBED, Disturbance
from forest_sim.simulation.energy_account import dissipated_energy
from forest_sim.simulation.load_schedule import Load, Loads, by_period
from forest_sim.simulation.voltage_profiles import Voltages
from forest_sim.solver import step_schedule
from forest_sim.solver.compiled_plant import Record, fastest_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.oil_temperature import UPDATE_PERIOD, temperature_after
from forest_sim.solver.state_recording import ENERGY, STATE, store
from forest_sim.solver.step_schedule import StepSchedule

BLOCK = UPDATE_PERIOD  # [s]
LIMIT_TOLERANCE = 1e-9  # [rad]


class RunError(ValueError):
    """A run that cannot be: the message names the value and what is allowed."""


class Run(NamedTuple):
    """How long and how finely a machine is simulated."""

    duration: float  # [s]
    rate: float = 200.0  # [Hz] of the rows
    step: float = 1e-3  # [s] of the integrator
    short_after_jumps: bool = False  # long steps, and short ones after a command jumps (`step_schedule`)


class Block(NamedTuple):
    """Some rows of a run; `state_recording` names the columns of states and energies."""

    time: Floats  # [N] s
    voltages: Floats  # [N, 3] V, that act from the row's time on
    states: Floats  # [N, 121]
    energies: Floats  # [N, 69] J, over the period before the row
    temperature: Floats  # [N] K, of the oil; NaN for a machine without
    load: Floats  # [N, 2] kg, m: the log that was held over the period before the row
    load_change: Floats  # [N, 2] J, at the row's time: `LoadChange.joining`, `LoadChange.carried_off`


def start_angles(machine: Machine, tip: Vec3 | None = None) -> Vec3:
    """Return the joint angles [rad] that put the tip at a place [m]; by default as the simulator node starts.

    Raises:
        RunError: the crane does not reach it; the message says what it reaches.
    """
    if tip is None:
        tip = start_tip(machine)
    given = f"tip at ({', '.join(f'{x:g}' for x in tip)}) m"
    w = workspace_limits(machine)
    reach = (
        f"allowed: reach {w.reach_min:.2f} .. {w.reach_max:.2f} m from the swing axis, "
        f"height {w.height_min:.2f} .. {w.height_max:.2f} m over the boom pivot"
    )
    try:
        angles = inverse_kinematics(tip, machine.manipulator.links)
    except ValueError as error:
        raise RunError(f"{given} is out of reach; {reach}") from error
    try:
        return require_within_limits(machine, angles)
    except RunError as error:
        raise RunError(f"{given} is out of reach: it needs the {error}") from error


def require_within_limits(machine: Machine, angles: Vec3) -> Vec3:
    """Return joint angles [rad] if they lie within the joints' limits.

    Raises:
        RunError: one does not; the message names it with its limits.
    """
    for name, angle, (low, high) in zip(AXES, angles, joint_limits(machine), strict=True):
        if not low - LIMIT_TOLERANCE <= angle <= high + LIMIT_TOLERANCE:
            needed, least, most = (f"{math.degrees(a):.1f}" for a in (angle, low, high))
            raise RunError(f"{name} at {needed} deg, allowed there: {least} .. {most} deg")
    return angles


def require_within_rating(machine: Machine, spools: Vec3) -> None:
    """Raise unless spools [V] are within what their valves are rated for.

    Raises:
        RunError: one is not; the message names it with its limit.
    """
    for axis, name in enumerate(AXES):
        rated = machine.valve_of(axis).rated_voltage
        if abs(spools[axis]) > rated:
            raise RunError(f"{name}'s spool at {spools[axis]:g} V; allowed: up to {rated:g} V, its rating")


def substeps(run: Run) -> int:
    """Return how many steps a period has.

    Raises:
        RunError: it has no whole number of steps.
    """
    count = 1.0 / (run.rate * run.step)
    if round(count) < 1 or abs(count - round(count)) > 1e-6:
        raise RunError(
            f"a step of {run.step:g} s at {run.rate:g} Hz; allowed: steps of which a whole number makes "
            f"the period, {1.0 / run.rate:g} s"
        )
    return round(count)


def blocks(
    machine: Machine,
    voltages: Voltages,
    angles: Vec3,
    run: Run,
    disturbance: Disturbance = UNDISTURBED,
    loads: Loads = (),
) -> Iterator[Block]:
    """Simulate, and give the rows as they come; the first block is the start alone.

    Args:
        machine: what is simulated, at rest at the start.
        voltages: what drives it.
        angles: joint angles at the start [rad].
        run: how long and how finely.
        disturbance: what else acts on it, all the time.
        loads: logs that its head grasps and drops.

    Raises:
        RunError: step and rate do not fit, or a volume of the machine runs empty.
    """
    plant, oil = ChangingPlant(machine, disturbance), machine.oil
    temperature = math.nan if oil is None else oil.reference_temperature
    rows = round(run.duration * run.rate)
    commanded = _short_after_jumps if run.short_after_jumps else _even
    changes = {row: load for row, load in by_period(loads, run.rate).items() if row < rows}
    simulation, advance = equilibrium(angles, plant.p), fastest_record()
    _compile(advance, simulation, plant.p, run.step)
    block = _start(simulation, voltages, temperature, plant.load)
    simulation = _changed(simulation, plant, changes.get(0, plant.load), block)
    yield block
    for begin, end in pairwise(_edges(rows, run.rate, changes)):
        count = end - begin
        given, volts = commanded(voltages, run, begin, count)
        states, energies = np.zeros((count, len(STATE))), np.zeros((count, len(ENERGY)))
        simulation = advance(simulation, volts, given, plant.p, states, energies)
        _require_numbers(machine, states, begin, run.rate)
        after = np.arange(begin + 1, end + 1) / run.rate
        block = Block(
            time=after,
            voltages=voltages.at(after),
            states=states,
            energies=energies,
            temperature=np.full(count, temperature),
            load=np.full((count, 2), plant.load),
            load_change=np.zeros((count, 2)),
        )
        simulation = _changed(simulation, plant, changes.get(end, plant.load), block)
        yield block
        if oil is not None:
            time = count / run.rate
            temperature = temperature_after(temperature, dissipated_energy(energies) / time, oil, time)
            plant.warm(temperature)


def _require_numbers(machine: Machine, states: Floats, begin: int, rate: float) -> None:
    """Raise RunError if rows of states [N, ...], the first number `begin` + 1, are none from some row on."""
    lost = np.flatnonzero(np.isnan(states).any(axis=1))
    if len(lost):
        raise RunError(
            f"{machine.name}: at {(begin + 1 + lost[0]) / rate:g} s a state is no number any more; allowed:"
            f" a step of 1 ms or less, and a machine that forest-sim check has no word against"
        )


def _compile(advance: Record, simulation: Simulation, p: PlantParameters, step: float) -> None:
    """Make the kernel before the first row: who times the rows shall time the simulation alone."""
    first = step_schedule.even(step, 1, 1)
    advance(simulation, np.zeros((1, 3)), first, p, np.zeros((1, len(STATE))), np.zeros((1, len(ENERGY))))


def _edges(rows: int, rate: float, changes: Mapping[int, Load]) -> list[int]:
    """Return at which rows blocks begin and end: they are of `BLOCK`, or end where the load changes."""
    per_block = max(1, round(BLOCK * rate))
    return sorted({0, rows, *range(0, rows, per_block), *changes})


def _changed(simulation: Simulation, plant: ChangingPlant, load: Load, block: Block) -> Simulation:
    """Return the machine at a block's last row as it holds another log from then on, if it does."""
    if load == plant.load:
        return simulation
    change = plant.hold(load, simulation)
    block.load_change[-1] = change.joining, change.carried_off
    return change.simulation


def _even(voltages: Voltages, run: Run, begin: int, rows: int) -> tuple[StepSchedule, Floats]:
    """Return even steps for some rows, and the voltages at their beginnings [V]."""
    per_row = substeps(run)
    times = np.arange(begin * per_row, (begin + rows) * per_row) / (per_row * run.rate)
    return step_schedule.even(run.step, rows, per_row), voltages.at(times)


def _short_after_jumps(voltages: Voltages, run: Run, begin: int, rows: int) -> tuple[StepSchedule, Floats]:
    """Return long and short steps for some rows, and the voltages in their middles [V]."""
    period = 1.0 / run.rate
    early = min(begin, step_schedule.ringing_rows(period))  # rows before, whose jumps may still ring
    count = step_schedule.long_steps(period)
    even = step_schedule.even(period / count, early + rows, count)
    table = voltages.at(step_schedule.middles(even, (begin - early) * period))
    before = voltages.at(np.array([(begin - early) * period - 0.5 * period / count]))[0]
    jumped = step_schedule.jumps(table, before if begin > early else np.zeros(3), early + rows)
    whole = step_schedule.after_jumps(jumped, period)
    kept = StepSchedule(whole.steps[early:], whole.counts[early:])
    return kept, voltages.at(step_schedule.middles(kept, begin * period))


def _start(simulation: Simulation, voltages: Voltages, temperature: float, load: Load) -> Block:
    states = np.zeros((1, len(STATE)))
    store(simulation, states[0])
    time = np.zeros(1)
    return Block(
        time=time,
        voltages=voltages.at(time),
        states=states,
        energies=np.zeros((1, len(ENERGY))),
        temperature=np.full(1, temperature),
        load=np.array([load]),
        load_change=np.zeros((1, 2)),
    )


def whole(machine: Machine, voltages: Voltages, angles: Vec3, run: Run, loads: Loads = ()) -> Block:
    """Return a whole run as one block, for runs that fit into memory; arguments as `blocks`."""
    parts = list(blocks(machine, voltages, angles, run, loads=loads))
    return Block(*(np.concatenate(column) for column in zip(*parts, strict=True)))
