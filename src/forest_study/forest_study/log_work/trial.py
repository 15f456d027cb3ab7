"""The task done once: an operator at the levers of a crane, leg by leg.

A leg ends where the operator sees the grip near its end: on the way within `BLEND`, at a log within `near`,
with the crane and what hangs still enough. Then the operator takes `reaction`, and the grapple its time.
"""

import math

import numpy as np

from forest_control.operator.levers import REST, Levers
from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3
from forest_sim.simulation.load_schedule import Load
from forest_study.log_work import taught
from forest_study.log_work.crane import Crane, Seen, grip_of
from forest_study.log_work.manual_control import ManualControl
from forest_study.log_work.person import Person
from forest_study.log_work.site import Site, site_of
from forest_study.log_work.task import ACROSS, GRASP, HOLD, RELEASE, UP, Leg, legs, start
from forest_study.log_work.work import LONGEST, LOOK_TIME, SLOW, Work
from forest_study.results import StudyError

BLEND = 0.5  # [m] from a leg's end at which the next begins, on a crane that reaches 8 m; assumed


def work(machine: Machine, mode: str, person: Person, trip: float, seed: int) -> Work:
    """Return a trial.

    Args:
        machine: what is simulated, and what the controller believes.
        mode: of `crane.MODES`.
        person: the operator.
        trip: of the joystick's link, there and back [s].
        seed: of the operator's chances and the sensors' noise.

    Raises:
        StudyError: the task is not done in `LONGEST`, or the machine does not reach it.
    """
    if mode == "taught":
        return taught.work(machine, person, trip, seed)
    site = site_of(machine)
    x, y, z = start(site)
    crane = Crane(machine, mode, (x, y, z + site.hang), LONGEST, trip, seed)
    error = person.joint_error if mode == "joint" else person.tip_error
    shift = _Shift(crane, site, person, ManualControl(person, error, trip, LOOK_TIME, seed), mode)
    for leg in legs(site):
        shift.go(leg)
        if leg.act:
            shift.act(leg)
    angles, head = crane.looks()
    return Work(
        machine=machine,
        site=site,
        angles=angles,
        head=head,
        tip=crane.tips(),
        levers=crane.said(),
        engine=crane.engine_work(),
        number=np.array(shift.numbers, dtype=np.float64),
        part=tuple(shift.parts),
        loaded=np.array(shift.loads, dtype=np.float64),
    )


class _Shift:
    """An operator at work between two looks."""

    def __init__(self, crane: Crane, site: Site, person: Person, manual: ManualControl, mode: str) -> None:
        self._crane, self._site, self._person, self._manual = crane, site, person, manual
        self._joint, self._carries, self._speed = mode == "joint", False, 0.0
        default = crane.settings
        self._speeds = np.array(default.joint_rates if self._joint else default.axis_speed)
        self.numbers, self.parts, self.loads = list[int](), list[str](), list[bool]()
        self._limits = np.array(joint_limits(crane.machine)).T
        self._seen = self._look(legs(site)[0], HOLD, REST)
        self._grip = grip_of(self._seen, site.hang)

    def go(self, leg: Leg) -> None:
        """Steer to a leg's end."""
        self._manual.new_leg()
        while not self._arrived(leg):
            levers = self._manual.steer(self._left(leg.goal), self._speeds, self._crane.time)
            before = self._grip
            self._seen = self._look(leg, leg.part, levers)
            self._grip = grip_of(self._seen, self._site.hang)
            self._speed = math.dist(before, self._grip) / LOOK_TIME

    def act(self, leg: Leg) -> None:
        """Close or open the grapple at a leg's end."""
        self._wait(leg, self._person.reaction + (GRASP if leg.act == "grasp" else RELEASE))
        self._carries = leg.act == "grasp"
        self._crane.hold(Load(self._site.log_mass if self._carries else 0.0, self._site.log_length))
        self._wait(leg, self._person.reaction)
        self._grip = grip_of(self._seen, self._site.hang)

    def _wait(self, leg: Leg, seconds: float) -> None:
        for _ in range(round(seconds / LOOK_TIME)):
            self._seen = self._look(leg, HOLD, self._manual.rest())

    def _look(self, leg: Leg, part: str, levers: Levers) -> Seen:
        where = f"it ended in carry {leg.number}, {part}"
        if self._crane.stopped:
            raise StudyError(f"logs: the controller's guard stopped the crane: {where}")
        if self._crane.over:
            raise StudyError(f"logs: the task is not done in {LONGEST:g} s: {where}")
        self.numbers.append(leg.number)
        self.parts.append(part)
        self.loads.append(self._carries)
        return self._crane.look(levers)

    def _arrived(self, leg: Leg) -> bool:
        """Tell whether the operator sees a leg's end reached."""
        away = [goal - at for goal, at in zip(leg.goal, self._grip, strict=True)]
        blend = BLEND * self._site.scale
        if leg.part == UP:
            return away[2] < 0.5 * blend
        if leg.part == ACROSS:
            return math.hypot(away[0], away[1]) < blend
        return math.hypot(*away) < self._site.near and self._speed < SLOW

    def _left(self, goal: Vec3) -> Floats:
        """Return what is seen to be left to a goal of the grip [m], in the levers' coordinates."""
        x, y, z = goal
        tip = x, y, z + self._site.hang
        at = self._seen
        if self._joint:
            pose = np.clip(inverse_kinematics(tip, self._crane.machine.manipulator.links), *self._limits)
            found: Floats = pose - np.array(at.angles)
            return found
        here = math.hypot(at.tip[0], at.tip[1])
        turn = math.remainder(math.atan2(y, x) - at.angles[0], math.tau)
        return np.array([here * turn, tip[2] - at.tip[2], math.hypot(x, y) - here])
