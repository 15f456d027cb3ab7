"""`forest-study placing`: how long reaching and placing take behind a late link, by a simulated operator.

The operator moves and waits (Sheridan and Ferrell 1963; Ferrell 1965):

- it sees the tip half a round trip late, and the levers act as late;
- it knows how fast the tip goes at full deflection, slowed by the link or not;
- once it sees the tip at rest it takes `REACTION` (simple visual reactions take 0.2 to 0.25 s; Welford 1980)
  and moves to where the target is seen;
- a movement misses: its length by a standard deviation of 5 %, its direction by 3 % (Schmidt et al. 1979;
  Meyer et al. 1988); a lever goes over in `HAND`, and no movement is quicker than `QUICKEST`;
- it is done once it sees the tip at rest within `NEAR`.

Targets are 0.3 to 2 m away. Equal seeds give equal targets and equal misses, at every round trip.
"""

import argparse
import math
from collections import deque
from typing import Any, NamedTuple

import numpy as np

from forest_control.config import controller_settings
from forest_control.operator.late_link import UNFELT
from forest_control.operator.levers import REST, levers_for_tip_velocity
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at, start_tip
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine, load_machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.runtime.command_line import add_machine_option, whole
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_study.closed_loop.closed_loop import ClosedLoop, Links, Operator
from forest_study.closed_loop.link_model import Quality
from forest_study.results import StudyError, new_directory, write_json
from forest_study.tracking.tracking import noisy

TRIPS = (0.0, 0.15, 0.2, 0.3, 0.4, 0.6)  # [s] round trips
REACTION = 0.25  # [s]
LENGTH_SPREAD, SIDE_SPREAD = 0.05, 0.03  # [1] of a movement's length
HAND = 0.15  # [s] in which a lever goes over
QUICKEST = 0.6  # [s]
NEAR, STILL = 0.03, 0.02  # [m], [m/s] of the tip as it is seen
LOOK = 0.1  # [s] over which a speed is seen
SPEED = 0.5  # [m/s] at full deflection
DISTANCES = (0.3, 2.0)  # [m]
LONGEST = 60.0  # [s] for a target


class Placed(NamedTuple):
    """One target."""

    time: float  # [s] until the tip is there, and seen to be
    movements: int
    beyond: float  # [m] that the tip went beyond the target, at most
    miss: float  # [m] left at the end


class Person:
    """An operator who moves and waits.

    Args:
        target: [m].
        trip: round trip [s].
        seed: of the misses.
    """

    def __init__(self, target: Floats, trip: float, seed: int) -> None:
        self._target, self._rng = target, np.random.default_rng([seed, 5])
        self._under_way: deque[Floats] = deque(maxlen=1 + round(0.5 * trip / PERIOD))
        self._seen: deque[Floats] = deque(maxlen=1 + round(LOOK / PERIOD))
        self._speed = SPEED * min(1.0, UNFELT / max(UNFELT, trip))  # [m/s]
        self._trip, self._begun, self._length, self._velocity = trip, -math.inf, 0.0, np.zeros(3)
        self._rested = 0.0  # [s] since which it sees the tip at rest
        self.movements, self.done = 0, False

    def watch(self, tip: Floats) -> None:
        """See where the tip was half a round trip ago [m]."""
        self._under_way.append(tip)
        self._seen.append(self._under_way[0])

    def act(self, time: float) -> Operator:
        """Return what the hands do at a time [s]."""
        if time < self._begun + self._length:
            share = min(1.0, (time - self._begun) / HAND, (self._begun + self._length - time) / HAND)
            x, y, z = (share * self._velocity).tolist()
            return Operator(levers_for_tip_velocity((x, y, z), self._speed))
        way = self._seen[-1] - self._seen[0]
        came = time >= self._begun + self._length + self._trip  # what it did is to be seen by now
        if not came or np.linalg.norm(way) > STILL * LOOK:
            self._rested = 0.0
            return Operator(REST)
        self._rested += PERIOD
        left = self._target - self._seen[-1]
        self.done = float(np.linalg.norm(left)) < NEAR
        if self._rested >= REACTION and not self.done:
            self._set_out(left, time)
        return Operator(REST)

    def _set_out(self, left: Floats, time: float) -> None:
        """Begin a movement over what is left [m], or nearly."""
        distance = float(np.linalg.norm(left))
        meant = left * (1.0 + LENGTH_SPREAD * self._rng.normal())
        meant = meant + SIDE_SPREAD * distance * self._rng.normal(size=3)
        size = float(np.linalg.norm(meant))
        self._length = max(QUICKEST, size / self._speed + HAND)
        self._velocity = meant / (self._length - HAND)
        self._begun, self._rested, self.movements = time, 0.0, self.movements + 1


def placed(machine: Machine, trip: float, seed: int) -> Placed:
    """Return how a seed's target is reached behind a round trip [s].

    Raises:
        StudyError: it is not reached.
    """
    begin = np.array(start_tip(machine))
    person = Person(_target(machine, seed), trip, seed)
    suite, links = noisy(machine, seed), machine.manipulator.links
    control = controller_settings.parameters(machine, controller_settings.Settings(tip_speed=SPEED))
    drive = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings())
    ways, start = Links(joystick=Quality(0.5 * trip)), pose_at(start_tip(machine), machine)
    loop = ClosedLoop(plant_parameters(machine), control, drive, start, suite, ways, fast=True)
    along = _target(machine, seed) - begin
    distance, beyond, tip = float(np.linalg.norm(along)), 0.0, begin
    for k in range(round(LONGEST / PERIOD)):
        person.watch(tip)
        happened = loop.period(person.act(k * PERIOD))
        tip = np.array(tip_position(happened.angles, links))
        beyond = max(beyond, float((tip - begin) @ along) / distance - distance)
        if person.done:
            miss = float(np.linalg.norm(tip - begin - along))
            return Placed(k * PERIOD, person.movements, beyond, miss)
    raise StudyError(f"placing: target {seed} is not reached within {LONGEST:g} s")


def _target(machine: Machine, seed: int) -> Floats:
    """Return a seed's target [m], which is within reach all the way."""
    rng, begin = np.random.default_rng([seed, 6]), np.array(start_tip(machine))
    while True:
        way = rng.normal(size=3)
        way *= rng.uniform(*DISTANCES) / np.linalg.norm(way)
        if all(_reached(begin + share * way, machine) for share in (0.25, 0.5, 0.75, 1.1)):
            target: Floats = begin + way
            return target


def _reached(place: Floats, machine: Machine) -> bool:
    """Tell whether the tip can be at a place [m]."""
    x, y, z = place.tolist()
    tip: Vec3 = (x, y, z)
    try:
        pose_at(tip, machine)
    except ValueError:
        return False
    return True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parser.add_argument
    add_machine_option(parser)
    add(
        "--targets", type=whole(1, 1000), default=20, metavar="N", help="drawn targets (default: %(default)s)"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        MachineError: the machine's file cannot be read.
        StudyError: a target is not reached.
    """
    machine = load_machine(options.machine)
    new_directory(options.out)
    found = {trip: [placed(machine, trip, seed) for seed in range(options.targets)] for trip in TRIPS}
    rows = [_row(trip, found[trip], found[TRIPS[0]]) for trip in TRIPS]
    report: dict[str, Any] = {"machine": machine.name, "targets": options.targets, "round_trips": rows}
    write_json(options.out / "placing.json", report)
    print(table(rows))
    print(f"  {options.out / 'placing.json'}")
    return 0


def _row(trip: float, found: list[Placed], prompt: list[Placed]) -> dict[str, float]:
    """Return a round trip's figures; lost: more time than without delay."""
    times = [one.time for one in found]
    return {
        "round_trip_s": trip,
        "time_s": float(np.mean(times)),
        "lost": sum(times) / sum(one.time for one in prompt) - 1.0,
        "movements": float(np.mean([one.movements for one in found])),
        "beyond_mm": 1e3 * max(one.beyond for one in found),
    }


def table(rows: list[dict[str, float]]) -> str:
    """Return a Markdown table: one row per round trip."""
    lines = [
        "| round trip, ms | time, s | lost | movements | beyond the target, mm |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {1e3 * row['round_trip_s']:.0f} | {row['time_s']:.2f} | {100.0 * row['lost']:.0f} % "
        f"| {row['movements']:.1f} | {row['beyond_mm']:.0f} |"
        for row in rows
    ]
    return "\n".join(lines)
