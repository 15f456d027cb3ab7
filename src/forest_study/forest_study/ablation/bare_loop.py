"""The bare position loop at rest, simulated: without the mechanisms that keep it from cycling.

A process of its own does it; its standard input is a `Case` as JSON, its output what was `Seen`.
"""

import json
import math
import subprocess
import sys
from typing import NamedTuple

import numpy as np

from forest_control.operator.levers import REST, Levers
from forest_description.derived.limits import pose_at
from forest_description.machine import load_machine
from forest_description.types import Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_study.ablation.constants import Changes, changed
from forest_study.ablation.pushes import misjudged
from forest_study.closed_loop.closed_loop import Operator, run

BARE: Changes = {
    "config.controller_settings.HOLD_ERROR": 0.0,
    "config.controller_settings.RELEASE_ERROR": 0.0,
    "servo.inching.ARRIVED": 1e9,
    "valve_driver.hold_zone": 0.0,
    "valve_driver.adapt": False,
}
PUSHED, RELEASED, LOOKED, END = 0.5, 1.0, 6.0, 12.0  # [s]
PUSH = 0.3  # [1] of the lever
SLOWEST = 0.3  # [Hz] of a limit cycle: slower is the drift of the pose


class Case(NamedTuple):
    """What is simulated."""

    machine: str
    tip: Vec3  # [m]
    axis: int  # whose overlap is misjudged
    overlap: float  # believed over true


class Seen(NamedTuple):
    """What a joint does at rest."""

    frequency: float  # [Hz] of its greatest oscillation
    amplitude: float  # [rad] of the sine with its energy


def seen(case: Case) -> Seen:
    """Return what the joint does, simulated in a process of its own."""
    command, given = [sys.executable, "-m", "forest_study.ablation.bare_loop"], json.dumps(case._asdict())
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=True)
    return Seen(*json.loads(done.stdout))


def simulated(case: Case) -> Seen:
    """Return what the joint does; the constants of this process change for good."""
    settings, machine = changed(BARE), load_machine(case.machine)

    def operator(time: float) -> Operator:
        return Operator(Levers(PUSH, PUSH, PUSH) if PUSHED < time < RELEASED else REST)

    model, start = misjudged(machine, case.overlap, (case.axis,)), pose_at(case.tip, machine)
    moved = run(machine, operator, END, start, *settings, model=model)
    return _oscillation(moved.angles[round(LOOKED / PERIOD) :, case.axis])


def _oscillation(angle: Floats) -> Seen:
    spectrum = np.abs(np.fft.rfft((angle - angle.mean()) * np.hanning(len(angle))))
    frequency = np.fft.rfftfreq(len(angle), PERIOD)
    counted = frequency >= SLOWEST
    slow = np.fft.irfft(np.where(counted, 0.0, np.fft.rfft(angle)), len(angle))
    return Seen(
        float(frequency[counted][spectrum[counted].argmax()]), math.sqrt(2.0) * float((angle - slow).std())
    )


if __name__ == "__main__":
    print(json.dumps(simulated(Case(**json.load(sys.stdin)))))
