"""The machine at work in closed loop, compiled, moved a look of the operator at a time.

The link's round trip is halved: the crane is seen half of it late, and the levers act half of it late. The
joystick speaks once a look, as one of 50 Hz: between two words the controller interpolates.
"""

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from forest_compile import flat_layout
from forest_control.config import controller_settings
from forest_control.operator.levers import REST, Levers
from forest_control.operator.operator_profile import Frame
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.geometry.kinematics import Links
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.simulation.load_schedule import Load, loaded
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.state_recording import ENERGY, STATE
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.loop_core import SUBSTEPS
from forest_study.tracking.tracking import noisy

LOOK = 4  # [periods] between two looks: 20 ms, ten to an operator's delay
MODES = ("joint", "tip", "assisted", "taught")
FASTEST = 3.0  # [m/s] that a lever may ask for, the setting's bound
ARMED = "loop.control.permission.joystick.armed"


class Piece(NamedTuple):
    """A machine from a row on, until its load changes."""

    row: int
    simulation: Simulation
    plant: PlantParameters


class Seen(NamedTuple):
    """The crane at a look."""

    angles: Vec3  # [rad]
    tip: Vec3  # [m]
    head: tuple[float, float]  # angles of what hangs [rad]


def settings_of(machine: Machine, mode: str) -> controller_settings.Settings:
    """Return the controller's settings of a mode: in each, a full lever is what the joints give at mid-reach.

    Args:
        machine: whose joints and reach count.
        mode: one of `MODES`; assisted is tip control that lets nothing hanging sway.
    """
    default = controller_settings.Settings()
    if mode == "joint":
        return default._replace(scheme=Scheme.JOINT)
    links: Links = machine.manipulator.links
    reach = 0.7 * (links.base_offset + links.boom + links.stick)
    speeds = tuple(min(FASTEST, rate * reach) for rate in default.joint_rates)
    return default._replace(
        axis_frame=Frame.CYLINDRICAL,
        tip_speed=FASTEST,
        axis_speed=(speeds[0], speeds[1], speeds[2]),
        anti_sway=mode == "assisted",
    )


class Crane:
    """A machine at rest, and its controller in a mode.

    Args:
        machine: what is simulated, and what controller and driver believe.
        mode: one of `MODES`.
        tip: where it is at rest [m].
        seconds: that it runs at most.
        trip: the link's round trip [s].
        seed: of the sensors' noise.
    """

    def __init__(
        self, machine: Machine, mode: str, tip: Vec3, seconds: float, trip: float, seed: int
    ) -> None:
        self.machine, self.settings = machine, settings_of(machine, mode)
        rows = LOOK * round(seconds / (LOOK * PERIOD))
        held = np.tile(np.array([0.0, 0.0, 0.0, 1.0]), (rows, 1))
        drive = valve_driver_parameters.Settings()
        prepared = compiled_loop.prepared(
            machine, held, pose_at(tip, machine), self.settings, drive, suite=noisy(machine, seed)
        )
        self._session, self._plant = compiled_loop.Session(prepared, every=LOOK), plant_parameters(machine)
        first = self._session.loop.simulation
        self._pieces = [Piece(0, first, self._plant)]
        half = max(0, round(0.5 * trip / (LOOK * PERIOD)))
        self._said: deque[Levers] = deque([REST] * half, maxlen=half + 1)
        names = [path for path, _ in flat_layout.leaves(self._session.loop, "loop")]
        self._armed = names.index(ARMED)
        self._looks: list[Seen] = []
        self._shown: deque[Seen] = deque(maxlen=half + 1)

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self._session.row * PERIOD

    @property
    def stopped(self) -> bool:
        """Whether the controller's guard has taken the levers away."""
        return not self._session.state[self._armed]

    @property
    def over(self) -> bool:
        """Whether its time is up."""
        return self._session.row >= len(self._session.levers)

    def look(self, levers: Levers) -> Seen:
        """Move the machine over a look's time; return what the operator sees at its end."""
        self._said.append(levers)
        row, session = self._session.row, self._session
        session.levers[row : row + LOOK, :3] = self._said[0]
        session.advance(row + LOOK)
        last = session.newest
        seen = Seen(last.angles, last.tip, session.head)
        self._looks.append(seen)
        self._shown.append(seen)
        return self._shown[0]

    def hold(self, load: Load) -> None:
        """Grasp a log, or drop it: a load of no mass."""
        self._plant = loaded(plant_parameters(self.machine), self.machine.manipulator, load)
        self._session.change_load(self._plant)
        self._pieces.append(Piece(self._session.row, self._session.loop.simulation, self._plant))

    def looks(self) -> tuple[Floats, Floats]:
        """Return joint angles and those of what hangs at each look, [N, 3] and [N, 2] rad."""
        return np.array([one.angles for one in self._looks]), np.array([one.head for one in self._looks])

    def said(self) -> Floats:
        """Return the levers as they acted, a row a look [N, 3]."""
        return self._session.levers[: self._session.row : LOOK, :3]

    def tips(self) -> Floats:
        """Return where the tip was, a row a look [N, 3] m."""
        return self._session.moved.tip[LOOK - 1 :: LOOK]

    def engine_work(self) -> Floats:
        """Return the engine's work over each look [N] J."""
        return engine_work(self._pieces, self._session.moved.voltages)


def grip_of(seen: Seen, hang: float) -> Vec3:
    """Return where the grip is seen [m], so far below the tip [m]."""
    swing, (a, b) = seen.angles[0], seen.head
    c, s = math.cos(swing), math.sin(swing)
    x, y, z = math.sin(a) * math.cos(b), math.sin(b), -math.cos(a) * math.cos(b)
    return (
        seen.tip[0] + hang * (x * c - y * s),
        seen.tip[1] + hang * (x * s + y * c),
        seen.tip[2] + hang * z,
    )


def engine_work(pieces: Sequence[Piece], voltages: Floats) -> Floats:
    """Return the engine's work over each look [N] J: the plant's own account, by the same voltages.

    Args:
        pieces: the machine from its beginning on, and from each change of its load.
        voltages: at the valves, a row a period [V].
    """
    record, work = compiled_record(), []
    ends = [piece.row for piece in pieces[1:]] + [len(voltages)]
    for piece, end in zip(pieces, ends, strict=True):
        if end > piece.row:
            volts = np.repeat(voltages[piece.row : end], SUBSTEPS, axis=0)
            states, energies = (np.zeros((end - piece.row, len(of))) for of in (STATE, ENERGY))
            record(piece.simulation, volts, PERIOD / SUBSTEPS, piece.plant, states, energies)
            work.append(energies[:, ENERGY.index("pump_engine")])
    total: Floats = np.concatenate(work).reshape(-1, LOOK).sum(axis=1)
    return total
