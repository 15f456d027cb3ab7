"""Every seed's plant, sensors and joystick in every row of the matrix, over all cores.

A seed's figures are the worst of its paths, each by its last lap: one lap is the first pass of a driver that
has learnt nothing. Equal seeds give equal figures, whatever else is run.
"""

import dataclasses
import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from forest_control.limits.load_moment import allowed_load, capacity
from forest_control.taught.tip_path import PathError, TipPath
from forest_description.machine import Machine
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters
from forest_study.closed_loop import loop_kernel, model_mismatch
from forest_study.closed_loop.path_guide import Hand
from forest_study.matrix.figures import Figures
from forest_study.matrix.load_change import grasped_and_dropped
from forest_study.matrix.matrix_rows import MatrixRow
from forest_study.matrix.rivals import OURS, Rival
from forest_study.tracking.tracking import Course, Session, follow, noisy, prepare

JOYSTICKS = (1, 2, 4, 10)  # [periods] between two words: 200, 100, 50, 20 Hz
STEPS = 127.0  # of 8 bits, on each side
RATES = (200.0, 50.0)  # [Hz] of the sensors
LATENCY = 2.5  # [1] of the joystick's periods: two of the interpolation, half of the mean wait
BOUND_DELAY, BOUND = 0.05, 0.015  # [s], [m] of the wish error beside joystick and dead time
ENDING = 40  # rows before a profile's end, from which the tip may be beyond it
PLACES = 100  # of a path at which its reach is looked at: closer than 3 cm on the longest
WAITED = 0.1  # [s] by which a run takes longer than its profile, and a limit has acted


class Outcome(NamedTuple):
    """A seed in a row."""

    seed: int
    drawn: dict[str, Any]
    overloaded: bool  # its head is heavier than the machine's file allows somewhere on the paths
    figures: Figures | None  # None: a run did not end
    paths: dict[str, Figures | None]


class _Plant(NamedTuple):
    """What a seed has of its own."""

    sensed: Machine  # for its sensors' rate
    parameters: PlantParameters
    every: int
    steps: float
    dead_time: float  # [s]
    head: float  # [kg]
    crane: Manipulator
    told: dict[str, Any]


def run_row(
    row: MatrixRow,
    machine: Machine,
    seeds: Sequence[int],
    adapt: bool = True,
    laps: int = 1,
    rival: Rival = OURS,
) -> list[Outcome]:
    """Return every seed's outcome.

    Args:
        row: of the matrix.
        machine: what controller and driver believe, and what is drawn from.
        seeds: one or more.
        adapt: the driver learns its valves.
        laps: of each path; the last is judged.
        rival: the control law.

    Raises:
        PathError: a path leaves the machine's reach.
        MachineError: the machine lacks what is drawn.
    """
    loop_kernel.KERNEL.kernel()  # made or loaded once, here
    courses = {
        speed: [_course(path, speed, machine, laps, rival) for path in row.paths] for speed in row.speeds
    }
    most = lifted(row, machine)

    def one(seed: int) -> Outcome:
        plant = _plant(row, machine, seed)
        paths = {
            course.drawn[0].lap.path.name: _figures(course, machine, plant, seed, adapt, row.load)
            for course in courses[row.speeds[seed % len(row.speeds)]]
        }
        return Outcome(
            seed=seed,
            drawn=plant.told,
            overloaded=plant.head > most,
            figures=_worst(list(paths.values())),
            paths=paths,
        )

    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        return list(pool.map(one, seeds))


def _course(path: TipPath, speed: float, machine: Machine, laps: int, rival: Rival) -> Course:
    course = prepare(path, speed, rival.control.scheme, machine, laps)
    settings = rival.control._replace(tip_speed=course.settings.tip_speed)
    return course._replace(settings=settings, drive=rival.drive)


def lifted(row: MatrixRow, machine: Machine) -> float:
    """Return what the machine's file lets it lift everywhere on a row's paths [kg]."""
    return min(least_capacity(path, machine) for path in row.paths)


def least_capacity(path: TipPath, machine: Machine) -> float:
    """Return what the machine's file lets it lift everywhere on a path [kg]."""
    places = [path.at(path.length * k / PLACES) for k in range(PLACES + 1)]
    chart = capacity(machine)
    return min(allowed_load(math.hypot(x, y), chart) for x, y, _ in places)


def _plant(row: MatrixRow, machine: Machine, seed: int) -> _Plant:
    off = model_mismatch.draw(seed, row.ranges)
    every = JOYSTICKS[seed % 4] if row.joystick else 1
    rate = RATES[seed // 4 % 2] if row.sensors else machine.sensors.sample_rate
    sensed = dataclasses.replace(machine, sensors=dataclasses.replace(machine.sensors, sample_rate=rate))
    told = {**off.told(), "joystick_hz": 1.0 / (every * PERIOD), "sensors_hz": rate}
    dead_time = machine.valve.dead_time if off.dead_time is None else off.dead_time
    return _Plant(
        sensed=sensed,
        parameters=model_mismatch.applied(machine, off),
        every=every,
        steps=STEPS if row.joystick else 0.0,
        dead_time=dead_time or 0.0,
        head=machine.manipulator.head_mass if off.head is None else off.head,
        crane=model_mismatch.drawn(machine, off).manipulator,
        told=told,
    )


def _figures(
    course: Course, machine: Machine, plant: _Plant, seed: int, adapt: bool, load: float
) -> Figures | None:
    hand = _hand(course.hand, plant)
    suite = noisy(plant.sensed, seed)
    if load > 0.0:
        return grasped_and_dropped(course, machine, suite, adapt, plant.parameters, plant.crane, load)
    try:
        session = follow(course._replace(hand=hand), machine, suite, adapt, plant.parameters)
    except PathError:
        return None
    return _judged(session, plant.every * PERIOD + plant.dead_time, course.hand.speed)


def _hand(hand: Hand, plant: _Plant) -> Hand:
    """Return the operator's hand on a seed's joystick."""
    latency = 0.0 if plant.every == 1 else LATENCY * plant.every
    return Hand(hand.speed, latency, plant.every, plant.steps)


def _judged(session: Session, delay: float, speed: float) -> Figures:
    """Return the last lap's figures, of joystick and valves that delay it [s], at a wished speed [m/s]."""
    score, moved, lap = session.scores[-1], session.moved, session.drawn[-1].lap
    waited = max(0.0, score.duration_s - lap.profile.duration)
    bound = 1e3 * (speed * (delay + BOUND_DELAY) + BOUND)
    volts = np.abs(np.diff(moved.voltages, axis=0)) / PERIOD
    return Figures(
        cross_track_rms_mm=score.cross_track_rms_mm,
        cross_track_max_mm=score.cross_track_max_mm,
        governed_rms_mm=score.governed_rms_mm,
        governed_max_mm=score.governed_max_mm,
        wish_rms_mm=score.wish_rms_mm,
        wish_max_mm=score.wish_max_mm,
        wish_over_bound=score.wish_max_mm / bound if waited < WAITED else 0.0,
        waited_s=waited,
        time_lost_s=score.time_lost_s,
        velocity_rms=score.velocity_rms,
        end_mm=score.end_mm,
        overshoot_mm=_overshoot(session),
        activity=float(volts.mean(axis=0).max()),
    )


def _overshoot(session: Session) -> float:
    """Return how far the tip went beyond the path's end along its last direction, at most [mm]."""
    drawn, led = session.drawn[-1], session.led
    end, before = drawn.line[-1], drawn.line[-2]
    along = (end - before) / np.linalg.norm(end - before)
    beyond = (led.moved.tip[drawn.lap.rows(led.clock)[-1] - ENDING :] - end) @ along
    return max(0.0, 1e3 * float(beyond.max()))


def _worst(found: Sequence[Figures | None]) -> Figures | None:
    """Return the worst of each figure; None where a run did not end."""
    ended = [one for one in found if one is not None]
    if len(ended) < len(found):
        return None
    return Figures(*(max(values) for values in zip(*ended, strict=True)))
