"""The scenes in which a changed constant may show: each a short closed loop, of few figures.

All are of the machine as its file has it, unless said, and run compiled. A scene is a function of machine and
settings; its figures are told by name, and less is better in all of them but where the name says otherwise.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_control.operator.levers import levers_for_tip_velocity
from forest_control.servo.schemes import Scheme
from forest_control.taught.tip_path import TipPath, cross_track_distance, polyline
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.simulation.load_schedule import Load, loaded
from forest_study.ablation.constants import Settings
from forest_study.ablation.pushes import activity, pushed
from forest_study.closed_loop import compiled_loop, model_mismatch
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.closed_loop.compiled_loop import Led
from forest_study.closed_loop.model_mismatch import Ranges
from forest_study.measures import line_of
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import Course, noisy, prepare

Scene = Callable[[Machine, Settings], dict[str, float]]
SPEED, SLOW, FAST = 0.5, 0.05, 1.0  # [m/s]
LONGEST = 2.0  # times the profile's time that a run may take
EVERY = 10  # rows of a run are held against its path: 25 mm of way at `SPEED`
SHORT = 0.3  # [m] of the slow path
UNKNOWN = 2, 5  # seeds of plants that nobody knows
HIDDEN = Ranges(
    deadband=0.2, gain=0.2, head_mass=1.3, spool=1.4, stiffness=0.2, tilt=10.0, dead_time=0.02,
    hysteresis=0.3, backlash=0.2, oil=80.0,
)  # fmt: skip
LOG, TOO_MUCH = 1200.0, 2500.0  # [kg]
HELD: Vec3 = (5.9, 0.0, 1.0)  # [m] of a tip that grasps
REACHED: Vec3 = (6.5, 0.0, 0.0)  # [m] of a tip that goes to its limits


class Part(NamedTuple):
    """What the levers ask for, and for how long."""

    velocity: Vec3  # [m/s]
    seconds: float
    held: bool = True  # the deadman


def paths(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return how far halves of circles are missed at `SPEED`, and how busy the busiest valve is."""
    found = [_along(_half(name), SPEED, machine, settings) for name in ("circle_h", "circle_v")]
    return {
        "cross-track, mm": max(1e3 * _rms(away) for away, _ in found),
        "governed, mm": max(1e3 * _rms(_governed(led.moved)) for _, led in found),
        "V/s": max(activity(led.moved.voltages) for _, led in found),
    }


def slow(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return the error of the tip's velocity along the middle of the vertical, at `SLOW`."""
    path = path_named("vertical")
    begin, end = (0.5 * (path.length + side * SHORT) for side in (-1.0, 1.0))
    _, led = _along(polyline(path.name, [path.at(begin), path.at(end)]), SLOW, machine, settings)
    wrong = np.gradient(led.moved.tip, PERIOD, axis=0) - led.moved.tip_wish
    return {"slow, mm/s": 1e3 * _rms(np.linalg.norm(wrong, axis=1))}


def fast(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return cross-track and duration of half a circle at `FAST`, which the pumps and valves do not give."""
    away, led = _along(_half("circle_v"), FAST, machine, settings)
    return {"fast, mm": 1e3 * _rms(away), "fast, s": float(led.moved.time[-1])}


def unknown(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return cross-track and duration on plants that differ from the file, on the first pass."""
    path, found = _half("circle_h"), []
    for seed in UNKNOWN:
        plant = model_mismatch.applied(machine, model_mismatch.draw(seed, HIDDEN))
        found.append(_along(path, SPEED, machine, settings, seed=seed, plant=plant))
    return {
        "unknown, mm": max(1e3 * _rms(away) for away, _ in found),
        "unknown, s": max(float(led.moved.time[-1]) for _, led in found),
    }


def schemes(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return the governed error of two of the thesis' schemes along half a circle."""
    found = {}
    for scheme in (Scheme.IK_VELOCITY, Scheme.JACOBIAN_POSITION):
        _, led = _along(_half("circle_v"), SPEED, machine, settings, scheme=scheme)
        found[f"{scheme.label}, mm"] = 1e3 * _rms(_governed(led.moved))
    return found


def stops(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return how a moving tip stops when the deadman is let go, and starts again."""
    ways: tuple[Vec3, ...] = ((0.0, 0.5, 0.0), (0.3, 0.0, -0.4), (-0.35, 0.25, 0.25))
    still, away, again = [], [], []
    for seed, wish in enumerate(ways):
        parts = (Part((0.0, 0.0, 0.0), 0.1), Part(wish, 1.0), Part(wish, 1.5, held=False))
        more = (Part((0.0, 0.0, 0.0), 0.2), Part(wish, 0.5))
        moved = _driven((*parts, *more), machine, settings, seed)
        let_go, back = round(1.1 / PERIOD), round(2.8 / PERIOD)
        speed = np.linalg.norm(np.gradient(moved.tip[let_go:back], PERIOD, axis=0), axis=1)
        still.append(PERIOD * (_last(speed > 0.1 * SPEED) + 1))
        away.append(1e3 * float(np.linalg.norm(moved.tip[let_go:back] - moved.tip[let_go], axis=1).max()))
        again.append(1e3 * _rms(_governed(moved)[back:]))
    return {"stop, s": max(still), "stop, mm": max(away), "start, mm": max(again)}


def load(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return what grasping and dropping a log at rest moves, and what is left after 6 s."""
    plant = plant_parameters(machine)
    heavy, (grasped, dropped, end) = loaded(plant, machine.manipulator, Load(LOG)), (200, 1400, 2600)
    parts = (Part((0.0, 0.0, 0.0), PERIOD * end),)
    moved = _driven(parts, machine, settings, 0, HELD, {grasped: heavy, dropped: plant})
    away = 1e3 * np.linalg.norm(moved.tip - moved.tip[grasped], axis=1)
    return {
        "load, peak, mm": float(away.max()),
        "load, rest, mm": float(max(away[dropped - 100 : dropped].mean(), away[-100:].mean())),
    }


def overload(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return how late the valves of a rising, overloaded boom shut, and how fast its tip ever is."""
    bare = dataclasses.replace(machine, capacity=None)
    plant = plant_parameters(bare)
    heavy, (grasped, dropped) = loaded(plant, bare.manipulator, Load(TOO_MUCH)), (240, 640)
    parts = (Part((0.0, 0.0, 0.0), 0.5), Part((0.0, 0.0, 0.5), 4.0))
    moved = _driven(parts, bare, settings, 0, REACHED, {grasped: heavy, dropped: plant})
    speed = np.linalg.norm(np.gradient(moved.tip, PERIOD, axis=0), axis=1)
    opened = np.flatnonzero(moved.voltages[grasped:dropped].any(axis=1))
    return {
        "overload, s": PERIOD * float(opened[-1] + 1) if len(opened) else 0.0,
        "overload, m/s": float(speed[grasped:].max()),
    }


def capacity(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return how far out a log is carried, up to the load limit and back, and how busy the valves are."""
    plant = plant_parameters(machine)
    parts = (Part((0.0, 0.0, 0.0), 1.0), Part((0.5, 0.0, 0.0), 4.0), Part((-0.5, 0.0, 0.0), 1.5))
    moved = _driven(parts, machine, settings, 0, HELD, {100: loaded(plant, machine.manipulator, Load(LOG))})
    return {
        "capacity, out, m": float(moved.tip[:, 0].max()),
        "capacity, back, m": float(moved.tip[:, 0].max() - moved.tip[-1, 0]),
        "capacity, V/s": activity(moved.voltages),
    }


def limits(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return where a tip at full speed ends at its joints' limits, and how far it comes back in a second."""
    found = {}
    for name, wish in {"out": (0.7, 0.0, 0.7), "in": (-1.0, 0.0, 0.0), "down": (0.0, 0.0, -1.0)}.items():
        back = (-wish[0], -wish[1], -wish[2])
        parts = (Part((0.0, 0.0, 0.0), 0.1), Part(wish, 7.0), Part(back, 1.0))
        moved = _driven(parts, machine, settings, 0, REACHED, speed=FAST)
        at = round(7.1 / PERIOD)
        gone, along = moved.tip[:at] - moved.tip[0], np.array(wish) / math.hypot(*wish)
        found[f"limits, {name}, m"] = float((gone @ along).max())
        found[f"limits, {name}, back, m"] = float(np.linalg.norm(moved.tip[-1] - moved.tip[at]))
    return found


def sway(machine: Machine, settings: Settings) -> dict[str, float]:
    """Return how a tip whose head must not sway stops."""
    quiet = settings._replace(control=settings.control._replace(anti_sway=True))
    parts = (Part((0.0, 0.0, 0.0), 0.3), Part((-0.4, 0.3, 0.0), 1.5), Part((0.0, 0.0, 0.0), 4.0))
    moved = _driven(parts, machine, quiet, 0)
    speed = np.linalg.norm(np.gradient(moved.tip, PERIOD, axis=0), axis=1)
    return {"anti-sway, s": PERIOD * _last(speed > 0.02) - 1.8}


def pushes(
    machine: Machine, settings: Settings, number: int, conditions: list[tuple[float, float]]
) -> dict[str, float]:
    """Return after how many pushes a valve does not come to rest, and where 95 % come to rest.

    Args:
        machine: of the file.
        settings: of control.
        number: of pushes of each condition.
        conditions: believed over true overlap; tilt [rad] that nobody knows.
    """
    found = {}
    for share, tilt in conditions:
        left = [pushed(machine, seed, share, tilt, settings) for seed in range(number)]
        name = f"{share:g}" + (f" at {math.degrees(tilt):g}°" if tilt else "")
        errors = sorted(one.error for one in left)
        found[f"cycles, {name}"] = float(sum(one.cycles for one in left))
        found[f"rest, {name}, mm"] = 1e3 * errors[math.ceil(0.95 * len(errors)) - 1]
    return found


SCENES: dict[str, Scene] = {
    one.__name__: one
    for one in (
        *(paths, slow, fast, unknown, schemes, stops, load, overload, capacity, limits),
        sway,
    )
}


@lru_cache
def _half(name: str) -> TipPath:
    """Return the first half of a circle."""
    return TipPath(name, math.pi, path_named(name).at, (0.0, math.pi))


@lru_cache
def _course(path: TipPath, speed: float, machine: Machine) -> Course:
    """Return a path's course, which all schemes are asked to go alike."""
    return prepare(path, speed, Scheme.COORDINATED, machine)


def _along(
    path: TipPath,
    speed: float,
    machine: Machine,
    settings: Settings,
    scheme: Scheme = Scheme.COORDINATED,
    seed: int = 0,
    plant: PlantParameters | None = None,
) -> tuple[Floats, Led]:
    """Return what an operator led along a path, and how far it was from it [N] m."""
    course = _course(path, speed, machine)
    control = settings.control._replace(tip_speed=speed, scheme=scheme)
    rows = np.ones((round(LONGEST * len(course.places)), 4))
    start, suite = pose_at(course.start, machine), noisy(machine, seed)
    given = (machine, rows, start, control, settings.drive)
    led = compiled_loop.prepared(*given, suite=suite, plant=plant).lead(course.places, course.hand)
    return cross_track_distance(line_of(path), led.moved.tip[::EVERY]), led


def _driven(
    parts: tuple[Part, ...],
    machine: Machine,
    settings: Settings,
    seed: int,
    tip: Vec3 | None = None,
    loads: Mapping[int, PlantParameters] = compiled_loop.NO_LOADS,
    speed: float = SPEED,
) -> Trajectory:
    """Return what levers do, from a place of the tip on."""
    rows = []
    for wish, seconds, held in parts:
        rows += [[*levers_for_tip_velocity(wish, speed), float(held)]] * round(seconds / PERIOD)
    control = settings.control._replace(tip_speed=speed)
    start = pose_at(start_tip(machine) if tip is None else tip, machine)
    given = (machine, np.array(rows), start, control, settings.drive)
    return compiled_loop.prepared(*given, suite=noisy(machine, seed)).run(loads)


def _governed(moved: Trajectory) -> Floats:
    """Return how far a tip was from its reference [N] m."""
    error = moved.tip_error()
    distance: Floats = np.linalg.norm(error - error[0], axis=1)
    return distance


def _last(moving: NDArray[np.bool_]) -> int:
    """Return the last row in which the tip moves.

    Raises:
        ValueError: it never does: control has failed.
    """
    rows = np.flatnonzero(moving)
    if not len(rows):
        raise ValueError("the tip never moves")
    return int(rows[-1])


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
