"""What is taken back from the command of a joint that runs ahead of its reference.

A load that slips or drops, or a valve that lets more through than its file says, makes a joint faster than it
shall be. A servo that still makes up for what was lost before would throw the tip. So the command shrinks
with what the joint is too fast by. It shuts a valve, and turns none round.

| symbol | name | unit |
|---|---|---|
| u, a, v | commanded, reference and measured joint rate | rad/s |
| m | most: how fast the joint may go, 1.2 a and a little more | rad/s |

    u - k (v - m) where v is over m, and not below 0
"""

from forest_description.types import Vec3

OVER = 1.2  # [1] of a, that the joint may go: as the bound on the tip's speed after any fault
SPARE = 0.03  # [rad/s] beyond it: noise of a measured rate, and what brings a joint back to its reference
TAKEN = 2.0  # [1] k; chosen: with 3 the forwarder's boom stalls on a vertical circle


def taken_back(u: Vec3, a: Vec3, v: Vec3) -> Vec3:
    """Return commanded rates [rad/s] without what would speed up joints that run ahead.

    Args:
        u: that the servo commands [rad/s].
        a: reference rates [rad/s].
        v: measured rates [rad/s].
    """
    return _taken_back(u[0], a[0], v[0]), _taken_back(u[1], a[1], v[1]), _taken_back(u[2], a[2], v[2])


def _taken_back(u: float, a: float, v: float) -> float:
    return _left(u, a, v) if u >= 0.0 else -_left(-u, -a, -v)


def _left(u: float, a: float, v: float) -> float:
    """Return what is left of a rate u of at least 0."""
    ahead = v - OVER * max(0.0, a) - SPARE
    return u if ahead <= 0.0 else max(0.0, u - TAKEN * ahead)
