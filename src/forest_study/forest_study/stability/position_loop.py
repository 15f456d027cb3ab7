"""The position loop of one joint in motion: controller, driver, valve, machine.

| symbol | name | unit |
|---|---|---|
| H | joint rate over spool position, `forest_sim.analysis.frequency_response` | rad/(s V) |
| D | spool position over commanded rate, S(s)/H(0) exp(-T s); the driver makes the gain one | s V/rad |
| F | rate that the driver takes off for the load that the spool makes, `load_feedback` | rad/(s V) |
| G | joint angle over commanded rate: H D/(1 + F D)/s | s |
| S | spool over voltage | |
| T | from a sample to the middle of the period in which its command acts | s |
| C | the servo of `coordinated`: K_p + K_i/s + D s, with the errors' low-pass in slow motion | 1/s |
| L | C G | |
"""

import math
from typing import NamedTuple

import numpy as np

from forest_control.config.controller_settings import Settings, with_rules
from forest_control.servo.gain_rule import servo_response
from forest_control.valve.valve_driver_parameters import Settings as DriverSettings
from forest_control.valve.valve_driver_parameters import axis_drivers
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import Machine
from forest_description.types import Complexes, Floats, Vec3
from forest_msgs_py.types import PERIOD
from forest_sim.analysis.frequency_response import Response, response_of, spool_response
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.spool_dynamics import spool_lag

LATE = 1.5 * PERIOD  # [s] T: a period from sample to voltage, and half of the one in which it holds
LOWEST, HIGHEST, COUNT = 0.02, 80.0, 3000  # [Hz], [Hz], frequencies
FREQUENCY: Floats = np.geomspace(LOWEST, HIGHEST, COUNT)


class PositionLoop(NamedTuple):
    """One joint at one pose."""

    rate: float  # [rad/s] of the joint, in whose motion the loop is looked at
    gains: Vec3  # K_p [1/s], K_i [1/s^2], D
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
    answer = response_of(angles, axis, voltage, plant_parameters(machine), FREQUENCY)
    s: Complexes = 2j * math.pi * FREQUENCY
    spool = spool_response(spool_lag(machine.valve_of(axis)), FREQUENCY)
    driven = spool / abs(answer.rate[0]) * np.exp(-LATE * s)
    given_way = _given_way(machine, angles, axis, answer, s)
    plant = answer.rate * driven / (1.0 + given_way * driven) / s
    told = with_rules(machine, settings)
    gains = told.feedback_gain[axis], told.integral_gain[axis], told.rate_gain[axis]
    return PositionLoop(
        answer.steady_rate, gains, plant, servo_response(*gains, axis, answer.steady_rate, s) * plant
    )


def _given_way(machine: Machine, angles: Vec3, axis: int, answer: Response, s: Complexes) -> Complexes:
    """Return F: what of the load stays, behind the driver's low-pass, takes nothing off."""
    driver, stays = axis_drivers(machine)[axis], 2.0 * math.pi * DriverSettings().load_bandwidth
    load = driver.displacement_1 * answer.pressure_1 - driver.displacement_2 * answer.pressure_2
    arm = 1.0 if axis == 0 else lever_arm(angles[axis], machine.linkages[axis - 1])
    rate: Complexes = driver.load_feedback / arm * load * s / (s + stays)
    return rate
