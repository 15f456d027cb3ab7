"""How far the joints' position loops are from instability with some gains, on the machine of the file.

The loops are those of `forest-study bode`, where the machine starts and at the paths' beginnings. What is no
gain is linearised once.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from forest_control.config.controller_settings import Settings
from forest_control.servo.gain_rule import AMPLIFICATION, servo_response
from forest_description.derived.limits import start_tip
from forest_description.machine import Machine
from forest_description.types import AXES, Complexes, Vec3
from forest_sim.simulation.open_loop import start_angles
from forest_study.results import StudyError
from forest_study.stability.bode_command import VOLTAGE
from forest_study.stability.margins import Margins, margins
from forest_study.stability.position_loop import FREQUENCY, position_loop


class Opened(NamedTuple):
    """A joint's plant at a pose."""

    axis: int
    rate: float  # [rad/s]
    plant: Complexes


def opened(machine: Machine, tips: Sequence[Vec3]) -> list[Opened]:
    """Return each joint's plant where the machine starts, and with the tip at other places [m].

    Raises:
        StudyError: a place is out of reach, or a valve stays shut at `VOLTAGE`.
    """
    found = []
    try:
        for tip in dict.fromkeys((start_tip(machine), *tips)):
            angles = start_angles(machine, tip)
            for axis in range(len(AXES)):
                loop = position_loop(machine, angles, axis, VOLTAGE, Settings())
                found.append(Opened(axis, loop.rate, loop.plant))
    except ValueError as error:
        raise StudyError(f"tune: {error}") from error
    return found


def worst(plants: Sequence[Opened], settings: Settings) -> dict[str, Margins]:
    """Return each joint's least margins over the poses."""
    s: Complexes = 2j * np.pi * FREQUENCY
    found: dict[str, Margins] = {}
    for axis, name in enumerate(AXES):
        gains = settings.feedback_gain[axis], settings.integral_gain[axis], settings.rate_gain[axis]
        loops = [
            margins(FREQUENCY, servo_response(*gains, axis, one.rate, s) * one.plant)
            for one in plants
            if one.axis == axis
        ]
        found[name] = max(loops, key=lambda loop: loop.sensitivity)
    return found


def sensitivity(plants: Sequence[Opened], settings: Settings) -> float:
    """Return the greatest |1/(1 + L)|; infinite where a loop does not keep its gain margin."""
    least = worst(plants, settings).values()
    return max(one.sensitivity if one.gain > 1.0 and one.phase > 0.0 else np.inf for one in least)


def allowed(plants: Sequence[Opened], rule: Settings) -> float:
    """Return the sensitivity that tuned gains may have: the rule's bound, or what the rule's gains have."""
    return max(AMPLIFICATION, sensitivity(plants, rule))
