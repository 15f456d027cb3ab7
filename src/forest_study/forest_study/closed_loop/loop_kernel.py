"""The closed loop as machine code: `loop_core.period` over and over, for studies of thousands of runs.

A run gives what `closed_loop.run` gives, to the last bit, for sensors without faults. Python's lock is
released while a run is under way, so that threads use all cores.
"""

from collections.abc import Callable, Mapping
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
from forest_description.geometry.kinematics import Links, tip_position
from forest_description.machine import Machine, load_machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors import sensor_readings, sensor_suite
from forest_sim.sensors.sensor_readings import CHANNEL_COUNT, NOMINAL, Sensors
from forest_sim.sensors.sensor_suite import Suite, noise_generator
from forest_sim.solver import plant_kernel
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.load_change import changed_load
from forest_study.closed_loop import closed_loop, loop_core, path_guide
from forest_study.closed_loop.closed_loop import ClosedLoop, Joystick, Operator, Trajectory
from forest_study.closed_loop.link_model import Reports
from forest_study.closed_loop.loop_core import Guarded, Happened, Knowledge, Loop
from forest_study.closed_loop.path_guide import Guide, Hand, levers_for

# What is seldom called stays a function; all else is written out: four seconds to compile, a fifth faster.
NOINLINE = (*plant_kernel.NOINLINE, *control_compiled.NOINLINE)
# state, knowledge, levers (4 a row: swing, boom, stick, enabled), normals, recorded, rows; of an operator who
# leads the reference: places (3 a period), hand and guide, the clock of each row; numbers given as it runs
ARGUMENTS = "pppppipppp"
NO_LOADS: Mapping[int, PlantParameters] = {}
LEADS_NOT = np.array([0.0, 1.0, 0.0, 1.0, *[0.0] * 7])  # of hand and guide
EVERY = 3  # place of the joystick's periods there
HAPPENED = [path for path, _ in flat_layout.leaves(loop_core.NOTHING, "happened")]
_happened = flat_layout.unpacker(loop_core.NOTHING)
runtime_numbers = np.zeros(1)
"""Values of those numbers that this process has made `RuntimeNumber`s: none, but in an ablation."""


class Led(NamedTuple):
    """What happened while an operator led the reference along a path."""

    moved: Trajectory
    levers: Floats  # [N, 4] as they were said
    clock: Floats  # [N] periods of the profile that were asked for before


class Prepared(NamedTuple):
    """All that a run needs, laid out flat."""

    state: Floats
    knowledge: Floats
    levers: Floats  # [N, 4]
    normals: Floats  # [N, CHANNEL_COUNT]

    def run(self, loads: Mapping[int, PlantParameters] = NO_LOADS) -> Trajectory:
        """Run the session from its beginning.

        Args:
            loads: what is simulated from rows on in which the head grasps or drops a log.
        """
        return self._run(np.zeros(3), LEADS_NOT.copy(), loads).moved

    def lead(self, places: Floats, hand: Hand) -> Led:
        """Run a session in which an operator leads the reference; of the levers only the deadman counts.

        It ends with the last of the places, or with the rows that there are.

        Args:
            places: of the profile, a row a period [K, 3] m.
            hand: joystick and operator.
        """
        guide = np.array([len(places) - 1, *hand, 0.0, 0.0, *places[0], 0.0])
        return self._run(np.ascontiguousarray(places), guide, NO_LOADS)

    def _run(self, places: Floats, guide: Floats, loads: Mapping[int, PlantParameters]) -> Led:
        session, rows = Session(self, places, guide), len(self.levers)
        for row in (*sorted(loads), rows):
            session.advance(row)
            if row in loads:
                session.change_load(loads[row])
        made = session.row
        return Led(session.moved, session.levers[:made], session.clock[:made])


class Session:
    """A session that stops on its way: what happened so far may decide what the levers say next.

    Args:
        prepared: its beginning, and as many rows of levers and draws as it has at most.
        places: of a path that an operator leads the reference along; none, unless given.
        guide: of hand and operator there.
        every: periods between two words of the joystick, of a session without a guide.
    """

    def __init__(
        self,
        prepared: Prepared,
        places: Floats | None = None,
        guide: Floats | None = None,
        every: int = 1,
    ) -> None:
        self.state, self.knowledge = prepared.state.copy(), prepared.knowledge.copy()
        self.levers, rows = prepared.levers.copy(), len(prepared.levers)
        self._recorded, self.clock = np.empty((rows, len(HAPPENED))), np.zeros(rows)
        self._guide = LEADS_NOT.copy() if guide is None else guide
        if guide is None:
            self._guide[EVERY] = every
        held = self.state, self.knowledge, self.levers, prepared.normals, self._recorded
        after = np.zeros(3) if places is None else places, self._guide, self.clock
        self._arrays = held, after  # kept: the kernel holds their addresses
        self._before, self._after = ([array.ctypes.data for array in arrays] for arrays in self._arrays)
        self._kernel = KERNEL.kernel()

    @property
    def row(self) -> int:
        """How many rows there are so far."""
        return int(self._guide[-1])

    def advance(self, rows: int) -> None:
        """Go on until so many rows are there, or the path ends."""
        self._kernel(*self._before, rows, *self._after, runtime_numbers.ctypes.data)

    @property
    def newest(self) -> Happened:
        """What happened in the newest row."""
        found: Happened = _happened(self._recorded[self.row - 1].tolist())
        return found

    @property
    def moved(self) -> Trajectory:
        """What happened so far; its arrays are views."""
        ends = np.cumsum([len(part) for part in loop_core.NOTHING])
        columns = np.split(self._recorded[: self.row], ends[:-1], axis=1)
        return Trajectory(PERIOD * np.arange(self.row, dtype=np.float64), *columns)

    def change_load(self, plant: PlantParameters) -> None:
        """Go on with the parameters of a machine whose head holds another log."""
        _change_load(self.state, self.knowledge, plant)

    @property
    def loop(self) -> Loop:
        """All that is remembered."""
        found: Loop = flat_layout.unpacker(_example()[1])(self.state.tolist())
        return found


def _change_load(state: Floats, knowledge: Floats, plant: PlantParameters) -> None:
    """Go on with the parameters of a machine whose head holds another log."""
    loop: Loop = flat_layout.unpacker(_example()[1])(state.tolist())
    k: Knowledge = flat_layout.unpacker(_example()[0])(knowledge.tolist())
    simulation = changed_load(loop.simulation, k.sensors.plant, plant).simulation
    state[:] = _pack("loop", loop._replace(simulation=simulation))
    knowledge[:] = _pack("knowledge", k._replace(sensors=k.sensors._replace(plant=plant)))


def run(*arguments: Any, **named: Any) -> Trajectory:
    """Run a session; arguments and errors as `prepared`."""
    return prepared(*arguments, **named).run()


def lead_interpreted(loop: ClosedLoop, links: Links, places: Floats, hand: Hand, rows: int) -> Led:
    """Do as `Prepared.lead` in an interpreted loop, whose machine has these links."""
    last, flat = len(places) - 1, places.ravel().tolist()
    x, y, z = places[0].tolist()
    guide, lever = Guide(0.0, 0.0, (x, y, z)), levers.REST
    happened: list[Happened] = []
    said: list[tuple[float, ...]] = []
    clock: list[float] = []
    while len(said) < rows and guide.clock < last:
        spoken = len(said) % hand.every == 0
        lever = levers_for(path_guide.asked(guide, hand, flat, last), hand) if spoken else lever
        clock.append(guide.clock)
        said.append((*lever, 1.0))
        one = loop.period(Operator(lever) if spoken else None)
        happened.append(one._replace(tip=tip_position(one.angles, links)))
        guide = path_guide.answered(guide, lever, one.tip_wish, hand, flat, last)
    columns = [np.array(column) for column in zip(*happened, strict=True)]
    moved = Trajectory(PERIOD * np.arange(len(said), dtype=np.float64), *columns)
    return Led(moved, np.array(said), np.array(clock))


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
    names |= {f.__name__: f for f in (Guide, Hand, path_guide.asked, path_guide.answered, levers_for)}
    after = [path for path, _ in flat_layout.leaves(loop, "after")]
    lines = [
        "def kernel(state, knowledge, levers, normals, recorded, rows, places, guide, clock, runtime):",
        "    last, every = int(guide[0]), int(guide[3])",
        "    hand = Hand(guide[1], guide[2], every, guide[4])",
        "    for row in range(int(guide[10]), rows):",
        f"        before = {flat_layout.construction(loop, 'state', names)}",
        "        spoken = row % every == 0",
        "        led = Guide(guide[5], guide[6], (guide[7], guide[8], guide[9]))",
        "        lever = Levers(levers[4 * row], levers[4 * row + 1], levers[4 * row + 2])",
        "        if last > 0:",
        "            if spoken:",
        "                lever = levers_for(asked(led, hand, places, last), hand)",
        "            else:",
        "                lever = Levers(levers[4 * row - 4], levers[4 * row - 3], levers[4 * row - 2])",
        "            levers[4 * row] = lever.swing",
        "            levers[4 * row + 1] = lever.boom",
        "            levers[4 * row + 2] = lever.stick",
        "            clock[row] = led.clock",
        "        held = levers[4 * row + 3] > 0.5",
        "        after, happened = period(before, lever, held, spoken, k, normals, row)",
        *(f"        state[{i}] = {path}" for i, path in enumerate(after)),
        *(f"        recorded[{len(HAPPENED)} * row + {i}] = {path}" for i, path in enumerate(HAPPENED)),
        "        guide[10] = row + 1",
        "        if last > 0:",
        "            led = answered(led, lever, happened.tip_wish, hand, places, last)",
        "            guide[5] = led.clock",
        "            guide[6] = led.beside",
        "            guide[7] = led.place[0]",
        "            guide[8] = led.place[1]",
        "            guide[9] = led.place[2]",
        "            if led.clock >= last:",
        "                break",
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
