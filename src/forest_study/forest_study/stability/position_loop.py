"""The position loop of one joint in motion: controller, driver, valve, machine.

| symbol | name | unit |
|---|---|---|
| H | joint rate over spool position, `forest_sim.analysis.frequency_response` | rad/(s V) |
| G | joint angle over commanded rate: S(s) H(s)/H(0) exp(-T s)/s; the driver makes the gain one | s |
| S | spool over voltage | |
| T | from a sample to the middle of the period in which its command acts | s |
| C | the servo of `coordinated`: K_p + K_i/s + D s, with the errors' low-pass in slow motion | 1/s |
| L | C G | |
"""

import math
from typing import NamedTuple

import numpy as np

from forest_control.config.controller_settings import Settings
from forest_control.servo.coordinated_servo import ERROR_LAG
from forest_control.servo.schemes import FULL_RATE
from forest_description.machine import Machine
from forest_description.types import Complexes, Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.analysis.frequency_response import rate_response, spool_response
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.spool_dynamics import spool_lag

LATE = 1.5 * PERIOD  # [s] T: a period from sample to voltage, and half of the one in which it holds
LOWEST, HIGHEST, COUNT = 0.02, 80.0, 3000  # [Hz], [Hz], frequencies
FREQUENCY: Floats = np.geomspace(LOWEST, HIGHEST, COUNT)


class PositionLoop(NamedTuple):
    """One joint at one pose."""

    rate: float  # [rad/s] of the joint, in whose motion the loop is looked at
    plant: Complexes  # [n] G, at `FREQUENCY`
    controlled: Complexes  # [n] L


def position_loop(
    machine: Machine, angles: Vec3, axis: int, voltage: float, settings: Settings
) -> PositionLoop:
    """Return the loop of a joint in steady motion.

    Args:
        machine: the plant, and what the driver knows of it.
        angles: pose [rad].
        axis: that moves.
        voltage: of its spool [V].
        settings: of the controller.

    Raises:
        ValueError: the voltage leaves the valve shut.
    """
    rate, response = rate_response(angles, axis, voltage, plant_parameters(machine), FREQUENCY)
    s: Complexes = 2j * math.pi * FREQUENCY
    spool = spool_response(spool_lag(machine.valve_of(axis)), FREQUENCY)
    plant = spool * response / abs(response[0]) * np.exp(-LATE * s) / s
    return PositionLoop(rate, plant, servo(settings, axis, rate, s) * plant)


def servo(settings: Settings, axis: int, rate: float, s: Complexes) -> Complexes:
    """Return C of a joint.

    Args:
        settings: of the controller.
        axis: whose.
        rate: at which it moves [rad/s].
        s: [n] complex frequencies [1/s].
    """
    share = min(1.0, (rate / FULL_RATE) ** 2)
    quick = 1.0 if axis == 0 else share
    passed = quick + (1.0 - quick) / (1.0 + ERROR_LAG * s)
    proportional, integral = settings.feedback_gain[axis] * passed, settings.integral_gain[axis] / s
    response: Complexes = proportional + integral + settings.rate_gain[axis] * share * s
    return response
