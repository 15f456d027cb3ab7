"""The trials of one change: paths, slow motion, pushes. A process of its own makes them.

Controller and driver run interpreted, the machine compiled: each change would else cost a compilation. The
operator says every period what the fastest profile along the path wishes.
"""

import dataclasses
import json
import math
import subprocess
import sys
from typing import Any, NamedTuple

from forest_control.config import controller_settings
from forest_control.servo.schemes import Scheme
from forest_control.taught.tip_path import TipPath, polyline
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.machine import Machine, load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_study.ablation.constants import Changes, Number, Settings, changed
from forest_study.ablation.pushes import END, Rest, activity, misjudged, push, rest
from forest_study.closed_loop import loop_kernel
from forest_study.closed_loop.closed_loop import ClosedLoop, run
from forest_study.results import StudyError
from forest_study.tracking.paths import path_named
from forest_study.tracking.scores import Score
from forest_study.tracking.tracking import noisy, prepare, scored

PATHS = ("circle_h", "circle_v")  # at `SPEED`, noise of seed 0
SPEED, SLOW = 0.5, 0.05  # [m/s]
SHORT = 0.3  # [m] of the slow path
UNKNOWN = 3  # exit code for a name that is not known
LONGEST = 2.0  # times the profile's time that a run may take


class Figures(NamedTuple):
    """What a change is judged by."""

    paths_mm: float  # cross-track RMS, the worst of `PATHS`
    governed_mm: float  # RMS, alike
    slow_mm_s: float  # RMS velocity error along the vertical at `SLOW`
    volts_s: float  # [V/s] mean of |dV/dt| of the busiest valve along `PATHS`
    cycles: int  # pushes after which a valve does not come to rest
    rest_mm: float  # 95 % of the pushes come to rest nearer than this


class Trial(NamedTuple):
    """What is to be tried."""

    machine: str
    changes: Changes
    pushes: int
    overlap: float  # believed over true
    tilt: float  # [rad] of the platform, which the controller does not know


def tried(trial: Trial) -> Figures | None:
    """Return the figures of a trial from a process of its own; None if control failed in it.

    Raises:
        StudyError: a name is not known.
    """
    command = [sys.executable, "-m", "forest_study.ablation.trials"]
    done = subprocess.run(
        command, input=json.dumps(trial._asdict()), capture_output=True, text=True, check=False
    )
    if done.returncode == UNKNOWN:
        raise StudyError(done.stderr.strip())
    return Figures(*json.loads(done.stdout)) if done.returncode == 0 else None


def figures(trial: Trial) -> Figures:
    """Return the figures of a trial in this process, whose constants change for good.

    Raises:
        StudyError: a name is not known.
        PathError: a path leaves the machine's reach.
    """
    settings = changed({name: _number(value) for name, value in trial.changes.items()})
    machine = load_machine(trial.machine)
    driven = [_driven(path_named(name), SPEED, machine, settings) for name in PATHS]
    slow, _ = _driven(_middle(path_named("vertical")), SLOW, machine, settings)
    left = [pushed(machine, seed, trial, settings) for seed in range(trial.pushes)]
    errors = sorted(one.error for one in left)
    return Figures(
        paths_mm=max(score.cross_track_rms_mm for score, _ in driven),
        governed_mm=max(score.governed_rms_mm for score, _ in driven),
        slow_mm_s=1e3 * slow.velocity_rms,
        volts_s=max(busy for _, busy in driven),
        cycles=sum(one.cycles for one in left),
        rest_mm=1e3 * errors[math.ceil(0.95 * len(errors)) - 1],
    )


def _driven(path: TipPath, speed: float, machine: Machine, settings: Settings) -> tuple[Score, float]:
    """Return a run's score, and how busy its busiest valve is [V/s]."""
    course = prepare(path, speed, Scheme.COORDINATED, machine)
    control = controller_settings.parameters(machine, settings.control._replace(tip_speed=speed))
    drive = valve_driver_parameters.parameters(machine, settings.drive)
    start = pose_at(course.start, machine)
    loop = ClosedLoop(plant_parameters(machine), control, drive, start, noisy(machine, 0))
    links, rows = machine.manipulator.links, round(LONGEST * len(course.places))
    led = loop_kernel.lead_interpreted(loop, links, course.places, course.hand, rows)
    return scored(course, led, machine).total, activity(led.moved.voltages)


def pushed(machine: Machine, seed: int, trial: Trial, settings: Settings) -> Rest:
    """Return what is left of a push of a crane on a slope, its overlap misjudged."""
    crane, given = machine.manipulator, push(machine, seed)
    sloped = dataclasses.replace(crane, platform_tilt=crane.platform_tilt + trial.tilt)
    plant, model = dataclasses.replace(machine, manipulator=sloped), misjudged(machine, trial.overlap)
    suite = noisy(plant, seed)
    return rest(run(plant, given.operator, END, given.start, *settings, model=model, sensor_suite=suite))


def _middle(path: TipPath) -> TipPath:
    """Return the middle of a straight path."""
    begin, end = (0.5 * (path.length + side * SHORT) for side in (-1.0, 1.0))
    return polyline(path.name, [path.at(begin), path.at(end)])


def _number(value: Any) -> Number:
    return tuple(value) if isinstance(value, list) else value


if __name__ == "__main__":
    try:
        print(json.dumps(figures(Trial(**json.load(sys.stdin)))))
    except StudyError as error:
        print(error, file=sys.stderr)
        sys.exit(UNKNOWN)
