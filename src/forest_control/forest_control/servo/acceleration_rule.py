"""The acceleration of the coordinated scheme's reference from the machine's file: what does not overshoot.

A ramp that is shorter than a period of the oil's spring leaves the joint rocking on it. The rule takes the
shortest ramp to `TIP_SPEED` after which no joint alone exceeds its rate by more than `OVERSHOOT`.

| symbol | name | unit |
|---|---|---|
| H | joint rate over commanded rate (`joint_response`), the outlet emptied by a rest | 1 |
| w | angular frequency | rad/s |
| R | ramp of duration T over a step, sin(w T/2)/(w T/2) e^(-j w T/2) | 1 |
| y | answer to the ramp, (2/pi) times the integral of Re(H R) sin(w t)/w over w | 1 |

Feedforward and feedback are left out: what a machine file tells wrongly, they tell wrongly, too.
"""

import math
from functools import lru_cache

import numpy as np

from forest_control.servo.joint_response import poses, rate_response, response_model, tip_radius
from forest_description.machine import Machine
from forest_description.types import Complexes, Floats

TIP_SPEED = 0.5  # [m/s] to which the ramp goes: what a lever asks by default
OVERSHOOT = 0.2  # [1] of the speed: an operator's bound, 1.2 times the wish
HIGHEST_ACCELERATION = 4.0  # [m/s^2] as fast as a hand: no machine needs more; chosen
LONGEST = 1.0  # [s] of a ramp: beyond, an operator waits; chosen
STEP = 0.01  # [s] in which the ramp is looked for
FREQUENCY: Floats = np.geomspace(0.05, 30.0, 400)  # [Hz] from under the slowest mode to over the spools
TIME: Floats = np.arange(0.0, 2.0, 0.01)  # [s] after the ramp's begin, in which it overshoots
WAVES: Floats = np.sin(np.outer(2.0 * math.pi * FREQUENCY, TIME))  # [1] of every frequency


def acceleration_by_rule(machine: Machine, speed: float) -> float:
    """Return the greatest acceleration of the tip [m/s^2] at a full lever's speed [m/s].

    A faster tip has as long a ramp: its wider valves damp more. A slower one overshoots by no more m/s.
    """
    return min(HIGHEST_ACCELERATION, max(speed, TIP_SPEED) / ramp_time(machine))


@lru_cache(maxsize=16)  # a node that runs asks again whenever a parameter is set
def ramp_time(machine: Machine) -> float:
    """Return how long a ramp to `TIP_SPEED` lasts after which no joint overshoots [s]."""
    model, s = response_model(machine), 2j * math.pi * FREQUENCY
    answers = np.array(
        [
            rate_response(model, q, axis, speed / tip_radius(machine, q, axis), s, emptied=True)
            for q in poses(machine)
            for axis in range(3)
            for speed in (TIP_SPEED, -TIP_SPEED)
        ]
    )
    for duration in np.arange(TIP_SPEED / HIGHEST_ACCELERATION, LONGEST, STEP):
        if overshoot(answers, duration) <= OVERSHOOT:
            return float(duration)
    return LONGEST


def overshoot(answers: Complexes, duration: float) -> float:
    """Return by how much of its speed the fastest of some joints exceeds a ramp's end.

    Args:
        answers: H at `FREQUENCY` [joints, 400].
        duration: of the ramp [s].
    """
    w = 2.0 * math.pi * FREQUENCY
    ramp = np.sinc(FREQUENCY * duration) * np.exp(-0.5j * w * duration)
    parts = 2.0 / math.pi * (answers * ramp).real * np.gradient(w) / w
    followed = 2.0 / math.pi * w[0] * TIME  # below the first frequency
    # Not by BLAS: on a busy computer its threads wait for one another, 27 ms for 1.
    return float((np.einsum("ij,jk->ik", parts, WAVES) + followed).max()) - 1.0
