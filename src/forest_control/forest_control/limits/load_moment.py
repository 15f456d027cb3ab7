"""The load-moment limit: how much of what the crane may lift it carries, and which motions that leaves.

The machine's file has the load that is allowed over the reach. What hangs under the tip is weighed
(`load_weighing`). At all of it only motions that unload pass; a machine whose file has no capacity has no
such limit. Where there is one, and nothing is weighed, the crane counts as fully loaded; not so near its
column that nothing can be weighed there.

| symbol | name | unit |
|---|---|---|
| m, m_a | mass of the load; what is allowed at the reach | kg |
| r | reach: distance of the tip from the swing axis | m |
| U | utilisation of the capacity, m / m_a | |
| r', z' | velocity of the tip outward and up | m/s |
| k | approach rate | 1/s |

A motion loads the crane by r' + max(0, z'): outward, and up as far as it does not go as much inward. Inward,
down at the same reach, and slewing are always free. What loads is no faster than k r (1/U - 1): where m_a
goes with 1/r that is k times the way to U = 1, so the tip comes to rest there. As along a wall the tip
slides: of a wish outward and down, down is left. Taught paths are kept, and joints scaled as a whole.
"""

import math
from typing import NamedTuple

from forest_control.limits.load_weighing import LEAST_LEVER
from forest_control.limits.workspace import NEGLIGIBLE_SPEED
from forest_description.geometry.kinematics import Links, tip_position, tip_velocity
from forest_description.geometry.vectors import norm, scaled
from forest_description.machine import Machine
from forest_description.mechanics.lifting_capacity import MOST_POINTS
from forest_description.types import Vec3

APPROACH = 1.0  # [1/s] k: the weighing lags by 1.1 s, and a quicker approach would overshoot; chosen
WARNED = 0.9  # [1] of U, from which a person is warned: usual of rated capacity limiters
BELIEVED = 1.25  # [1] greatest U that is believed: the static test of EN 12999; broken transducers read more


class Capacity(NamedTuple):
    """m_a over r; unused places repeat the last point."""

    reaches: tuple[float, ...]  # `MOST_POINTS` [m]
    loads: tuple[float, ...]  # [kg]; infinite: no limit


class Loading(NamedTuple):
    """What the crane carries."""

    mass: float = math.nan  # m [kg]; NaN: not weighed
    reach: float = math.nan  # r [m]
    allowed: float = math.inf  # m_a [kg]
    utilisation: float = 0.0  # U


NO_CAPACITY = Capacity((0.0,) * MOST_POINTS, (math.inf,) * MOST_POINTS)  # [m, kg]


def loading(mass: float, q: Vec3, links: Links, c: Capacity) -> Loading:
    """Return what a mass [kg], NaN if it is unknown, means at joint angles [rad]."""
    reach = abs(links.base_offset + links.boom * math.cos(q[1]) + links.stick * math.cos(q[1] + q[2]))
    allowed = allowed_load(reach, c)
    if allowed == math.inf:
        return Loading(mass, reach, allowed, 0.0)
    ahead = links.boom * math.cos(q[1]) + links.stick * math.cos(q[1] + q[2])
    unknown = 1.0 if ahead >= LEAST_LEVER else 0.0  # nearer, nothing can be weighed
    utilisation = unknown if math.isnan(mass) else max(0.0, mass) / allowed
    return Loading(mass, reach, allowed, utilisation)


def believed_mass(mass: float, head: float, q: Vec3, links: Links, c: Capacity) -> float:
    """Return a weighed mass [kg] within what can hang there; NaN, which is not known, stays.

    Args:
        mass: as weighed.
        head: of the empty head [kg]: what weighs less than nothing is at most that.
        q: joint angles [rad].
        links: of the crane.
        c: its capacity; without one any mass is believed.
    """
    most = BELIEVED * loading(mass, q, links, c).allowed
    return mass if math.isnan(mass) else max(-head, min(most, mass))


def allowed_load(reach: float, c: Capacity) -> float:
    """Return m_a [kg] at a reach [m]."""
    for i in range(MOST_POINTS - 1):
        near, far = c.reaches[i], c.reaches[i + 1]
        if reach < far:
            part = max(0.0, (reach - near) / (far - near))
            return c.loads[i] + part * (c.loads[i + 1] - c.loads[i])
    return c.loads[MOST_POINTS - 1]


def unloaded(p: Vec3, velocity: Vec3, load: Loading, keeps_path: bool) -> tuple[Vec3, float]:
    """Return what the load leaves of a tip velocity [m/s], and what is left of its size, 0..1.

    Args:
        p: place of the tip [m].
        velocity: of the tip.
        load: what the crane carries.
        keeps_path: the tip slows down on its path; else it slides, and only what loads is taken away.
    """
    r = math.sqrt(p[0] * p[0] + p[1] * p[1])
    c, s = (p[0] / r, p[1] / r) if r > 0.0 else (1.0, 0.0)
    outward, aside, up = c * velocity[0] + s * velocity[1], c * velocity[1] - s * velocity[0], velocity[2]
    speed, most = outward + max(0.0, up), allowed_speed(load)
    if speed <= max(most, NEGLIGIBLE_SPEED):
        return velocity, 1.0
    left = most / speed
    if keeps_path:
        return scaled(velocity, left), left
    if up <= 0.0:
        outward = most
    elif outward <= 0.0:
        up = most - outward
    else:
        outward, up = left * outward, left * up
    slid = c * outward - s * aside, s * outward + c * aside, up
    return slid, norm(slid) / norm(velocity)


def load_scale(q: Vec3, rates: Vec3, links: Links, load: Loading) -> float:
    """Return the factor 0..1 that the load leaves of joint rates [rad/s] at joint angles [rad]."""
    velocity = tip_velocity(q, rates, links)
    return unloaded(tip_position(q, links), velocity, load, keeps_path=True)[1]


def allowed_speed(load: Loading) -> float:
    """Return how fast a motion may load [m/s]."""
    if load.utilisation <= 0.0:  # an empty head weighs nothing
        return math.inf
    return max(0.0, APPROACH * load.reach * (1.0 / load.utilisation - 1.0))


def capacity(machine: Machine) -> Capacity:
    """Return a machine's capacity; without bound if its file tells none."""
    chart = machine.capacity
    if chart is None:
        return NO_CAPACITY
    unused = MOST_POINTS - len(chart.reach)
    return Capacity(
        (*chart.reach, *(chart.reach[-1],) * unused),
        (*chart.load, *(chart.load[-1],) * unused),
    )
