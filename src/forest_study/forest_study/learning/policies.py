"""Policies to compare with: functions of the observation alone, as a learnt one is.

| policy | actions | what it does |
|---|---|---|
| ours | tip | a hand asks for the ideal point's velocity and for what is missing; our controller obeys |
| resolved rates | joint, voltages | the same wish by the inverse Jacobian, as levers or voltages |
| random | any | uniform, drawn anew at each step |
| rest | any | zero |

As voltages, resolved rates know neither overlap nor load: a voltage is the rate by the joint's greatest.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from forest_description.geometry.kinematics import Links, joint_rates
from forest_description.types import Vec3
from forest_study.learning.driven_crane import JOINT_RATES, TIP_SPEED

GAIN = 2.0  # [1/s] wished speed per distance; chosen
BRAKE = 0.5  # [m/s^2] with which a target is approached, as the ramps of a path; chosen
FASTEST = 1.0  # [m/s] towards a target: the full levers' speed
TASK = 18  # where an observation's task begins
PATH = 33  # numbers of an observation with a path

Numbers = NDArray[np.float32]
Policy = Callable[[Numbers], Numbers]


def wish(observation: Numbers) -> Vec3:
    """Return the tip velocity [m/s] that a simple hand asks for."""
    seen = observation[TASK:].astype(np.float64)
    if len(observation) == PATH:
        asked = seen[3:6] + GAIN * seen[:3]
    else:
        distance = max(float(np.linalg.norm(seen)), 1e-9)
        asked = seen / distance * min(FASTEST, math.sqrt(2.0 * BRAKE * distance), GAIN * distance)
    x, y, z = asked.tolist()
    return x, y, z


def ours(observation: Numbers) -> Numbers:
    """Return the levers of a hand that our controller serves."""
    return (np.array(wish(observation)) / TIP_SPEED).astype(np.float32)


def resolved_rates(links: Links) -> Policy:
    """Return the policy of resolved rates, for actions joint and voltages."""

    def policy(observation: Numbers) -> Numbers:
        a, b, c = observation[:3].astype(np.float64).tolist()
        rates = joint_rates((a, b, c), wish(observation), links)
        return (np.array(rates) / JOINT_RATES).astype(np.float32)

    return policy


def random(seed: int) -> Policy:
    """Return the policy of chance."""
    chance = np.random.default_rng(seed)
    return lambda _: chance.uniform(-1.0, 1.0, 3).astype(np.float32)


def rest(_: Numbers) -> Numbers:
    """Return no action."""
    return np.zeros(3, np.float32)
