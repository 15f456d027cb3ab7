"""Limit cycles of a position loop whose driver takes the valve's overlap for wider, or narrower, than it is.

The driver jumps over the overlap that it believes in. What is left of its error stands between command and
valve, and for a sine of the command's amplitude A it acts like a gain, its describing function N(A):

| overlap thought | is | N(A) | limit cycle |
|---|---|---|---|
| too wide | a relay of height e beside the gain 1 | 1 + 4 e/(pi A) | where N L = -1 |
| too narrow | a dead zone of half width e | 1 - 2 (asin x + x sqrt(1 - x^2))/pi, x = e/A | none: N < 1 |

So a loop with the gain margin g cycles with A = 4 e/(pi (g - 1)), however small e is. The loop is that of a
valve as far open as the cycle itself opens it in the mean.
Slotine and Li, *Applied nonlinear control*, chapter 5.
"""

import math
from typing import NamedTuple

import numpy as np

from forest_control.config.controller_settings import Settings
from forest_description.derived.actuator_kinematics import rated_speeds
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_study.stability.margins import margins
from forest_study.stability.position_loop import FREQUENCY, position_loop

ROUNDS = 6  # of opening and cycle that depend on each other; the opening is then known to a few percent
LEAST_OPEN = 0.02  # [V] beyond the overlap: less is no motion that could be linearised


class LimitCycle(NamedTuple):
    """What a loop is told to do."""

    frequency: float  # [Hz]
    command: float  # A [rad/s] amplitude of the commanded joint rate
    angle: float  # [rad] of the joint


def relay(height: float, amplitude: float) -> float:
    """Return N of a gain of one beside a relay, for a sine of an amplitude in the relay's unit."""
    return 1.0 + 4.0 * height / (math.pi * amplitude)


def limit_cycle(
    machine: Machine, angles: Vec3, axis: int, surplus: float, settings: Settings
) -> LimitCycle | None:
    """Return the limit cycle of one joint, the others at rest; None where there is none.

    Args:
        machine: the plant.
        angles: pose [rad].
        axis: whose.
        surplus: believed minus true overlap [V].
        settings: of the controller.

    Raises:
        ValueError: the loop cannot be linearised there.
    """
    if surplus <= 0.0:
        return None
    valve = machine.valve_of(axis)
    arm = 1.0 if axis == 0 else abs(lever_arm(angles[axis], machine.linkages[axis - 1]))
    per_volt = rated_speeds(machine)[axis] / arm / (valve.rated_voltage - valve.deadband_voltage)
    height, volts = per_volt * surplus, surplus
    for _ in range(ROUNDS):
        loop = position_loop(machine, angles, axis, valve.deadband_voltage + volts, settings)
        found = margins(FREQUENCY, loop.controlled)
        if not 1.0 < found.gain < math.inf:
            return None
        command = 4.0 * height / (math.pi * (found.gain - 1.0))
        rate = relay(height, command) * command
        mean = 2.0 / math.pi * rate / per_volt  # [V] of a sine
        volts = max(LEAST_OPEN, 0.5 * (volts + mean))
    plant = abs(loop.plant[int(np.argmin(np.abs(FREQUENCY - found.gain_frequency)))])
    return LimitCycle(found.gain_frequency, command, float(plant * rate))
