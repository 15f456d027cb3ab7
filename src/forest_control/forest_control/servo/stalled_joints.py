"""Stalled joints: they stand although they shall go, all at once.

No voltage reaches the spools, or they have no oil. A reference that went on would be made up for once the
joints come free, and throw the tip. So it keeps near joints that have gone before and stand. A load, or a
limit of one valve, holds one joint while others go: that one may need a wider valve, and keeps its reference.

| symbol | name | unit |
|---|---|---|
| a, v | reference and measured joint rate; v low-passed by `ERROR_LAG` | rad/s |
| r, s | reference and measured angle | rad |

Not kept: the reference of joints that have not gone since they rested. Their overlap may be wider than
believed, and only a servo whose error grows brings them over it; `safety.overloaded_joint` ends that.
One that has hopped, as its spool swung over the edge, has not gone.
"""

import math
from typing import NamedTuple

from forest_control.servo.schemes import ERROR_LAG
from forest_description.types import Vec3

STALLED = 0.4  # [1] of a, within which it stands; at a half a weak valve's joint would, too
SLOW = 5e-3  # [rad/s] of a joint that need not be asked: 30 mm/s of the tip at 6 m
NEAR = 2e-3  # [rad] that a reference is ahead, and a joint has gone: no more than 0.01 rad/s of the servo's


class JointMotion(NamedTuple):
    """How one joint goes."""

    rate: float = 0.0  # v, low-passed [rad/s]
    gone: float = 0.0  # its way since its reference rested or turned round, along that; 0: against [rad]


def updated_motion(before: JointMotion, a: float, v: float, dt: float) -> JointMotion:
    """Return how a joint goes after dt [s] at a reference rate a and a measured rate v [rad/s]."""
    rate = before.rate + (1.0 - math.exp(-dt / ERROR_LAG)) * (v - before.rate)
    gone = (before.gone if before.gone * a > 0.0 else 0.0) + rate * dt
    return JointMotion(rate, gone if gone * a > 0.0 else 0.0)


def is_stalled(motion: JointMotion, a: float) -> bool:
    """Tell whether a joint has gone at its reference rate a [rad/s], and stands now."""
    return motion.gone * a > NEAR * abs(a) and abs(motion.rate) < STALLED * abs(a)


def is_slow(a: float) -> bool:
    """Tell whether a reference rate [rad/s] is so small that its joint need not be asked."""
    return abs(a) < SLOW


def kept_near(r: Vec3, a: Vec3, s: Vec3) -> Vec3:
    """Return reference angles [rad] that go on at rates a [rad/s], near to measured angles s [rad]."""
    return _kept_near(r[0], a[0], s[0]), _kept_near(r[1], a[1], s[1]), _kept_near(r[2], a[2], s[2])


def _kept_near(r: float, a: float, s: float) -> float:
    return s + math.copysign(NEAR, a) if is_ahead(a, r - s) else r


def is_ahead(a: float, e: float) -> bool:
    """Tell whether a reference is too far ahead of a joint that stands, by e = r - s [rad]."""
    return e * a > NEAR * abs(a)
