"""Stops and precision of the crane over a simulated day, in one closed loop that is never started anew.

    python benchmarks/simulated_day.py [--hours 24] [--machine c180] [--seed 1]
                                       [--anti-sway] [--tip-acceleration M/S2]

A person presses the deadman, goes towards joint angles that are drawn, lets go on the way, and so on, every
8 s. The table has an hour a row: what drifts or overflows with time would differ between the first and the
last. A stop that is missed, and a crane that mostly stood, end with exit code 1.
"""

import argparse
import math
import sys
from typing import NamedTuple

import numpy as np

from forest_control.config import controller_settings
from forest_control.operator.levers import levers_for_tip_velocity
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine, load_machine
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.tracking.tracking import noisy

TURN, REST = 8.0, 0.5  # [s]; at its beginning the levers are centred
GOES = (1.0, 5.0)  # [s] until the deadman is let go
AHEAD = 0.01  # of the way to the joint angles that are drawn: the tip sets out in that direction
STOPPED = 0.25  # [s] from then on to shut valves
SPEED = 0.5  # [m/s]
CLEAR = math.radians(2.0)  # of the limits, where angles are drawn
MOVED, DRIVEN = 0.1, 0.9  # [m] in a turn that count as driven; of all turns, at least
HOUR = 3600.0  # [s]


class Turn(NamedTuple):
    """What became of a turn."""

    stop: float  # [s] from the release until the valves are shut
    way: float  # [m] of the tip
    error: float  # [m] RMS of the tip off its reference until the release, from where it was at the beginning


def main() -> int:
    """Run; return 1 if a stop is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--machine", default="c180")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--anti-sway", action="store_true")
    parser.add_argument("--tip-acceleration", type=float, default=-1.0)
    options = parser.parse_args()
    control = controller_settings.Settings(
        tip_speed=SPEED, anti_sway=options.anti_sway, tip_acceleration=options.tip_acceleration
    )
    machine, count = load_machine(options.machine), round(options.hours * HOUR / TURN)
    moved, marks = day(machine, count, options.seed, control)
    return report([judged(moved, *mark) for mark in marks])


def day(
    machine: Machine, count: int, seed: int, control: controller_settings.Settings
) -> tuple[Trajectory, list[tuple[int, int, int]]]:
    """Drive so many turns; return what happened, and of each turn the rows of beginning, release and end."""
    chance, rows = np.random.default_rng(seed), round(TURN / PERIOD)
    low, high = np.array(joint_limits(machine)).T
    start = tuple((0.5 * (low + high)).tolist())
    prepared = compiled_loop.prepared(
        machine,
        np.zeros((count * rows, 4)),
        start,
        control,
        valve_driver_parameters.Settings(),
        suite=noisy(machine, seed),
    )
    session, links = compiled_loop.Session(prepared), machine.manipulator.links
    marks = []
    for begun in range(0, count * rows, rows):
        angles = np.array(session.newest.angles if begun else start)
        away = chance.uniform(low + CLEAR, high - CLEAR) - angles
        tip, ahead = (np.array(tip_position((angles + n * away).tolist(), links)) for n in (0.0, AHEAD))
        wish = SPEED * (ahead - tip) / np.linalg.norm(ahead - tip)
        goes = begun + round(REST / PERIOD)
        released = goes + round(chance.uniform(*GOES) / PERIOD)
        session.levers[goes : begun + rows, :3] = levers_for_tip_velocity(tuple(wish.tolist()), SPEED)
        session.levers[begun:released, 3] = 1.0
        session.advance(begun + rows)
        marks.append((goes, released, begun + rows))
    return session.moved, marks


def judged(moved: Trajectory, goes: int, released: int, end: int) -> Turn:
    """Return what became of a turn."""
    tip, wish = moved.tip[goes:released], moved.tip_wish[goes:released]
    error = np.linalg.norm(tip - tip[0] - PERIOD * (np.cumsum(wish, axis=0) - wish), axis=1)
    open_rows = np.flatnonzero(np.any(moved.voltages[released:end] != 0.0, axis=1))
    stop = PERIOD * (open_rows[-1] + 1) if len(open_rows) else 0.0
    return Turn(stop, float(np.linalg.norm(tip[-1] - tip[0])), math.sqrt(np.mean(error**2)))


def report(turns: list[Turn]) -> int:
    """Print an hour a row; return the exit code."""
    print("| hour | turns | driven | RMS off the reference, mm: median | worst | stop, s: median | worst |")
    print("|---|---|---|---|---|---|---|")
    an_hour = round(HOUR / TURN)
    for number, first in enumerate(range(0, len(turns), an_hour), 1):
        part = turns[first : first + an_hour]
        errors = [1e3 * one.error for one in part]
        stops = [one.stop for one in part]
        driven = sum(one.way > MOVED for one in part)
        print(
            f"| {number} | {len(part)} | {driven} | {np.median(errors):.1f} | {max(errors):.0f} "
            f"| {np.median(stops):.3f} | {max(stops):.3f} |"
        )
    missed = sum(not one.stop <= STOPPED for one in turns)
    driven = sum(one.way > MOVED for one in turns)
    print(f"{len(turns)} turns, {driven} driven, {missed} stops took longer than {STOPPED} s")
    return int(missed > 0 or driven < DRIVEN * len(turns))


if __name__ == "__main__":
    sys.exit(main())
