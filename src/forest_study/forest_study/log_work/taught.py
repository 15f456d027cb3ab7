"""The task as a taught cycle: the real player leads the tip from log to log, the person confirms the grapple.

The paths are those of the task, with round corners, at a speed at which the tip stays with the player. At a
log the person waits until the grip is near and still, as in the other modes, and has the player go on.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

from forest_control.config import controller_settings
from forest_control.operator.levers import REST
from forest_control.taught.cycle import Cycle, Grapple, Segment
from forest_control.taught.cycle import Path as TaughtPath
from forest_control.taught.cycle_file import save_cycle
from forest_control.taught.player import Phase
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.load_schedule import Load, loaded
from forest_study.closed_loop.closed_loop import Operator
from forest_study.log_work.crane import LOOK, Piece, Seen, engine_work, grip_of, settings_of
from forest_study.log_work.person import Person
from forest_study.log_work.site import Site, site_of
from forest_study.log_work.task import ACROSS, DOWN, GRASP, HOLD, RELEASE, UP, Leg, legs
from forest_study.log_work.work import LONGEST, LOOK_TIME, SLOW, Work
from forest_study.results import StudyError
from forest_study.tracking.taught_loop import TaughtLoop
from forest_study.tracking.tracking import noisy

NAME = "logs"
SPEED = 0.6  # [m/s]: at 1.0 the tip of `forwarder` leaves the tube of 90 mm that the player keeps
CORNER = 0.6  # [m] radius of a corner, on a crane that reaches 8 m; chosen
APART = 12.0  # [deg] between two points of a corner: the player stops at 25
ALONG = 0.5  # [m] between two points of an arc about the crane


def cycle_of(site: Site) -> Cycle:
    """Return the task as a cycle of the tip: its first act is done where the tip is."""
    segments: list[Segment] = [Grapple("grapple 1", "close")]
    ways = legs(site)[1:]
    here = legs(site)[0].goal
    for k in range(0, len(ways), 3):
        up, across, down = ways[k : k + 3]
        number = k // 3 + 1
        path = [(x, y, z + site.hang) for x, y, z in _rounded(here, up.goal, across.goal, down.goal, site)]
        segments.append(TaughtPath(f"way {number}", tuple(path), SPEED))
        segments.append(Grapple(f"grapple {number + 1}", "open" if down.act == "release" else "close"))
        here = down.goal
    return Cycle(NAME, tuple(segments), "Logs from the ground to the bunk and back")


def _rounded(here: Vec3, up: Vec3, across: Vec3, down: Vec3, site: Site) -> list[Vec3]:
    """Return the points of a way: up, along an arc about the crane, down."""
    turn = math.remainder(math.atan2(across[1], across[0]) - math.atan2(up[1], up[0]), math.tau)
    r, s = math.hypot(up[0], up[1]), math.hypot(across[0], across[1])
    arc = math.hypot(0.5 * (r + s) * turn, s - r)
    radius = min(CORNER * site.scale, 0.5 * arc, 0.9 * (up[2] - max(here[2], down[2])))
    begin, share = math.atan2(up[1], up[0]), radius / arc

    def at(t: float, z: float) -> Vec3:
        away, angle = r + t * (s - r), begin + t * turn
        return away * math.cos(angle), away * math.sin(angle), z

    corner = np.radians(np.linspace(0.0, 90.0, 1 + math.ceil(90.0 / APART)))[1:]
    rise = [at(share * (1.0 - math.cos(a)), up[2] - radius + radius * math.sin(a)) for a in corner]
    count = max(1, math.ceil((arc - 2.0 * radius) / (ALONG * site.scale)))
    level = [at(share + (1.0 - 2.0 * share) * k / count, up[2]) for k in range(1, count)]
    fall = [at(1.0 - share * (1.0 - math.sin(a)), up[2] - radius + radius * math.cos(a)) for a in corner]
    begun = [at(1.0 - share, up[2])] if arc > 2.1 * radius else []
    return [here, at(0.0, up[2] - radius), *rise, *level, *begun, *fall, down]


def work(machine: Machine, person: Person, trip: float, seed: int) -> Work:
    """Return a trial; arguments and errors as `trial.work`. A trip delays only what is confirmed.

    Raises:
        StudyError: the cycle does not end in `LONGEST`.
    """
    site = site_of(machine)
    with tempfile.TemporaryDirectory() as folder:
        save_cycle(cycle_of(site), Path(folder))
        return _Played(machine, site, person, Path(folder), trip, seed).work()


class _Played:
    """The machine, its player, and a person who confirms."""

    def __init__(
        self, machine: Machine, site: Site, person: Person, folder: Path, trip: float, seed: int
    ) -> None:
        self._machine, self._site, self._person, self._trip = machine, site, person, trip
        settings, first = settings_of(machine, "taught"), legs(site)[0].goal
        tip = first[0], first[1], first[2] + site.hang
        self._loop = TaughtLoop(machine, tip, folder, settings, noisy(machine, seed))
        self._loop.work.p = controller_settings.parameters(machine, settings)
        self._loop.work.cycle = NAME
        self._plant = plant_parameters(machine)
        self._pieces = [Piece(0, self._loop.loop.simulation, self._plant)]
        self._volts, self._seen = list[Vec3](), list[Seen]()
        self._rows: list[tuple[int, str, bool]] = []
        self._carries = False

    def work(self) -> Work:
        """Play the cycle."""
        acts = [leg for leg in legs(self._site) if leg.act]
        self._look(acts[0], HOLD)
        said = self._loop.work.play()
        for k, leg in enumerate(acts):
            while self._loop.phase != Phase.HOLDING:
                self._look(leg, self._part(leg))
                if self._loop.phase in (Phase.IDLE, Phase.PAUSED):
                    raise StudyError(f"logs: the taught cycle stopped: {[said, *self._loop.events][-1]}")
            self._act(leg)
            if k + 1 < len(acts):
                self._look(leg, HOLD, pressed=True)
        return self._told()

    def _act(self, leg: Leg) -> None:
        """Wait until the grip is near and still, then close or open the grapple."""
        before = grip_of(self._seen[-1], self._site.hang)
        while True:
            self._look(leg, HOLD)
            grip = grip_of(self._seen[-1], self._site.hang)
            if math.dist(grip, leg.goal) < self._site.near and math.dist(grip, before) < SLOW * LOOK_TIME:
                break
            before = grip
        self._wait(leg, self._person.reaction + (GRASP if leg.act == "grasp" else RELEASE))
        self._carries = leg.act == "grasp"
        load = Load(self._site.log_mass if self._carries else 0.0, self._site.log_length)
        self._plant = loaded(plant_parameters(self._machine), self._machine.manipulator, load)
        self._loop.loop.change_load(self._plant)
        self._pieces.append(Piece(len(self._volts), self._loop.loop.simulation, self._plant))
        self._wait(leg, self._person.reaction + self._trip)

    def _wait(self, leg: Leg, seconds: float) -> None:
        for _ in range(round(seconds / LOOK_TIME)):
            self._look(leg, HOLD)

    def _look(self, leg: Leg, part: str, pressed: bool = False) -> None:
        if len(self._rows) * LOOK_TIME > LONGEST:
            raise StudyError(
                f"logs: the task is not done in {LONGEST:g} s: it ended in carry {leg.number}, {part}"
            )
        for k in range(LOOK):
            happened = self._loop.period(Operator(REST), pressed=pressed and k == 0)
            self._volts.append(happened.voltages)
        head = self._loop.loop.simulation.plant.head
        self._seen.append(Seen(happened.angles, self._loop.tips[-1], (head.alpha, head.beta)))
        self._rows.append((leg.number, part, self._carries))

    def _part(self, leg: Leg) -> str:
        """Return the part of a way that the tip is in."""
        z, top = self._seen[-1].tip[2] - self._site.hang, self._site.clear - CORNER * self._site.scale
        if z > top:
            return ACROSS
        moved = [part for number, part, _ in self._rows if number == leg.number]
        return DOWN if ACROSS in moved else UP

    def _told(self) -> Work:
        looks = len(self._rows)
        numbers, parts, loads = zip(*self._rows, strict=True)
        return Work(
            machine=self._machine,
            site=self._site,
            angles=np.array([one.angles for one in self._seen]),
            head=np.array([one.head for one in self._seen]),
            tip=np.array([one.tip for one in self._seen]),
            levers=np.zeros((looks, 3)),
            engine=engine_work(self._pieces, np.array(self._volts)),
            number=_floats(numbers),
            part=tuple(parts),
            loaded=_floats(loads),
        )


def _floats(values: "tuple[float, ...]") -> Floats:
    return np.array(values, dtype=np.float64)
