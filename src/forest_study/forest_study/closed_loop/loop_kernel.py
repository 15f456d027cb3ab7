"""The closed loop as machine code: `loop_core.period` over and over, for studies of thousands of runs.

A run gives what `closed_loop.run` gives, to the last bit, for sensors without faults. Python's lock is
released while a run is under way, so that threads use all cores.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from forest_compile import flat_layout
from forest_compile.entry import Entry
from forest_compile.kernel_cache import CachedKernel, can_compile
from forest_control import compiled as control_compiled
from forest_control.config import controller_settings
from forest_control.operator import levers
from forest_control.valve import valve_driver, valve_driver_parameters
from forest_description.machine import Machine, load_machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors import sensor_readings, sensor_suite
from forest_sim.sensors.sensor_readings import CHANNEL_COUNT, NOMINAL, Sensors
from forest_sim.sensors.sensor_suite import Suite, noise_generator
from forest_sim.solver import plant_kernel
from forest_sim.solver.equilibrium import equilibrium
from forest_study.closed_loop import closed_loop, loop_core
from forest_study.closed_loop.closed_loop import Joystick, Operator, Trajectory
from forest_study.closed_loop.link_model import Reports
from forest_study.closed_loop.loop_core import Guarded, Happened, Knowledge, Loop

# What is seldom called stays a function; all else is written out: four seconds to compile, a fifth faster.
NOINLINE = (*plant_kernel.NOINLINE, *control_compiled.NOINLINE)
# state, knowledge, levers (4 a row: swing, boom, stick, enabled), normals, recorded, rows
ARGUMENTS = "pppppi"
RECORDED = 27


class Prepared(NamedTuple):
    """All that a run needs, laid out flat."""

    state: Floats
    knowledge: Floats
    levers: Floats  # [N, 4]
    normals: Floats  # [N, CHANNEL_COUNT]

    def run(self) -> Trajectory:
        """Run the session from its beginning."""
        rows, state = len(self.levers), self.state.copy()
        recorded = np.empty((rows, RECORDED))
        arrays = state, self.knowledge, self.levers, self.normals, recorded
        KERNEL.kernel()(*(array.ctypes.data for array in arrays), rows)
        columns = np.split(recorded, (3, 6, 9, 12, 15), axis=1)  # of `Happened`
        return Trajectory(PERIOD * np.arange(rows, dtype=np.float64), *columns)


def run(*arguments: Any, **named: Any) -> Trajectory:
    """Run a session; arguments and errors as `prepared`."""
    return prepared(*arguments, **named).run()


def by_heart(
    machine: Machine,
    operator: Callable[[float], Joystick],
    duration: float,
    start: Vec3,
    control: controller_settings.Settings,
    drive: valve_driver_parameters.Settings,
    model: Machine | None = None,
    suite: Suite | None = None,
) -> Trajectory:
    """Run a session of an operator who does not look: `closed_loop.run`, compiled where that can be.

    Args:
        machine: what is simulated.
        operator: time [s] to what comes of the joystick; compiled if it speaks in each period.
        duration: [s].
        start: joint angles [rad], at rest.
        control: the controller's settings.
        drive: the valve driver's settings.
        model: what controller and driver believe; default: the machine itself.
        suite: sensors; those with faults are interpreted; default: the machine's, exact.
    """
    done = [operator(k * PERIOD) for k in range(round(duration / PERIOD))]
    spoken = [[*one.levers, one.enabled] for one in done if isinstance(one, Operator)]
    if len(spoken) < len(done) or not can_compile() or (suite is not None and suite.faults):
        said = iter(done)
        return closed_loop.run(machine, lambda _: next(said), duration, start, control, drive, model, suite)
    table = np.array(spoken, dtype=np.float64)
    return run(machine, table, start, control, drive, model, suite)


def prepared(
    machine: Machine,
    levers: Floats,
    start: Vec3,
    control: controller_settings.Settings,
    drive: valve_driver_parameters.Settings,
    model: Machine | None = None,
    suite: Suite | None = None,
    plant: PlantParameters | None = None,
) -> Prepared:
    """Return a session; all as `closed_loop.run`, but for the levers.

    Args:
        machine: what is simulated.
        levers: [N, 4] deflections of swing, boom, stick, and 1 while the deadman is held; a row a period.
        start: joint angles [rad], at rest.
        control: the controller's settings.
        drive: the valve driver's settings.
        model: what controller and driver believe; default: the machine itself.
        suite: sensors without faults; default: the machine's, exact.
        plant: what is simulated instead of the machine's own parameters.

    Raises:
        ValueError: the sensors have faults, or the levers are not four columns.
        ModuleNotFoundError: llvmlite is not installed.
    """
    suite = sensor_suite.sensor_suite(machine) if suite is None else suite
    if suite.faults:
        raise ValueError("sensors with faults are not compiled; use closed_loop.run")
    table = np.ascontiguousarray(levers, dtype=np.float64)
    if table.ndim != 2 or table.shape[1] != 4:
        raise ValueError(f"levers have shape {table.shape}; allowed: a row of 4 a period")
    k = knowledge(machine, machine if model is None else model, control, drive, suite)
    k = k if plant is None else k._replace(sensors=k.sensors._replace(plant=plant))
    loop = begin(k, start, suite)
    state, flat_k = _pack("loop", loop), _pack("knowledge", k)
    return Prepared(state, flat_k, table, draws(suite, len(table)))


def knowledge(
    machine: Machine,
    model: Machine,
    control: controller_settings.Settings,
    drive: valve_driver_parameters.Settings,
    suite: Suite,
) -> Knowledge:
    """Return all that stays in a run."""
    return Knowledge(
        sensors=Sensors(plant_parameters(machine), suite.channels, suite.period, NOMINAL),
        links=machine.manipulator.links,
        control=controller_settings.parameters(model, control),
        drive=valve_driver_parameters.parameters(model, drive),
        guard=loop_core.guard_of(suite),
    )


def begin(k: Knowledge, start: Vec3, suite: Suite) -> Loop:
    """Return the loop as it first reports, having been at rest at joint angles [rad]."""
    rest = equilibrium(start, k.sensors.plant)
    sensors = sensor_readings.at_rest(rest, k.sensors.plant, suite)
    simulation = closed_loop.until_first_report(rest, k.sensors.plant)
    return Loop(
        simulation=simulation, sensors=sensors, control=Guarded(), drive=valve_driver.REST, reports=Reports()
    )


def draws(suite: Suite, rows: int) -> Floats:
    """Return the noise of a run [rows, channels]: what `sensor_suite.draw` would draw row by row."""
    if not any(channel.noise for channel in suite.channels):
        return np.zeros((rows, CHANNEL_COUNT))
    generator, normals = noise_generator(suite), np.empty((rows, CHANNEL_COUNT))
    unused = np.empty(CHANNEL_COUNT)
    for row in normals:
        generator.standard_normal(out=row)
        generator.random(out=unused)
    return normals


def _pack(kind: str, value: Loop | Knowledge) -> Floats:
    """Return numbers laid out flat; all of a kind are of one shape."""
    if kind not in _packers:
        _packers[kind] = flat_layout.packer(value)
    return np.array(_packers[kind](value), dtype=np.float64)


_packers: dict[str, Callable[[Any], flat_layout.Row]] = {}


def entry() -> Entry:
    """Return what the loop's kernel is made of: levers and draws in, what happened out, a row a period."""
    k, loop = _example()
    names: dict[str, Any] = {"period": loop_core.period, "Levers": levers.Levers}
    after = [path for path, _ in flat_layout.leaves(loop, "after")]
    zero = (0.0, 0.0, 0.0)
    out = [
        p
        for p, _ in flat_layout.leaves(
            Happened(
                angles=zero, tip=zero, tip_wish=zero, command=zero, voltages=zero, pressures=(0.0,) * 12
            ),
            "happened",
        )
    ]
    lines = [
        "def kernel(state, knowledge, levers, normals, recorded, rows):",
        "    for row in range(rows):",
        f"        before = {flat_layout.construction(loop, 'state', names)}",
        "        lever = Levers(levers[4 * row], levers[4 * row + 1], levers[4 * row + 2])",
        "        held = levers[4 * row + 3] > 0.5",
        "        after, happened = period(before, lever, held, k, normals, row)",
        *(f"        state[{i}] = {path}" for i, path in enumerate(after)),
        *(f"        recorded[{RECORDED} * row + {i}] = {path}" for i, path in enumerate(out)),
    ]
    tuples = {"k": ("knowledge", k)}
    return Entry(text="\n".join(lines), names=names, arguments=ARGUMENTS, tuples=tuples, noinline=NOINLINE)


@lru_cache(maxsize=1)
def _example() -> tuple[Knowledge, Loop]:
    """Return values of the types that all runs share."""
    machine = load_machine("c180")
    suite = sensor_suite.sensor_suite(machine)
    k = knowledge(machine, machine, controller_settings.Settings(), valve_driver_parameters.Settings(), suite)
    return k, begin(k, (0.0, 0.5, -1.5), suite)


KERNEL = CachedKernel("loop", entry)
"""The compiled loop."""
