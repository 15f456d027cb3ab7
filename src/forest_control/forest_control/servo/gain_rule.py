"""The gains of the coordinated scheme from the machine's file: as much as the oil's spring bears.

The rule takes the greatest K_p up to `HIGHEST_GAIN` whose loop stays away from -1 by 1/`AMPLIFICATION` in
every stated motion. K_i goes with its square.

| symbol | name | unit |
|---|---|---|
| s | complex frequency | 1/s |
| H | joint rate over commanded rate (`joint_response`) | 1 |
| S, T | spool over voltage; lateness: a period and a half, and the valve's dead time | 1, s |
| L | open loop, (K_p + K_i/s + D s) S H e^(-T s)/s | 1 |
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from forest_control.servo.joint_response import (
    ResponseModel,
    poses,
    rate_response,
    response_model,
    tip_radius,
)
from forest_control.servo.schemes import ERROR_LAG, FULL_RATE
from forest_description.machine import Machine
from forest_description.types import Complexes, Floats, Vec3
from forest_msgs_py.types import PERIOD

HIGHEST_GAIN = (4.0, 5.0, 5.0)  # [1/s] of K_p: the noise of a slow swing, unfiltered, crosses its overlap
STEP = 0.25  # [1/s] in which K_p is looked for, and the least: a twentieth of the highest
AMPLIFICATION = 1.8  # [1] greatest |1/(1 + L)|: at least 7 dB and 32 degrees, under the usual 2
INTEGRAL_SHARE = (0.08, 0.25, 0.25)  # [1] K_i over K_p^2: at a quarter slow poles meet; the swing lags more
SWING_DAMPING = 0.4  # [1] D where the swing bears it: only the swing rocks slowly
TIP_SPEEDS = 0.25, 0.5  # [m/s] of the tip by one joint alone: half and all of what a lever asks by default
FREQUENCY: Floats = np.geomspace(0.05, 30.0, 400)  # [Hz] from under the crossovers to over the spools


class JointGains(NamedTuple):
    """Per joint: swing, boom, stick."""

    feedback: Vec3  # K_p [1/s]
    integral: Vec3  # K_i [1/s^2]
    rate: Vec3  # D


@lru_cache(maxsize=16)  # a node that runs asks again whenever a parameter is set
def gains_by_rule(machine: Machine) -> JointGains:
    """Return the gains that a machine bears."""
    model = response_model(machine)
    plain = _feedback(model, 0, 0.0), _feedback(model, 1, 0.0), _feedback(model, 2, 0.0)
    # The damping of a swing whose spools are too slow for it would cost K_p.
    damped = _feedback(model, 0, SWING_DAMPING)
    feedback, damping = max((damped, SWING_DAMPING), (plain[0], 0.0))
    return JointGains(
        feedback=(feedback, plain[1], plain[2]),
        integral=(integral(feedback, 0), integral(plain[1], 1), integral(plain[2], 2)),
        rate=(damping, 0.0, 0.0),
    )


def integral(feedback: float, axis: int) -> float:
    """Return the K_i [1/s^2] that goes with a joint's K_p [1/s]."""
    return INTEGRAL_SHARE[axis] * feedback * feedback


def servo_response(
    feedback: float, integral_gain: float, damping: float, axis: int, rate: float, s: Complexes
) -> Complexes:
    """Return C of a joint: K_p + K_i/s + D s, errors of boom and stick low-passed in slow motion.

    Args:
        feedback: K_p [1/s].
        integral_gain: K_i [1/s^2].
        damping: D.
        axis: whose.
        rate: at which it moves [rad/s].
        s: [n] complex frequencies [1/s].
    """
    weight = min(1.0, (rate / FULL_RATE) ** 2)
    quick = 1.0 if axis == 0 else weight
    passed = quick + (1.0 - quick) / (1.0 + ERROR_LAG * s)
    response: Complexes = feedback * passed + integral_gain / s + damping * weight * s
    return response


def joint_plant(model: ResponseModel, q: Vec3, axis: int, rate: float) -> Complexes:
    """Return the joint's angle over its commanded rate, at `FREQUENCY` [s].

    Args:
        model: of the machine.
        q: pose [rad].
        axis: that moves, alone.
        rate: at which it moves [rad/s].
    """
    s: Complexes = 2j * math.pi * FREQUENCY
    valve = model.machine.valve_of(axis)
    late = np.exp(-(1.5 * PERIOD + (valve.dead_time or 0.0)) * s)
    response: Complexes = rate_response(model, q, axis, rate, s) * late / s
    if valve.spool_bandwidth is None:
        return response
    x = s / (2.0 * math.pi * valve.spool_bandwidth)
    return response / (1.0 + x if not valve.spool_damping else 1.0 + 2.0 * valve.spool_damping * x + x * x)


def _feedback(model: ResponseModel, axis: int, damping: float) -> float:
    """Return the greatest K_p [1/s] that all stated motions bear; gains below it are borne, too."""
    s: Complexes = 2j * math.pi * FREQUENCY
    motions = [
        (rate, joint_plant(model, q, axis, rate))
        for q in poses(model.machine)
        for rate in (speed / tip_radius(model.machine, q, axis) for speed in TIP_SPEEDS)
    ]
    borne = STEP
    while borne + STEP <= HIGHEST_GAIN[axis]:
        tried = borne + STEP
        for rate, plant in motions:
            loop = servo_response(tried, integral(tried, axis), damping, axis, rate, s) * plant
            if float(np.min(np.abs(1.0 + loop))) < 1.0 / AMPLIFICATION:
                return borne
        borne = tried
    return borne
