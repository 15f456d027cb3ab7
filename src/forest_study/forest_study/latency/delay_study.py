"""`forest-study delay`: tracking and stopping when the links are late: 0 to 600 ms.

Three ways to be late: the joystick's link with a hand that moves by heart, the same with a hand that corrects
by sight, and the machine's state on its way to the controller. People report that above 150 to 200 ms an
operator begins to notice and to wait (`THRESHOLD`); a loop that is closed by a machine feels much less.

The hand swings the tip from side to side (0.4 m/s, 0.4 Hz) and more slowly in depth and height; in full swing
it lets the deadman go. By sight it also wishes K times what the tip was off, as it was seen `REACTION` ago.
"""

import argparse
import math
from typing import Any, NamedTuple

import numpy as np

from forest_control.config import controller_settings
from forest_control.operator.levers import REST, levers_for_tip_velocity
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at, start_tip
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine, load_machine
from forest_description.types import Vec3
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.closed_loop import Links, Operator, Trajectory
from forest_study.closed_loop.closed_loop import run as run_loop
from forest_study.closed_loop.link_model import Quality
from forest_study.results import new_directory, write_json

DELAYS = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6)  # [s]
THRESHOLD = (0.15, 0.2)  # [s] what the literature on teleoperation names
WAYS = ("joystick", "by sight", "state")
SPEED = 0.5  # [m/s] at full deflection
BEGIN, RELEASE, END = 0.3, 4.9, 6.9  # [s]
ASIDE, UP = 0.4, 0.1  # [m/s]
RATE = 0.2  # [Hz] of depth and height; twice that from side to side
GAIN = 1.5  # K [1/s]
REACTION = 0.2  # [s]
STOPPED = 0.05  # [m/s]


class Score(NamedTuple):
    """What a delay costs."""

    rms_mm: float  # tip against where the hand wanted it
    max_mm: float
    stop_s: float  # from letting go to less than `STOPPED`
    stop_mm: float


def wished(time: float) -> Vec3:
    """Return the tip velocity [m/s] that the hand has in mind."""
    if not BEGIN <= time < RELEASE:
        return 0.0, 0.0, 0.0
    since = time - BEGIN
    swing = math.sin(2.0 * math.pi * RATE * since)
    return -UP * swing, ASIDE * math.sin(4.0 * math.pi * RATE * since), UP * swing


class Hand:
    """An operator who moves by heart, or corrects what was seen."""

    def __init__(self, tip: Vec3, machine: Machine, gain: float) -> None:
        self._links, self._gain = machine.manipulator.links, gain
        self._goal, self._tip = tip, tip
        self._off: list[Vec3] = [(0.0, 0.0, 0.0)] * (1 + round(REACTION / PERIOD))

    def watch(self, _time: float, angles: Vec3) -> None:
        """See where the tip is."""
        self._tip = tip_position(angles, self._links)

    def act(self, time: float) -> Operator:
        """Return what the hand does at a time [s]."""
        self._off.append(_plus(self._goal, self._tip, -1.0))
        wish = wished(time)
        self._goal = _plus(self._goal, wish, PERIOD)
        if not BEGIN <= time < RELEASE:
            return Operator(REST, time < RELEASE)
        back = self._off[-1 - round(REACTION / PERIOD)]
        return Operator(levers_for_tip_velocity(_plus(wish, back, self._gain), SPEED))


def _plus(a: Vec3, b: Vec3, factor: float) -> Vec3:
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


def session(way: str, quality: Quality, machine: Machine, seed: int = 0) -> Trajectory:
    """Run one session over a bad link."""
    tip = start_tip(machine)
    hand = Hand(tip, machine, GAIN if way == "by sight" else 0.0)
    links = Links(state=quality, seed=seed) if way == "state" else Links(joystick=quality, seed=seed)
    settings = controller_settings.Settings(tip_speed=SPEED)
    drive = valve_driver_parameters.Settings()
    start = pose_at(tip, machine)
    given = machine, hand.act, END, start, settings, drive
    return run_loop(*given, ways=links, watch=hand.watch, fast=True)


def score(moved: Trajectory) -> Score:
    """Return what a session was like."""
    goal = moved.tip[0] + PERIOD * np.cumsum([wished(float(t)) for t in moved.time], axis=0)
    released = round(RELEASE / PERIOD)
    error = np.linalg.norm(moved.tip - goal, axis=1)[:released]
    speed = np.linalg.norm(np.gradient(moved.tip, PERIOD, axis=0), axis=1)[released:]
    way = np.linalg.norm(moved.tip[released:] - moved.tip[released], axis=1)
    fast = np.flatnonzero(speed > STOPPED)
    stop = PERIOD * float(fast[-1] + 1) if len(fast) else 0.0
    return Score(
        1e3 * float(np.sqrt(np.mean(error**2))), 1e3 * float(error.max()), stop, 1e3 * float(way.max())
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parser.add_argument
    add("--machine", default="c180", help="shipped machine or file (default: %(default)s)")
    add("--jitter", type=float, default=0.0, metavar="S", help="largest extra delay (default: %(default)s s)")
    add("--loss", type=float, default=0.0, metavar="P", help="share of lost messages (default: %(default)s)")
    add("--seed", type=int, default=0, metavar="N", help="seed of jitter and loss (default: %(default)s)")


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        MachineError: the machine's file cannot be read.
        LinkError: jitter or loss are not allowed.
    """
    from forest_study.latency.delay_plot import draw

    machine = load_machine(options.machine)
    Quality(0.0, options.jitter, options.loss).checked()
    new_directory(options.out)
    report: dict[str, Any] = {"machine": machine.name, "jitter": options.jitter, "loss": options.loss}
    report["delays"] = list(DELAYS)
    for way in WAYS:
        qualities = [Quality(delay, options.jitter, options.loss) for delay in DELAYS]
        report[way] = [score(session(way, q, machine, options.seed))._asdict() for q in qualities]
    write_json(options.out / "delay.json", report)
    draw(report, options.out / "delay.png")
    print(table(report))
    print(f"  {options.out / 'delay.json'}")
    return 0


def table(report: dict[str, Any]) -> str:
    """Return a Markdown table: one row per delay."""
    lines = ["| delay, ms | " + " | ".join(f"{way}: RMS, mm | stop, s | stop, mm" for way in WAYS) + " |"]
    lines.append("|---" * (1 + 3 * len(WAYS)) + "|")
    for k, delay in enumerate(report["delays"]):
        cells = [f"{1e3 * delay:.0f}"]
        for way in WAYS:
            one = report[way][k]
            cells += [f"{one['rms_mm']:.0f}", f"{one['stop_s']:.2f}", f"{one['stop_mm']:.0f}"]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
