"""`forest-study track`: the tip along a path, closed loop, and how far it was from where it should be.

The reference generator plays the operator: it wishes the tip velocity of the fastest profile along the path.
The machine may be another one than controller and driver believe. The error is the true tip minus the
governed reference at every sample from the reference's first motion to its last; the reference starts where
the tip is at the first motion.
"""

import argparse
import dataclasses
import json
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_control import controller, valve_driver
from forest_control.governor import govern
from forest_control.levers import levers_for_tip_velocity
from forest_control.schemes import LABELS, Scheme, scheme_named
from forest_description.kinematics import inverse_kinematics, is_singular, joint_rates
from forest_description.machine import Machine, load_machine
from forest_sim.sensor_suite import Suite, sensor_suite
from forest_study.closed_loop import PERIOD, Operator, Trajectory
from forest_study.closed_loop import run as run_loop
from forest_study.paths import (
    NAMES,
    PathError,
    Profile,
    TipPath,
    fastest,
    is_closed,
    path_named,
    reverse,
)

Triple = tuple[float, float, float]
Floats = NDArray[np.float64]

RAMP = 0.5  # [m/s^2]
REST = 1.0  # [s] before the first lap and after every lap
RESERVE = 0.98  # of the governor's limits that the profile takes, so that the governor need not act
SATURATED = 0.999  # of the rated voltage


class Lap(NamedTuple):
    """A lap's start [s], its path and its profile."""

    start: float
    path: TipPath
    profile: Profile


class Score(NamedTuple):
    """How well a lap was tracked."""

    rms_mm: float
    max_mm: float
    velocity_rms: float  # [m/s]
    duration_s: float
    saturated_s: float


@dataclasses.dataclass(frozen=True)
class Session:
    """A track run: laps, what happened, scores."""

    laps: tuple[Lap, ...]
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

    Raises:
        PathError: the path leaves the reach.
    """
    settings = controller.Settings(scheme=scheme, tip_speed=speed)
    runs = plan(path, speed, controller.parameters(model, settings), laps)
    start = _angles(path.at(0.0), path, machine)
    end = runs[-1].start + runs[-1].profile.duration + REST
    moved = run_loop(
        machine,
        lambda time: Operator(levers_for_tip_velocity(_wish(time, runs), speed)),
        *(end, start, settings, valve_driver.Settings(adapt=adapt), model, suite),
    )
    rated = np.array([machine.valve_of(axis).rated_voltage for axis in range(3)])
    spans = [_span(lap) for lap in runs]
    first = spans[0][0]
    scores = tuple(_score(moved, first, np.arange(*span), rated) for span in spans)
    total = _score(moved, first, np.concatenate([np.arange(*span) for span in spans]), rated)
    return Session(runs, moved, scores, total)


def plan(path: TipPath, speed: float, p: controller.Parameters, laps: int) -> tuple[Lap, ...]:
    """Return laps one after the other, as fast as speed, ramps and the governor's limits allow."""
    runs: list[Lap] = []
    start = REST
    for k in range(laps):
        way = path if k % 2 == 0 or is_closed(path) else reverse(path)
        profile = fastest(way, speed, RAMP, lambda place, along: RESERVE * _limit(place, along, path, p))
        runs.append(Lap(start, way, profile))
        start = PERIOD * math.ceil((start + profile.duration + REST) / PERIOD)
    return tuple(runs)


def _limit(place: Triple, along: Triple, path: TipPath, p: controller.Parameters) -> float:
    """Return the speed [m/s] that the governor allows at a place in a direction."""
    try:
        angles = inverse_kinematics(place, p.links)
    except ValueError as error:
        raise PathError(f"{path.name}: {error}") from error
    factor = 0.0 if is_singular(angles, p.links) else _allowed(angles, along, p)
    if factor <= 0.0:
        raise PathError(f"{path.name}: at {tuple(round(x, 3) for x in place)} m a joint is at its limit")
    return factor


def _allowed(angles: Triple, along: Triple, p: controller.Parameters) -> float:
    fast = 100.0  # [m/s] more than any limit: what the governor leaves of it is the limit
    rates = joint_rates(angles, (fast * along[0], fast * along[1], fast * along[2]), p.links)
    return fast * govern(angles, rates, controller.governor_at(angles, rates, p)).factor


def _angles(place: Triple, path: TipPath, machine: Machine) -> Triple:
    try:
        return inverse_kinematics(place, machine.manipulator.links)
    except ValueError as error:
        raise PathError(f"{path.name}: {error}") from error


def _wish(time: float, laps: tuple[Lap, ...]) -> Triple:
    """Return the velocity [m/s] that moves the reference to its place one period later."""
    lap = next((lap for lap in reversed(laps) if time >= lap.start - 0.5 * PERIOD), laps[0])
    since = time - lap.start
    here, there = (lap.path.at(lap.profile.way_at(since + ahead)) for ahead in (0.0, PERIOD))
    x, y, z = ((b - a) / PERIOD for a, b in zip(here, there, strict=True))
    return x, y, z


def _span(lap: Lap) -> tuple[int, int]:
    """Return first and last row (exclusive) of a lap's motion."""
    return round(lap.start / PERIOD), math.ceil((lap.start + lap.profile.duration) / PERIOD) + 1


def _score(moved: Trajectory, first: int, rows: NDArray[np.int_], rated: Floats) -> Score:
    """Return the score of some rows; the reference starts where the tip is at the first motion of all."""
    error = moved.tip_error()
    error = np.linalg.norm(error - error[first], axis=1)[rows]
    velocity = np.gradient(moved.tip, PERIOD, axis=0) - moved.tip_wish
    saturated = np.any(np.abs(moved.voltages[rows]) >= SATURATED * rated, axis=1)
    return Score(
        rms_mm=1e3 * float(np.sqrt(np.mean(error**2))),
        max_mm=1e3 * float(error.max()),
        velocity_rms=float(np.sqrt(np.mean(np.sum(velocity[rows] ** 2, axis=1)))),
        duration_s=PERIOD * (len(rows) - 1),
        saturated_s=PERIOD * float(saturated.sum()),
    )


def noisy(machine: Machine, seed: int, static_errors: bool = False) -> Suite:
    """Return sensors that jitter; without their static errors, which calibration takes out, unless asked."""
    suite = sensor_suite(machine, noise=True, seed=seed)
    if static_errors:
        return suite
    return suite._replace(channels=tuple(c._replace(bias=0.0, gain=1.0) for c in suite.channels))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parser.add_argument
    add("--path", required=True, help=f"{', '.join(NAMES)}, all, or a CSV of waypoints x,y,z [m]")
    add("--speed", type=_speed, default=0.5, metavar="V", help="m/s (default: %(default)s)")
    add("--scheme", choices=[label for label in LABELS if label != "joint"], default="coordinated")
    add("--machine", default="c180", help="what is simulated: shipped machine or file (default: %(default)s)")
    add("--model", help="what controller and driver believe (default: the machine)")
    add("--noise", action="store_true", help="sensors jitter")
    add("--static-errors", action="store_true", help="with --noise: uncalibrated sensors")
    add("--seed", type=int, default=0, metavar="N", help="of the first run (default: %(default)s)")
    add("--seeds", type=_count, default=1, metavar="N", help="runs per path (default: %(default)s)")
    add("--adapt", action="store_true", help="the valve driver learns deadbands and gains on the way")
    add("--laps", type=_count, default=1, metavar="N", help="default: %(default)s")


def _speed(text: str) -> float:
    value = float(text)
    if not 0.01 <= value <= 3.0:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: 0.01 .. 3 m/s")
    return value


def _count(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: 1 .. 1000")
    return value


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        PathError: the path cannot be read or followed.
        MachineError: a machine's file cannot be.
    """
    from forest_study.cli import new_directory  # which imports this module

    machine = load_machine(options.machine)
    model = load_machine(options.model) if options.model else machine
    paths = [path_named(name) for name in (NAMES if options.path == "all" else (options.path,))]
    new_directory(options.out)
    report = _run_all(paths, machine, model, options)
    (options.out / "track.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    print(table(report))
    print(f"  {options.out / 'track.json'}")
    return 0


def _run_all(
    paths: list[TipPath], machine: Machine, model: Machine, options: argparse.Namespace
) -> dict[str, Any]:
    """Return the report of every path and seed, and draw every path's first run."""
    from forest_study.track_picture import draw  # matplotlib takes half a second

    report: dict[str, Any] = {
        "machine": machine.name,
        "model": model.name,
        "scheme": options.scheme,
        "speed": options.speed,
        "adapt": options.adapt,
        "noise": options.noise,
        "static_errors": options.static_errors,
        "runs": [],
    }
    for path in paths:
        for seed in range(options.seed, options.seed + options.seeds):
            suite = noisy(machine, seed, options.static_errors) if options.noise else None
            scheme = scheme_named(options.scheme)
            session = track(path, options.speed, scheme, machine, model, suite, options.laps, options.adapt)
            laps = [score._asdict() for score in session.scores]
            report["runs"].append({"path": path.name, "seed": seed, **session.total._asdict(), "laps": laps})
            if seed == options.seed:
                draw(session, options.out / f"{path.name}.png")
    return report


def table(report: dict[str, Any]) -> str:
    """Return a Markdown table: per path, and lap if several, mean RMS and greatest error of all runs."""
    lines = ["| path | RMS, mm | max, mm | velocity RMS, m/s | duration, s | saturated, s |"]
    lines.append("|---|---|---|---|---|---|")
    for name in dict.fromkeys(run["path"] for run in report["runs"]):
        of = [run for run in report["runs"] if run["path"] == name]
        laps = len(of[0]["laps"])
        if laps == 1:
            lines.append(_row(name, of))
        else:
            lines += [_row(f"{name}, lap {k + 1}", [run["laps"][k] for run in of]) for k in range(laps)]
    return "\n".join(lines)


def _row(name: str, scores: list[dict[str, Any]]) -> str:
    mean = {key: sum(score[key] for score in scores) / len(scores) for key in Score._fields}
    greatest = max(score["max_mm"] for score in scores)
    return (
        f"| {name} | {mean['rms_mm']:.2f} | {greatest:.1f} | {mean['velocity_rms']:.4f} "
        f"| {mean['duration_s']:.2f} | {mean['saturated_s']:.2f} |"
    )
