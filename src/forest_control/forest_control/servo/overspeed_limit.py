"""Overspeed limit: a joint that is faster than its reference is commanded little more than that reference.

A load that slips or drops, or a valve that lets more through than its file says, makes a joint faster than it
shall be. A servo that still makes up for what was lost before would throw the tip.

| symbol | name | unit |
|---|---|---|
| u, a, v | commanded, reference and measured joint rate | rad/s |
| m | most: 1.2 a and a little more | rad/s |

    u at most m where v is over m

The bound counts in the direction of u, and turns no valve round. It feeds v back by a switch alone: a share
of v - m, taken from u, makes the forwarder rock at 3 Hz.
"""

from forest_description.types import Vec3

OVER = 1.2  # [1] of a, that the joint may go: as the bound on the tip's speed after any fault
SPARE = 0.03  # [rad/s] beyond it: noise of a measured rate, and what brings a joint back to its reference


def without_overspeed(u: Vec3, a: Vec3, v: Vec3) -> Vec3:
    """Return commanded rates [rad/s] that do not speed up joints that run ahead.

    Args:
        u: that the servo commands [rad/s].
        a: reference rates [rad/s].
        v: measured rates [rad/s].
    """
    return _limited(u[0], a[0], v[0]), _limited(u[1], a[1], v[1]), _limited(u[2], a[2], v[2])


def _limited(u: float, a: float, v: float) -> float:
    return _bounded(u, a, v) if u >= 0.0 else -_bounded(-u, -a, -v)


def _bounded(u: float, a: float, v: float) -> float:
    """Return a rate u of at least 0, bounded."""
    most = OVER * max(0.0, a) + SPARE
    return min(u, most) if v > most else u
