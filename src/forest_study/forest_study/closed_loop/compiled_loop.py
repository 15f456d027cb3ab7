"""The closed loop as machine code, for studies of thousands of runs.

A run gives what `closed_loop.run` gives, to the last bit, for sensors without faults. Python's lock is
released while a run is under way, so that threads use all cores.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from forest_compile import flat_layout
from forest_compile.kernel_cache import can_compile
from forest_control.config import controller_settings
from forest_control.operator import levers
from forest_control.valve import valve_driver_parameters
from forest_description.geometry.kinematics import Links, tip_position
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors import sensor_suite
from forest_sim.sensors.sensor_readings import CHANNEL_COUNT
from forest_sim.sensors.sensor_suite import DRAW_OF, DRAWN, Suite, noise_generator
from forest_sim.solver.load_change import changed_load
from forest_study.closed_loop import closed_loop, loop_core, loop_kernel, path_guide
from forest_study.closed_loop.closed_loop import ClosedLoop, Joystick, Operator, Trajectory
from forest_study.closed_loop.loop_core import Happened, Knowledge, Loop
from forest_study.closed_loop.path_guide import Guide, Hand, levers_for

NO_LOADS: Mapping[int, PlantParameters] = {}
LEADS_NOT = np.array([0.0, 1.0, 0.0, 1.0, *[0.0] * 7])  # of hand and guide
EVERY = 3  # place of the joystick's periods there
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
        self._recorded, self.clock = np.empty((rows, len(loop_kernel.HAPPENED))), np.zeros(rows)
        self._guide = LEADS_NOT.copy() if guide is None else guide
        if guide is None:
            self._guide[EVERY] = every
        held = self.state, self.knowledge, self.levers, prepared.normals, self._recorded
        after = np.zeros(3) if places is None else places, self._guide, self.clock
        self._arrays = held, after  # kept: the kernel holds their addresses
        self._before, self._after = ([array.ctypes.data for array in arrays] for arrays in self._arrays)
        self._kernel = loop_kernel.KERNEL.kernel()

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
    def head(self) -> tuple[float, float]:
        """Angles of what hangs from the tip [rad]."""
        alpha, beta = self.state[_places_of_head()].tolist()
        return alpha, beta

    @property
    def loop(self) -> Loop:
        """All that is remembered."""
        found: Loop = flat_layout.unpacker(loop_kernel.example()[1])(self.state.tolist())
        return found


@lru_cache(maxsize=1)
def _places_of_head() -> list[int]:
    """Return where the angles of what hangs lie in a state."""
    names = [path for path, _ in flat_layout.leaves(loop_kernel.example()[1], "loop")]
    return [names.index(f"loop.simulation.plant.head.{name}") for name in ("alpha", "beta")]


def _change_load(state: Floats, knowledge: Floats, plant: PlantParameters) -> None:
    """Go on with the parameters of a machine whose head holds another log."""
    loop: Loop = flat_layout.unpacker(loop_kernel.example()[1])(state.tolist())
    k: Knowledge = flat_layout.unpacker(loop_kernel.example()[0])(knowledge.tolist())
    simulation = changed_load(loop.simulation, k.sensors.plant, plant).simulation
    state[:] = loop_kernel.pack("loop", loop._replace(simulation=simulation))
    knowledge[:] = loop_kernel.pack("knowledge", k._replace(sensors=k.sensors._replace(plant=plant)))


def run(*arguments: Any, **named: Any) -> Trajectory:
    """Run a session; arguments and errors as `prepared`."""
    return prepared(*arguments, **named).run()


class Interpreted(NamedTuple):
    """A session as `Prepared`, in Python: slower by a factor of ten, and there at once."""

    loop: ClosedLoop
    links: Links  # of its machine
    rows: int

    def lead(self, places: Floats, hand: Hand) -> Led:
        """Do as `Prepared.lead`."""
        last, flat = len(places) - 1, places.ravel().tolist()
        x, y, z = places[0].tolist()
        guide, lever = Guide(0.0, 0.0, (x, y, z)), levers.REST
        happened: list[Happened] = []
        said: list[tuple[float, ...]] = []
        clock: list[float] = []
        while len(said) < self.rows and guide.clock < last:
            spoken = len(said) % hand.every == 0
            lever = levers_for(path_guide.asked(guide, hand, flat, last), hand) if spoken else lever
            clock.append(guide.clock)
            said.append((*lever, 1.0))
            one = self.loop.period(Operator(lever) if spoken else None)
            happened.append(one._replace(tip=tip_position(one.angles, self.links)))
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
        given = machine, lambda _: next(said), duration, start, control, drive, model, suite
        return closed_loop.run(*given, fast=True)
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
    substeps: int = loop_core.SUBSTEPS,
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
        substeps: of the machine, to a period of 5 ms.

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
    k = loop_kernel.knowledge(machine, machine if model is None else model, control, drive, suite, substeps)
    k = k if plant is None else k._replace(sensors=k.sensors._replace(plant=plant))
    loop = loop_kernel.begin(k, start, suite)
    state, flat_k = loop_kernel.pack("loop", loop), loop_kernel.pack("knowledge", k)
    return Prepared(state, flat_k, table, draws(suite, len(table)))


def interpreted(
    machine: Machine,
    rows: int,
    start: Vec3,
    control: controller_settings.Settings,
    drive: valve_driver_parameters.Settings,
    model: Machine,
    suite: Suite | None,
    plant: PlantParameters | None,
    substeps: int = loop_core.SUBSTEPS,
    fast: bool = True,
) -> Interpreted:
    """Return a session of so many rows at most; arguments as `prepared`, `fast` as of `ClosedLoop`."""
    loop = ClosedLoop(
        plant_parameters(machine) if plant is None else plant,
        controller_settings.parameters(model, control),
        valve_driver_parameters.parameters(model, drive),
        start,
        sensor_suite.sensor_suite(machine) if suite is None else suite,
        fast=fast,
        substeps=substeps,
    )
    return Interpreted(loop, machine.manipulator.links, rows)


def draws(suite: Suite, rows: int) -> Floats:
    """Return the noise of a run [rows, channels]: what `sensor_suite.draw` would draw row by row."""
    if not any(channel.noise for channel in suite.channels):
        return np.zeros((rows, CHANNEL_COUNT))
    return _drawn(suite.seed, rows)


@lru_cache(maxsize=32)
def _drawn(seed: int, rows: int) -> Floats:
    """Return a seed's draws, which runs that differ in all else share: a megabyte for 20 s, read-only."""
    generator, drawn = noise_generator(Suite((), seed=seed)), np.empty((rows, len(DRAWN)))
    unused = np.empty(len(DRAWN))
    for row in drawn:
        generator.standard_normal(out=row)
        generator.random(out=unused)
    normals = np.take(drawn, DRAW_OF, axis=1)
    normals.flags.writeable = False
    return normals
