"""Healthy machines at work: each seed's plant, sensors, logs, oil and places, hidden from the monitor.

What is drawn of the machine are the matrix' ranges, but for the head, the spool's bandwidth and the oil:
those that the monitor must allow for. Oil warms while it works. A log is grasped and dropped at pauses.
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from forest_description.derived.limits import pose_at
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop import model_mismatch
from forest_study.closed_loop.model_mismatch import Mismatch, Ranges

RANGES = Ranges(deadband=0.2, gain=0.2, head_mass=1.3, spool=math.sqrt(2.0), stiffness=0.2, tilt=10.0)
PLAYED = RANGES._replace(dead_time=0.02, hysteresis=0.3)
OIL = (20.0, 70.0)  # [degree Celsius] when the work begins
WARMS = (0.0, 15.0)  # [K] in a run
LOGS = (100.0, 600.0)  # [kg]
LOADED = 0.4  # [1] of the pauses at which a log is grasped
SPEEDS = (0.15, 0.6)  # [m/s]
REACH, SIDE, HEIGHT = (4.5, 7.0), 0.5, (-0.5, 2.0)  # [m], [rad] between two places, [m]
WIDEST = 1.2  # [rad] of the swing from the middle
PAUSES = (1.0, 6.0)  # [s]
RELEASED = 0.6  # [1] of the pauses in which the deadman is let go
RATES = (200.0, 50.0)  # [Hz] of the sensors


class Day(NamedTuple):
    """A seed's machine and work."""

    off: Mismatch
    rate: float  # [Hz]
    oil: tuple[float, float]  # [K] at the beginning, at the end
    start: Vec3  # [rad]
    work: Floats  # [N, 5] of `monitored_loop.run`
    logs: tuple[tuple[int, float], ...]  # row, [kg]


def day(machine: Machine, seed: int, duration: float) -> Day:
    """Return a seed's machine and so many seconds of its work."""
    rng = np.random.default_rng([seed, 11])
    off = model_mismatch.draw(seed, _ranges(machine))
    begin = model_mismatch.ICE + rng.uniform(*OIL)
    place, total = (5.5, 0.0, 0.8), round(duration / PERIOD)
    rows: list[tuple[float, ...]] = []
    start, logs, held = pose_at(place, machine), [], 0.0
    while len(rows) < total:
        there = _next(rng, place)
        speed, pause = rng.uniform(*SPEEDS), rng.uniform(*PAUSES)
        rows += [(*there, speed, 1.0)] * round((1.3 * math.dist(place, there) / speed + 0.5) / PERIOD)
        if held > 0.0 or rng.random() < LOADED:
            held = 0.0 if held > 0.0 else float(rng.uniform(*LOGS))
            logs.append((len(rows), held))
        rests = round(pause / PERIOD)
        released = rests - 160 if rng.random() < RELEASED and rests > 240 else 0
        rows += [(*there, speed, 0.7)] * 80 + [(*there, speed, 0.0)] * released
        rows += [(*there, speed, 0.7)] * (rests - 80 - released)
        place = there
    return Day(
        off=off,
        rate=RATES[seed % 2],
        oil=(begin, begin + float(rng.uniform(*WARMS))),
        start=start,
        work=np.array(rows[:total]),
        logs=tuple((row, mass) for row, mass in logs if row < total),
    )


def _ranges(machine: Machine) -> Ranges:
    """Return what is drawn of a machine: play and bending where its file has them."""
    if machine.valve.hysteresis is None:
        return RANGES
    return PLAYED._replace(backlash=0.2, bending=0.5)


def _next(rng: np.random.Generator, place: Vec3) -> Vec3:
    angle = math.atan2(place[1], place[0]) + rng.uniform(-SIDE, SIDE)
    angle, reach = max(-WIDEST, min(WIDEST, angle)), rng.uniform(*REACH)
    return reach * math.cos(angle), reach * math.sin(angle), float(rng.uniform(*HEIGHT))


def sensed(machine: Machine, rate: float) -> Machine:
    """Return a machine whose sensors sample at a rate [Hz]."""
    return dataclasses.replace(machine, sensors=dataclasses.replace(machine.sensors, sample_rate=rate))
