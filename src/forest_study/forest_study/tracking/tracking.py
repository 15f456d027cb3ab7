"""The tip along a path, closed loop, and how far it was from where it should be: `forest-study track`'s core.

The reference generator plays the operator: it wishes the tip velocity of the fastest profile along the path.
The machine may be another one than controller and driver believe. The path as drawn starts where the true tip
is at rest in the beginning. What is told of a run: `measures`, over the rows from the profile's first motion
to its last. Levers are those of a joystick's message: single precision.
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from forest_control.config import controller_settings
from forest_control.operator.levers import levers_for_tip_velocity
from forest_control.servo.joint_angle_filter import Source
from forest_control.servo.schemes import Scheme
from forest_control.taught.plan import RAMP, RESERVE, greatest_speed
from forest_control.taught.tip_path import PathError, TipPath, fastest, is_closed, reverse
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.machine import Machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.sensors.sensor_suite import Suite, calibrated, sensor_suite
from forest_study.closed_loop import loop_kernel
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.tracking.scores import Drawn, Lap, Score, drawn, scores_of

REST = 1.0  # [s] before the first lap and after every lap


class Course(NamedTuple):
    """What all runs along a path have in common."""

    drawn: tuple[Drawn, ...]
    settings: controller_settings.Settings
    model: Machine  # that controller and driver believe
    levers: Floats  # [N, 4] of `loop_kernel`

    @property
    def start(self) -> Vec3:
        """Where the tip is at rest beforehand [m]."""
        return self.drawn[0].lap.path.at(0.0)


@dataclasses.dataclass(frozen=True)
class Session:
    """A track run: what was drawn, what happened, scores."""

    drawn: tuple[Drawn, ...]
    moved: Trajectory
    scores: tuple[Score, ...]
    total: Score


def track(
    path: TipPath,
    speed: float,
    scheme: Scheme,
    machine: Machine,
    model: Machine,
    suite: Suite | None = None,
    laps: int = 1,
    adapt: bool = False,
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
        PathError: the path leaves the reach.
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
    settings = controller_settings.Settings(scheme=scheme, tip_speed=speed, position_source=source)
    runs = plan(path, speed, controller_settings.parameters(model, settings), laps)
    end = runs[-1].start + runs[-1].profile.duration + REST
    times = [k * PERIOD for k in range(round(end / PERIOD))]
    levers = [(*levers_for_tip_velocity(_wish(time, runs), speed), 1.0) for time in times]
    return Course(
        tuple(map(drawn, runs)), settings, model, np.array(levers, dtype=np.float32).astype(np.float64)
    )


def follow(
    course: Course,
    machine: Machine,
    suite: Suite | None = None,
    adapt: bool = False,
    plant: PlantParameters | None = None,
) -> Session:
    """Run a course; arguments as `track`; plant: what is simulated instead of the machine's parameters."""
    start = _angles(course.start, course.drawn[0].lap.path, machine)
    drive = valve_driver_parameters.Settings(adapt=adapt)
    moved = loop_kernel.run(machine, course.levers, start, course.settings, drive, course.model, suite, plant)
    return scored(course, moved, machine)


def scored(course: Course, moved: Trajectory, machine: Machine) -> Session:
    """Return a course and what happened with its scores."""
    return Session(course.drawn, moved, *scores_of(course.drawn, moved, machine))


def plan(path: TipPath, speed: float, p: controller_settings.Parameters, laps: int) -> tuple[Lap, ...]:
    """Return laps one after the other, as fast as speed, ramps and the velocity limits allow."""
    runs: list[Lap] = []
    start = REST
    for k in range(laps):
        way = path if k % 2 == 0 or is_closed(path) else reverse(path)
        profile = fastest(
            way, speed, RAMP, lambda place, along: RESERVE * greatest_speed(path.name, place, along, p)
        )
        runs.append(Lap(start, way, profile))
        start = PERIOD * math.ceil((start + profile.duration + REST) / PERIOD)
    return tuple(runs)


def _angles(place: Vec3, path: TipPath, machine: Machine) -> Vec3:
    try:
        return pose_at(place, machine)
    except ValueError as error:
        raise PathError(f"{path.name}: {error}") from error


def _wish(time: float, laps: tuple[Lap, ...]) -> Vec3:
    """Return the velocity [m/s] that moves the reference to its place one period later."""
    lap = next((lap for lap in reversed(laps) if time >= lap.start - 0.5 * PERIOD), laps[0])
    since = time - lap.start
    here, there = (lap.path.at(lap.profile.way_at(since + ahead)) for ahead in (0.0, PERIOD))
    x, y, z = ((b - a) / PERIOD for a, b in zip(here, there, strict=True))
    return x, y, z


def noisy(machine: Machine, seed: int, static_errors: bool = False) -> Suite:
    """Return sensors that jitter; without their static errors, which calibration takes out, unless asked."""
    suite = sensor_suite(machine, noise=True, seed=seed)
    return suite if static_errors else calibrated(suite)
