"""The tip along a path, closed loop, and how far it was from where it should be: `forest-study track`'s core.

The reference generator plays the operator: it wishes the tip velocity of the fastest profile along the path,
and waits where a limit holds the reference back, so that the path is kept (`path_guide`).
The machine may be another one than controller and driver believe. The path as drawn starts where the true tip
is at rest in the beginning. What is told of a run: `measures`, over the rows from the profile's first motion
to its last. Levers are those of a joystick's message: single precision.
"""

import dataclasses
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from forest_control.config import controller_settings
from forest_control.servo.joint_angle_filter import Source
from forest_control.servo.schemes import Scheme
from forest_control.taught.plan import RAMP, RESERVE, greatest_speed
from forest_control.taught.tip_path import PathError, Profile, TipPath, fastest, is_closed, reverse
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.sensors.sensor_suite import Suite, calibrated, sensor_suite
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.closed_loop.compiled_loop import Led
from forest_study.closed_loop.loop_core import SUBSTEPS
from forest_study.closed_loop.path_guide import Hand
from forest_study.measures import ideal
from forest_study.tracking.scores import Drawn, Lap, Score, drawn, scores_of

REST = 1.0  # [s] before the first lap and after every lap
LATELY = 1.0  # [s] at the end of a run that took too long, by which it is told what holds it
LONGEST = 1.1, 6.0  # times the profile's time that a run may take, tried one after the other


class Course(NamedTuple):
    """What all runs along a path have in common."""

    drawn: tuple[Drawn, ...]
    settings: controller_settings.Settings
    model: Machine  # that controller and driver believe
    places: Floats  # [K, 3] m of the profile, one a period, rests included
    hand: Hand
    drive: valve_driver_parameters.Settings = valve_driver_parameters.Settings()
    substeps: int = SUBSTEPS  # of the machine, to a period

    @property
    def start(self) -> Vec3:
        """Where the tip is at rest beforehand [m]."""
        return self.drawn[0].lap.path.at(0.0)


@dataclasses.dataclass(frozen=True)
class Session:
    """A track run: what was drawn, what happened, scores."""

    drawn: tuple[Drawn, ...]
    led: Led
    scores: tuple[Score, ...]
    total: Score

    @property
    def moved(self) -> Trajectory:
        """What happened."""
        return self.led.moved


def track(
    path: TipPath,
    speed: float,
    scheme: Scheme,
    machine: Machine,
    model: Machine,
    suite: Suite | None = None,
    laps: int = 1,
    adapt: bool = True,
    source: Source = Source.CYLINDERS,
) -> Session:
    """Run laps along a path.

    Args:
        path: what the tip shall follow; the machine starts at rest at its start.
        speed: wished speed [m/s].
        scheme: of the controller.
        machine: what is simulated.
        model: what controller and driver believe.
        suite: sensors; default: exact ones.
        laps: how often; an open path is gone back and forth.
        adapt: the driver learns its valves' deadbands and gains.
        source: what tells the controller where boom and stick are.

    Raises:
        PathError: the path leaves the reach, or the speed is not above 0.
    """
    return follow(prepare(path, speed, scheme, model, laps, source), machine, suite, adapt)


def prepare(
    path: TipPath,
    speed: float,
    scheme: Scheme,
    model: Machine,
    laps: int = 1,
    source: Source = Source.CYLINDERS,
) -> Course:
    """Return what every run along a path has in common; arguments as `track`.

    Raises:
        PathError: as `track`.
    """
    if not 0.0 < speed < math.inf:
        raise PathError(f"speed {speed!r}; allowed: above 0 m/s")
    settings = controller_settings.Settings(scheme=scheme, tip_speed=speed, position_source=source)
    runs = plan(path, speed, controller_settings.parameters(model, settings), laps)
    end = runs[-1].start + runs[-1].profile.duration + REST
    times: Floats = PERIOD * np.arange(round(end / PERIOD) + 1, dtype=np.float64)
    places = _places(times, runs)
    return Course(tuple(map(drawn, runs)), settings, model, places, Hand(speed))


def follow(
    course: Course,
    machine: Machine,
    suite: Suite | None = None,
    adapt: bool = True,
    plant: PlantParameters | None = None,
    compiled: bool = True,
) -> Session:
    """Run a course.

    Args:
        course: what is driven.
        machine: what is simulated.
        suite: as of `track`.
        adapt: as of `track`.
        plant: what is simulated instead of the machine's parameters.
        compiled: by machine code, which is made if need be; else in Python, to the same bits.
    """
    start = _angles(course.start, course.drawn[0].lap.path, machine)
    drive = course.drive._replace(adapt=adapt)
    for most in LONGEST:
        rows = round(most * len(course.places))
        given = start, course.settings, drive, course.model, suite, plant, course.substeps
        if compiled:
            begun = compiled_loop.prepared(machine, np.ones((rows, 4)), *given)
            led = begun.lead(course.places, course.hand)
        else:
            led = compiled_loop.interpreted(machine, rows, *given).lead(course.places, course.hand)
        if len(led.clock) < rows:
            return scored(course, led, machine)
    raise PathError(f"{course.drawn[0].lap.path.name}: {_unfinished(course, led, machine)}")


def _unfinished(course: Course, led: Led, machine: Machine) -> str:
    """Return how far a run has come that took too long, and why."""
    path, late = course.drawn[-1].lap.path, round(LATELY / PERIOD)
    left = math.dist(led.moved.tip[-1], path.at(path.length))
    said = f"after {LONGEST[-1]:g} times the profile's time the tip is {left:.2f} m from the end"
    if course.model.capacity is not None and machine.sensors.pressure is None:
        return f"{said}: without sensors.pressure the load chart allows only motions that unload"
    stands = not np.any(led.moved.tip_wish[-late:])
    return f"{said}: {'a limit of the controller holds it' if stands else 'it is still on its way'}"


def scored(course: Course, led: Led, machine: Machine) -> Session:
    """Return a course and what happened with its scores."""
    return Session(course.drawn, led, *scores_of(course.drawn, led, machine))


def plan(path: TipPath, speed: float, p: controller_settings.Parameters, laps: int) -> tuple[Lap, ...]:
    """Return laps one after the other, as fast as speed, ramps and the velocity limits allow."""
    runs: list[Lap] = []
    start, back = REST, path if is_closed(path) else reverse(path)
    for k in range(laps):
        way = back if k % 2 else path
        profile = _profile(way, speed, p)
        runs.append(Lap(start, way, profile))
        start = PERIOD * math.ceil((start + profile.duration + REST) / PERIOD)
    return tuple(runs)


@lru_cache(maxsize=16)
def _profile(path: TipPath, speed: float, p: controller_settings.Parameters) -> Profile:
    """Return the fastest profile along a path; it takes longer than the run along it."""
    asked = speed / RESERVE
    return fastest(
        path, speed, RAMP, lambda place, along: RESERVE * greatest_speed(path.name, place, along, asked, p)
    )


def _angles(place: Vec3, path: TipPath, machine: Machine) -> Vec3:
    try:
        return pose_at(place, machine)
    except ValueError as error:
        raise PathError(f"{path.name}: {error}") from error


def _places(times: Floats, laps: tuple[Lap, ...]) -> Floats:
    """Return where the profile is at rising times [N] s: [N, 3] m."""
    begins = [lap.start - 0.5 * PERIOD for lap in laps[1:]]
    parts = zip(laps, np.split(times, np.searchsorted(times, begins)), strict=True)
    return np.concatenate([ideal(lap.path, lap.profile, part - lap.start) for lap, part in parts])


def noisy(machine: Machine, seed: int, static_errors: bool = False) -> Suite:
    """Return sensors that jitter; without their static errors, which calibration takes out, unless asked."""
    suite = sensor_suite(machine, noise=True, seed=seed)
    return suite if static_errors else calibrated(suite)
