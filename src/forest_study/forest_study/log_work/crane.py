"""The machine at work in closed loop, compiled, moved a look of the operator at a time.

The link's round trip is halved: the crane is seen half of it late, and the levers act half of it late. The
joystick speaks in every period, so that the guard does not take the delay for silence.
"""

from collections import deque
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
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.load import Load, loaded
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.state_recording import ENERGY, STATE
from forest_study.closed_loop import loop_kernel
from forest_study.closed_loop.loop_core import SUBSTEPS
from forest_study.tracking.tracking import noisy

LOOK = 4  # [periods] between two looks: 20 ms, ten to an operator's delay
MODES = ("joint", "tip", "assisted")
FASTEST = 3.0  # [m/s] that a lever may ask for, the setting's bound
HEAD = tuple(f"loop.simulation.plant.head.{name}" for name in ("alpha", "beta"))


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
        prepared = loop_kernel.prepared(
            machine, held, pose_at(tip, machine), self.settings, drive, suite=noisy(machine, seed)
        )
        self._session, self._plant = loop_kernel.Session(prepared), plant_parameters(machine)
        first = self._session.loop.simulation
        self._pieces = [(0, first, self._plant)]  # row, machine and parameters from there on
        half = max(0, round(0.5 * trip / (LOOK * PERIOD)))
        self._said: deque[Levers] = deque([REST] * half, maxlen=half + 1)
        names = [path for path, _ in flat_layout.leaves(self._session.loop, "loop")]
        self._head = [names.index(name) for name in HEAD]
        self._looks: list[Seen] = []
        self._shown: deque[Seen] = deque(maxlen=half + 1)

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self._session.row * PERIOD

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
        last = session.recorded[row + LOOK - 1, :6].tolist()
        alpha, beta = session.state[self._head].tolist()
        seen = Seen((last[0], last[1], last[2]), (last[3], last[4], last[5]), (alpha, beta))
        self._looks.append(seen)
        self._shown.append(seen)
        return self._shown[0]

    def hold(self, load: Load) -> None:
        """Grasp a log, or drop it: a load of no mass."""
        self._plant = loaded(plant_parameters(self.machine), self.machine.manipulator, load)
        self._session.change_load(self._plant)
        self._pieces.append((self._session.row, self._session.loop.simulation, self._plant))

    def looks(self) -> tuple[Floats, Floats]:
        """Return joint angles and those of what hangs at each look, [N, 3] and [N, 2] rad."""
        return np.array([one.angles for one in self._looks]), np.array([one.head for one in self._looks])

    def said(self) -> Floats:
        """Return the levers as they acted, a row a look [N, 3]."""
        return self._session.levers[: self._session.row : LOOK, :3]

    def tips(self) -> Floats:
        """Return where the tip was, a row a look [N, 3] m."""
        return self._session.recorded[LOOK - 1 : self._session.row : LOOK, 3:6]

    def engine_work(self) -> Floats:
        """Return the engine's work over each look [N] J: the plant's own account, by the same voltages."""
        record, work = compiled_record(), []
        ends = [row for row, _, _ in self._pieces[1:]] + [self._session.row]
        for (begin, simulation, plant), end in zip(self._pieces, ends, strict=True):
            if end > begin:
                volts = np.repeat(self._session.recorded[begin:end, 12:15], SUBSTEPS, axis=0)
                states, energies = np.zeros((end - begin, len(STATE))), np.zeros((end - begin, len(ENERGY)))
                record(simulation, volts, PERIOD / SUBSTEPS, plant, states, energies)
                work.append(energies[:, ENERGY.index("pump_engine")])
        total: Floats = np.concatenate(work).reshape(-1, LOOK).sum(axis=1)
        return total
