"""The trials of one change: paths, slow motion, pushes. A process of its own makes them.

All changes run in one compiled loop, which reads the constants when it runs. The operator says every period
what the fastest profile along the path wishes.
"""

import dataclasses
import json
import math
import subprocess
import sys
from typing import Any, NamedTuple

import numpy as np

from forest_control.servo.schemes import Scheme
from forest_control.taught.tip_path import PathError, TipPath, polyline
from forest_description.derived.limits import pose_at
from forest_description.machine import Machine, load_machine
from forest_study.ablation.constants import Changes, Number, Settings, at_runtime, changed
from forest_study.ablation.pushes import END, Rest, activity, misjudged, push, rest
from forest_study.closed_loop import loop_kernel
from forest_study.results import StudyError
from forest_study.tracking.paths import path_named
from forest_study.tracking.scores import Score
from forest_study.tracking.tracking import noisy, prepare, scored

PATHS = ("circle_h", "circle_v")  # at `SPEED`, noise of seed 0
SPEED, SLOW = 0.5, 0.05  # [m/s]
SHORT = 0.3  # [m] of the slow path
UNKNOWN, FAILED = 3, 4  # exit codes: a name is not known; control fails with the change
LONGEST = 2.0  # times the profile's time that a run may take


class Figures(NamedTuple):
    """What a change is judged by."""

    paths_mm: float  # cross-track RMS, the worst of `PATHS`
    governed_mm: float  # RMS, alike
    slow_mm_s: float  # RMS velocity error along the vertical at `SLOW`
    volts_s: float  # [V/s] mean of |dV/dt| of the busiest valve along `PATHS`
    cycles: list[int]  # pushes after which a valve does not come to rest, of each of `Trial.conditions`
    rest_mm: list[float]  # 95 % of the pushes come to rest nearer than this, alike


class Trial(NamedTuple):
    """What is to be tried."""

    machine: str
    changes: Changes
    pushes: int  # of each of the conditions
    conditions: list[tuple[float, float]]  # believed over true overlap; tilt [rad] that nobody knows


def tried(trial: Trial) -> Figures | None:
    """Return the figures of a trial from a process of its own; None if control failed in it.

    Raises:
        StudyError: a name is not known, or the process came to grief.
    """
    command = [sys.executable, "-m", "forest_study.ablation.trials"]
    done = subprocess.run(
        command, input=json.dumps(trial._asdict()), capture_output=True, text=True, check=False
    )
    if done.returncode == FAILED:
        return None
    if done.returncode != 0:
        raise StudyError(done.stderr.strip().splitlines()[-1])
    return Figures(*json.loads(done.stdout))


def figures(trial: Trial) -> Figures:
    """Return the figures of a trial in this process, whose constants change for good.

    Raises:
        StudyError: a name is not known.
        PathError: a path leaves the machine's reach.
    """
    settings = changed({name: _number(value) for name, value in trial.changes.items()})
    loop_kernel.runtime_numbers = at_runtime()
    machine = load_machine(trial.machine)
    driven = [_driven(path_named(name), SPEED, machine, settings) for name in PATHS]
    slow, _ = _driven(_middle(path_named("vertical")), SLOW, machine, settings)
    seeds = range(trial.pushes)
    left = [[pushed(machine, seed, *how, settings) for seed in seeds] for how in trial.conditions]
    errors = [sorted(one.error for one in rests) for rests in left]
    return Figures(
        paths_mm=max(score.cross_track_rms_mm for score, _ in driven),
        governed_mm=max(score.governed_rms_mm for score, _ in driven),
        slow_mm_s=1e3 * slow.velocity_rms,
        volts_s=max(busy for _, busy in driven),
        cycles=[sum(one.cycles for one in rests) for rests in left],
        rest_mm=[1e3 * those[math.ceil(0.95 * len(those)) - 1] for those in errors],
    )


def _driven(path: TipPath, speed: float, machine: Machine, settings: Settings) -> tuple[Score, float]:
    """Return a run's score, and how busy its busiest valve is [V/s]."""
    course = prepare(path, speed, Scheme.COORDINATED, machine)
    control = settings.control._replace(tip_speed=speed)
    rows = np.ones((round(LONGEST * len(course.places)), 4))
    start, suite = pose_at(course.start, machine), noisy(machine, 0)
    run = loop_kernel.prepared(machine, rows, start, control, settings.drive, suite=suite)
    led = run.lead(course.places, course.hand)
    return scored(course, led, machine).total, activity(led.moved.voltages)


def pushed(machine: Machine, seed: int, overlap: float, tilt: float, settings: Settings) -> Rest:
    """Return what is left of a push of a crane on a slope [rad], its overlap misjudged."""
    crane, given = machine.manipulator, push(machine, seed)
    sloped = dataclasses.replace(crane, platform_tilt=crane.platform_tilt + tilt)
    plant, model = dataclasses.replace(machine, manipulator=sloped), misjudged(machine, overlap)
    suite = noisy(plant, seed)
    return rest(loop_kernel.by_heart(plant, given.operator, END, given.start, *settings, model, suite))


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
    except (ArithmeticError, PathError, ValueError) as error:
        print(error, file=sys.stderr)
        sys.exit(FAILED)
