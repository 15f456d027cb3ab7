"""Ends of a stroke: a stiff spring with a damper that pushes back and never pulls, and a cushion before it.

| symbol | name | unit (cylinder; swing) |
|---|---|---|
| x, u | actuator position, speed | m, m/s; rad, rad/s |
| F | force on the load | N; N m |

The thesis has none: its machine could turn its links through each other.
"""

import math
from typing import NamedTuple

GRIP_SPEED = 0.05
"""Speed [m/s; rad/s] whose damping force the spring has reached when the damper grips wholly."""


class EndStop(NamedTuple):
    """Where an actuator's travel ends, and how hard; a stiffness of zero leaves the stop out."""

    lower: float
    upper: float
    stiffness: float  # [N/m; N m/rad]
    damping: float  # [N s/m; N m s/rad], while in contact


NO_STOP = EndStop(-math.inf, math.inf, 0.0, 0.0)


def end_stop_force(position: float, speed: float, stop: EndStop) -> float:
    """Return the stop's force [N; N m], positive towards larger positions; zero off the ends.

    The damper grips over the first small part of the way in, or the force would jump when the
    piston arrives, and an implicit step that ends there would have no solution.
    """
    if position < stop.lower:
        return _push(stop.lower - position, -speed, stop)
    if position > stop.upper:
        return -_push(position - stop.upper, speed, stop)
    return 0.0


def _push(depth: float, inward: float, stop: EndStop) -> float:
    """Return the stop's force [N; N m], at least 0, at a depth [m; rad] and speed inwards [m/s; rad/s]."""
    return max(0.0, stop.stiffness * depth + _grip(depth, stop) * stop.damping * inward)


def _grip(depth: float, stop: EndStop) -> float:
    """Return the damper's share 0..1; it is whole where the spring alone holds a speed of `GRIP_SPEED`."""
    held = stop.damping * GRIP_SPEED
    spring = stop.stiffness * depth
    return spring / held if spring < held else 1.0


def end_stop_resistance(position: float, speed: float, stop: EndStop, step: float) -> float:
    """Return -dF/du [N s/m; N m s/rad] when the position moves with the speed over an implicit step [s]."""
    if end_stop_force(position, speed, stop) == 0.0:
        return 0.0
    below = position < stop.lower
    depth, inward = (stop.lower - position, -speed) if below else (position - stop.upper, speed)
    grip = _grip(depth, stop)
    tightening = inward / GRIP_SPEED if grip < 1.0 else 0.0
    return grip * stop.damping + step * stop.stiffness * (1.0 + tightening)


class CushionBrake(NamedTuple):
    """Throttles before both ends of a stroke; a resistance of zero leaves them out."""

    lower: float  # where the stroke ends
    upper: float
    length: float  # over which they work, before each end [m]
    resistance: float  # at the very end [N s^2/m^2]


UNCUSHIONED = CushionBrake(-math.inf, math.inf, 1.0, 0.0)


def cushion_resistance(position: float, speed: float, c: CushionBrake) -> float:
    """Return r in F = -r u|u| [N s^2/m^2], which goes with the depth squared; out, the piston moves freely.

    Args:
        position: x [m].
        speed: u [m/s].
        c: the cushions.
    """
    if c.resistance == 0.0:
        return 0.0
    left = position - c.lower if speed < 0.0 else c.upper - position
    depth = min(1.0, max(0.0, 1.0 - left / c.length))
    return c.resistance * depth * depth
