"""How a machine answers its first commands: the rate of each joint, and the torque that bears its boom.

Where no cylinder is measured, these tell another machine's file. Its valves give far other rates than the
file says, though the driver allows for loads; or the pressures bear less than boom and stick alone weigh.

| symbol | name | unit |
|---|---|---|
| u, v | commanded and measured joint rate, both low-passed by `TOGETHER`, u by its spool's lag, too | rad/s |
| G | gain of a joint by least squares, integral of u v over that of u^2 | 1 |
| W, W_0 | torque of the boom's cylinder, and of the weight of boom and stick, over the way | N m rad |
| way | what the boom has gone up, and the swing either way, as commanded | rad |

Rates count once a joint was told for `SETTLES`, while its own does not grow and its command does not fall:
before, it speeds up, and its oil is pressed; after, it runs on. G is judged once a joint was told enough and
moves, W once the way is `FREE`; what has answered right is not asked again. A joint that stands is not
judged: it may be held; nor is one that goes back, which `machine_file_check` asks for its way. A boom that
stands or goes down proves no weight: it may lean on what lies below. What goes up, or swings, is free.
"""

import math
from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_control.limits.load_weighing import Pressures, own_weight
from forest_control.safety.overloaded_joint import commanded_rates
from forest_description.geometry.linkage import lever_arm
from forest_description.types import ZERO, Vec3

TOGETHER = 0.2  # [s] over the time in which a valve, and the oil behind it, answer
SETTLES = 0.5  # [s] one way: a swing at full speed has sped up, and a joint that took a load has come to rest
GROWS = 1.1  # [1] of its own low-pass, over which a rate still grows: at even acceleration for 2 s
FALLS = 1.25  # [1] of the command, from which its own low-pass tells that it falls; a servo takes some back
COMMANDED = 0.35  # [V] of an ideal valve for u, from which it counts: an overlap may be 0.15 V off the file's
TOLD = 8e-3  # [rad^2/s] of integral u^2 that judges, 0.1 rad/s for 0.8 s; the forwarder's oil fills till then
MOVED = 2e-3  # [rad^2/s] of integral v^2 that judges a joint that is too fast: a quarter of it
ASKED = 5e-4  # [rad^2/s] of integral u^2 of such a joint: at twice the rate it has `MOVED`
STIRRED = 5e-4  # [rad^2/s] of integral v^2 of a joint that does not stand
TRUE = 0.7  # [1] least squared correlation of u and v of a joint that is slow; one that stopped has less
SLOWEST, FASTEST = 0.4, 2.0  # [1] of G; 48 plants off their file by 40 % of gain gave 0.58 to 1.4
FREE = 0.03  # [rad] 0.2 m of the tip at 6 m: what starts to move has settled
LIGHTEST = 0.8  # [1] of W/W_0; an empty crane without its head gives 1, `loader` believed `c180` 0.4 to 0.65


class Answers(NamedTuple):
    """What a machine has answered."""

    commanded: Vec3 = ZERO  # u [rad/s]
    measured: Vec3 = ZERO  # v [rad/s]
    times: Vec3 = ZERO  # [s] for which each was told to go, one way
    squares: Vec3 = ZERO  # integral of u^2 [rad^2/s]
    products: Vec3 = ZERO  # of u v
    responses: Vec3 = ZERO  # of v^2
    way: float = 0.0  # [rad]
    borne: float = 0.0  # W [N m rad]
    weight: float = 0.0  # W_0 [N m rad]


NO_ANSWERS = Answers()


def answered(
    before: Answers, q: Vec3, u: Vec3, v: Vec3, pressures: Pressures, p: Parameters, dt: float
) -> Answers:
    """Return the answers after a sample.

    Args:
        before: as they were.
        q: measured joint angles [rad].
        u: joint rates that valves were opened for [rad/s]; zero of a shut one.
        v: measured joint rates [rad/s].
        pressures: in the boom's cylinder, head and rod side [Pa]; NaN: not measured.
        p: the controller's parameters.
        dt: since the last sample [s].
    """
    commanded = (
        _passed(before.commanded[0], u[0], p.speed_limits.axes[0].spool.lag, dt),
        _passed(before.commanded[1], u[1], p.speed_limits.axes[1].spool.lag, dt),
        _passed(before.commanded[2], u[2], p.speed_limits.axes[2].spool.lag, dt),
    )
    measured = (
        _passed(before.measured[0], v[0], 0.0, dt),
        _passed(before.measured[1], v[1], 0.0, dt),
        _passed(before.measured[2], v[2], 0.0, dt),
    )
    least = commanded_rates(q, (COMMANDED, COMMANDED, COMMANDED), p)
    times = (
        _commanded_for(before, commanded, least, 0, dt),
        _commanded_for(before, commanded, least, 1, dt),
        _commanded_for(before, commanded, least, 2, dt),
    )
    one, two, three = (
        _summed(before, commanded, measured, u, v, 0, dt),
        _summed(before, commanded, measured, u, v, 1, dt),
        _summed(before, commanded, measured, u, v, 2, dt),
    )
    after = before._replace(
        commanded=commanded,
        measured=measured,
        times=times,
        squares=(one[0], two[0], three[0]),
        products=(one[1], two[1], three[1]),
        responses=(one[2], two[2], three[2]),
    )
    return _weighed(after, q, u, v, pressures, p, dt)


def _weighed(
    before: Answers, q: Vec3, u: Vec3, v: Vec3, pressures: Pressures, p: Parameters, dt: float
) -> Answers:
    """Return the answers with the torque that bore the boom on its way up, and that of its weight."""
    c = p.weighing
    force = c.areas[0] * pressures[0] - c.areas[1] * pressures[1]
    way = dt * ((abs(v[0]) if u[0] * v[0] > 0.0 else 0.0) + (v[1] if u[1] > 0.0 and v[1] > 0.0 else 0.0))
    if before.way >= FREE or way == 0.0 or math.isnan(force):
        return before
    torque, head = lever_arm(q[1], c.linkage) * force, c.gravity * c.empty_head * _reach(q, p)
    return before._replace(
        way=before.way + way,
        borne=before.borne + torque * way,
        weight=before.weight + (own_weight(q, c) - head) * way,
    )


def _passed(before: float, x: float, lag: float, dt: float) -> float:
    """Return a rate [rad/s] behind the low-pass; lag: of what it passes before [s]."""
    return before + (1.0 - math.exp(-dt / (TOGETHER + lag))) * (x - before)


def _commanded_for(before: Answers, commanded: Vec3, least: Vec3, i: int, dt: float) -> float:
    """Return for how long a joint has been told to go one way [s], at the least rate that counts."""
    if abs(commanded[i]) < least[i] or commanded[i] * before.commanded[i] < 0.0:
        return 0.0
    return before.times[i] + dt


def _summed(
    before: Answers, commanded: Vec3, measured: Vec3, told: Vec3, rates: Vec3, i: int, dt: float
) -> tuple[float, float, float]:
    """Return the sums of one joint; as before if it has proven right, or is told less, grows or goes back."""
    squares, products, responses = before.squares[i], before.products[i], before.responses[i]
    u, v = commanded[i], measured[i]
    if min(squares, responses) > TOLD or before.times[i] < SETTLES or u * v < 0.0:
        return squares, products, responses
    if rates[i] * v > GROWS * v * v or FALLS * told[i] * u < u * u:
        return squares, products, responses
    return squares + u * u * dt, products + u * v * dt, responses + v * v * dt


def _reach(q: Vec3, p: Parameters) -> float:
    """Return how far the tip is from the boom's pivot, outward [m]."""
    return p.links.boom * math.cos(q[1]) + p.links.stick * math.cos(q[1] + q[2])


def is_of_another_rate(answers: Answers, i: int) -> bool:
    """Tell whether a joint moves far slower or faster than its file says."""
    squares, products, responses = answers.squares[i], answers.products[i], answers.responses[i]
    if responses > MOVED and squares > ASKED and products > FASTEST * squares:
        return True
    is_slow = squares > TOLD and responses > STIRRED and products < SLOWEST * squares
    return is_slow and products * products > TRUE * squares * responses


def gain(answers: Answers, i: int) -> float:
    """Return G of a joint that was told something."""
    return answers.products[i] / answers.squares[i]


def is_too_light(answers: Answers) -> bool:
    """Tell whether less bears the boom than boom and stick weigh."""
    return answers.way >= FREE and answers.borne < LIGHTEST * answers.weight
