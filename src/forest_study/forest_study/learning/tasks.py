"""What is to be done, drawn by a generator: follow a path of the tip, or reach one target after the other.

Both are drawn where the arm is 0.55 to 0.8 of its length, within 35 deg of straight ahead, for any machine.
Distances are those of the true tip. A reward is told for every step of the environment:

| task | reward of a step |
|---|---|
| path | minus the distance [m] from the ideal point, which goes along the path by the clock |
| reach | the way [m] that the tip came nearer to its target, and 1 for a target that is reached |

A target is reached when the tip has been within `NEAR` of it for `HELD`; then the next one counts. What is
gained by coming nearer is lost by going away, so that only reached targets add up.
"""

import math
from typing import NamedTuple, Protocol

import numpy as np

from forest_control.taught.plan import RAMP
from forest_control.taught.tip_path import PathError, Profile, TipPath, bounded, polyline, timed
from forest_description.derived.limits import pose_at
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3

REACH = 0.55, 0.8  # of the arm's length, from the swing axis
AZIMUTH = math.radians(35.0)  # [rad] to each side
HEIGHT = -0.06, 0.2  # of the arm's length, over the boom's pivot
CORNERS = 4  # of a drawn path, ends included
SPEED = 0.4  # [m/s] of the ideal point
REST = 1.0  # [s] before it moves
AHEAD = 0.25, 0.5, 1.0  # [s] at which the ideal point's future is seen
STEP = 0.01  # [m] between the places of a profile
TRIED = 0.1  # [m] between the places that must be within reach
DRAWS = 1000  # of a path or a target, until the machine is said not to reach any
TARGETS = 40  # more than are reached in an episode
NEAR, HELD = 0.03, 0.3  # [m], [s]
FAR = 30.0  # [m] more than two places of any crane are apart
NAMES = ("path", "reach")


class Entry(NamedTuple):
    """A part of the observation."""

    name: str
    unit: str
    size: int
    greatest: float  # of each number's size


class Task(Protocol):
    """A drawn piece of work."""

    start: Vec3  # [m] where the tip is at rest beforehand

    def seen(self, time: float, tip: Vec3) -> list[float]:
        """Return what is seen of the task from a place of the tip [m] at a time [s]."""

    def judged(self, time: float, tip: Vec3) -> tuple[float, dict[str, float]]:
        """Return the reward of a step, and figures, for the true tip [m] at its end."""


class PathTask:
    """Follow a drawn path.

    Args:
        machine: that reaches all of it.
        chance: draws it.
    """

    entries = (
        Entry("from the tip to the ideal point", "m", 3, FAR),
        Entry("velocity of the ideal point", "m/s", 3, 1.0),
        *(Entry(f"from the tip to the ideal point in {ahead:g} s", "m", 3, FAR) for ahead in AHEAD),
    )

    def __init__(self, machine: Machine, chance: np.random.Generator) -> None:
        self.path, self.profile = _drawn_path(machine, chance)
        self.start = self.path.at(0.0)

    def ideal(self, time: float) -> Vec3:
        """Return where the ideal point is at a time [s]: [m]."""
        return self.path.at(self.profile.way_at(time - REST))

    def seen(self, time: float, tip: Vec3) -> list[float]:
        """Return as `Task.seen`."""
        here, there = self.ideal(time), self.ideal(time + STEP)
        velocity = [(b - a) / STEP for a, b in zip(here, there, strict=True)]
        later = [self.ideal(time + ahead) for ahead in AHEAD]
        return [*_way(tip, here), *velocity, *(x for place in later for x in _way(tip, place))]

    def judged(self, time: float, tip: Vec3) -> tuple[float, dict[str, float]]:
        """Return as `Task.judged`."""
        distance = math.dist(tip, self.ideal(time))
        return -distance, {"distance": distance}


class ReachTask:
    """Bring the tip to one drawn target after the other.

    Args:
        machine: that reaches all of them.
        chance: draws them.
    """

    entries = (Entry("from the tip to the target", "m", 3, FAR),)

    def __init__(self, machine: Machine, chance: np.random.Generator) -> None:
        self.start, *self.targets = (_drawn_place(machine, chance) for _ in range(TARGETS + 1))
        self.reached = 0
        self._since = math.inf  # [s] when the tip came to be near
        self._before = math.dist(self.start, self.targets[0])

    def seen(self, time: float, tip: Vec3) -> list[float]:  # noqa: ARG002  one signature for all
        """Return as `Task.seen`."""
        return list(_way(tip, self._target))

    def judged(self, time: float, tip: Vec3) -> tuple[float, dict[str, float]]:
        """Return as `Task.judged`."""
        distance = math.dist(tip, self._target)
        reward, self._before = self._before - distance, distance
        self._since = min(self._since, time) if distance <= NEAR else math.inf
        if time - self._since >= HELD:
            reward, self.reached, self._since = reward + 1.0, self.reached + 1, math.inf
            self._before = math.dist(tip, self._target)
        return reward, {"distance": distance, "reached": float(self.reached)}

    @property
    def _target(self) -> Vec3:
        return self.targets[min(self.reached, TARGETS - 1)]


def drawn(name: str, machine: Machine, chance: np.random.Generator) -> Task:
    """Return a task of `NAMES`.

    Raises:
        PathError: the machine reaches nothing that is drawn.
    """
    return PathTask(machine, chance) if name == "path" else ReachTask(machine, chance)


def _drawn_place(machine: Machine, chance: np.random.Generator) -> Vec3:
    """Return a place that the tip reaches [m]."""
    links = machine.manipulator.links
    arm = links.boom + links.stick
    for _ in range(DRAWS):
        radius, height = arm * chance.uniform(*REACH), arm * chance.uniform(*HEIGHT)
        azimuth = chance.uniform(-AZIMUTH, AZIMUTH)
        place = radius * math.cos(azimuth), radius * math.sin(azimuth), height
        if _reaches(machine, place):
            return place
    raise PathError(f"{machine.name}: none of {DRAWS} drawn places is within reach")


def _drawn_path(machine: Machine, chance: np.random.Generator) -> tuple[TipPath, Profile]:
    for _ in range(DRAWS):
        path = polyline("drawn", [_drawn_place(machine, chance) for _ in range(CORNERS)])
        ways: Floats = np.arange(0.0, path.length, TRIED)
        if all(_reaches(machine, path.at(s)) for s in ways.tolist()):
            return path, timed(*bounded(path, SPEED, lambda *_: SPEED, STEP), RAMP)
    raise PathError(f"{machine.name}: none of {DRAWS} drawn paths is within reach")


def _reaches(machine: Machine, place: Vec3) -> bool:
    try:
        pose_at(place, machine)
    except ValueError:
        return False
    return True


def _way(a: Vec3, b: Vec3) -> Vec3:
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]
