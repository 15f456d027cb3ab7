"""`forest-study sway`: how much the hanging head sways after a stop, with anti-sway and without.

A lever is deflected in full for a while, then let go, the deadman held on. What counts begins once the tip
rests: until then anti-sway still moves it.
"""

import argparse
import dataclasses
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_control.config import controller_settings
from forest_control.operator.levers import levers_for_tip_velocity
from forest_control.valve import valve_driver_parameters
from forest_description.derived.bodies import with_log
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import Machine, load_machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.runtime.command_line import add_machine_option, number
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_study.closed_loop import compiled_loop
from forest_study.results import StudyError, new_directory, require_llvm, write_json

WAYS: dict[str, Vec3] = {"to the left": (0.0, 1.0, 0.0), "inwards": (-1.0, 0.0, 0.0)}
BEFORE, AFTER = 0.3, 8.0  # [s] at rest before the lever is deflected, and after it is let go
RESTS = 0.02  # [m/s] of the tip: it rests when it is never faster again
CALM = math.radians(1.0)  # [rad] of sway that counts as none
LOG_LENGTH = 4.0  # [m]


class Run(NamedTuple):
    """What happened after a stop."""

    way: str
    anti_sway: bool
    tip_rests_s: float  # after the lever was let go
    sway_deg: float  # the greatest from then on
    head_rests_s: float  # after the lever was let go
    moved_m: float  # of the tip, from first to last
    time: Floats  # [N] s
    sway: Floats  # [N] rad

    def told(self) -> dict[str, object]:
        """Return the figures as JSON has them."""
        return {key: value for key, value in self._asdict().items() if key not in ("time", "sway")}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Give the verb its arguments."""
    add = parser.add_argument
    add_machine_option(parser, "loader")
    add(
        "--speed",
        type=number(0.05, 3.0, "m/s"),
        default=0.5,
        metavar="V",
        help="speed [m/s] (default: %(default)s)",
    )
    add(
        "--seconds",
        type=number(0.2, 10.0, "s"),
        default=1.5,
        metavar="T",
        help="time of deflection (default: %(default)s)",
    )
    text = "mass of the log [kg], unknown to the controller (default: the machine's own load)"
    add("--log", type=number(0.0, 1e4, "kg"), metavar="MASS", help=text)


def run(options: argparse.Namespace) -> int:
    """Print the table, and write `sway.json` and `sway.png`; return the exit code.

    Raises:
        StudyError: LLVM is not installed, or nothing hangs from the machine's tip.
    """
    require_llvm("sway")
    machine = load_machine(options.machine)
    if machine.manipulator.pendulum is None:
        raise StudyError(f"sway: nothing hangs from the tip of {machine.name}; allowed: manipulator.pendulum")
    crane = machine
    if options.log is not None:
        crane = dataclasses.replace(
            machine, manipulator=with_log(machine.manipulator, options.log, LOG_LENGTH)
        )
    new_directory(options.out)
    runs = [
        stopped(crane, machine, way, options.speed, options.seconds, on)
        for way in WAYS
        for on in (False, True)
    ]
    write_json(options.out / "sway.json", {"machine": machine.name, "runs": [one.told() for one in runs]})
    print(table(runs))
    print(f"  {draw(machine, runs, options.out / 'sway.png')}")
    return 0


def stopped(crane: Machine, model: Machine, way: str, speed: float, seconds: float, anti_sway: bool) -> Run:
    """Return what happened to the head.

    Args:
        crane: what is simulated.
        model: what controller and driver believe.
        way: one of `WAYS`.
        speed: of the tip [m/s].
        seconds: for which the lever is deflected.
        anti_sway: the controller's setting.
    """
    control = controller_settings.Settings(tip_speed=speed, anti_sway=anti_sway)
    x, y, z = WAYS[way]
    thrown, let_go = round(BEFORE / PERIOD), round((BEFORE + seconds) / PERIOD)
    levers = np.tile(np.array([0.0, 0.0, 0.0, 1.0]), (let_go + round(AFTER / PERIOD), 1))
    levers[thrown:let_go, :3] = levers_for_tip_velocity((speed * x, speed * y, speed * z), speed)
    start, drive = pose_at(start_tip(model), model), valve_driver_parameters.Settings()
    given = compiled_loop.prepared(model, levers, start, control, drive, plant=plant_parameters(crane))
    session, sway = compiled_loop.Session(given), []
    for row in range(len(levers)):
        session.advance(row + 1)
        sway.append(math.hypot(*session.head))
    places, swung = session.moved.tip, np.array(sway)
    velocity = np.linalg.norm(np.gradient(places, PERIOD, axis=0), axis=1)
    rests = _last(velocity > RESTS, let_go)
    return Run(
        way=way,
        anti_sway=anti_sway,
        tip_rests_s=PERIOD * (rests - let_go),
        sway_deg=math.degrees(swung[rests:].max()) if rests < len(swung) else math.nan,
        head_rests_s=PERIOD * (_last(swung > CALM, let_go) - let_go),
        moved_m=math.dist(places[0], places[-1]),
        time=PERIOD * np.arange(len(sway), dtype=np.float64) - BEFORE,
        sway=swung,
    )


def _last(rows: NDArray[np.bool_], first: int) -> int:
    """Return the row after the last one that is true, from a first one on."""
    found = np.flatnonzero(rows[first:])
    return first + (int(found[-1]) + 1 if len(found) else 0)


def table(runs: list[Run]) -> str:
    """Return the figures as a Markdown table."""
    lines = [
        "| way | anti-sway | moved, m | tip rests after, s | sway from then on, deg | head rests after, s |"
    ]
    lines.append("|---|---|---|---|---|---|")
    lines += [
        f"| {one.way} | {'on' if one.anti_sway else 'off'} | {one.moved_m:.2f} | {one.tip_rests_s:.2f} "
        f"| {one.sway_deg:.1f} | {one.head_rests_s:.2f} |"
        for one in runs
    ]
    return "\n".join(lines)


def draw(machine: Machine, runs: list[Run], path: Path) -> Path:
    """Draw the sway over time; return the picture's path."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(len(WAYS), 1, sharex=True, figsize=(7.0, 5.0), layout="constrained")
    for one in runs:
        plot = axes[list(WAYS).index(one.way)]
        plot.plot(one.time, np.degrees(one.sway), label=f"anti-sway {'on' if one.anti_sway else 'off'}")
        plot.set(title=f"{machine.name}, {one.way}", ylabel="sway, deg")
        plot.legend()
    axes[-1].set_xlabel("time, s")
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return path
