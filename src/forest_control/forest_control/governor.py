"""What the machine can and may do, applied to the whole wish at once.

One factor scales all joint rates together, so the tip slows down but keeps its direction. Moving away from a
limit is never slowed.

| symbol | name | unit |
|---|---|---|
| a | wished joint rates | rad/s |
| k | approach rate: allowed rate towards a joint limit per remaining angle | 1/s |
| alpha | the factor, 0..1 | |
"""

from enum import IntEnum
from typing import NamedTuple

Triple = tuple[float, float, float]

NEGLIGIBLE_RATE = 1e-6  # [rad/s] up to this a joint does not count as moving: rounding must not stop others


class Limit(IntEnum):
    """What holds the wish back."""

    NONE = 0
    RATE = 1
    JOINT = 2
    SINGULARITY = 3
    FLOW = 4  # of the pumps
    WALL = 5  # of the workspace
    RELEASED = 6  # nobody holds the deadman, or the joystick is lost


class GovernorParameters(NamedTuple):
    """Limits per joint, swing, boom, stick."""

    lower: Triple  # [rad], margin included
    upper: Triple  # [rad], margin included
    rates: Triple  # [rad/s]
    approach: Triple  # [1/s]


class Governed(NamedTuple):
    """The factor, and the limit that set it."""

    factor: float
    limit: Limit


def govern(angles: Triple, wished: Triple, p: GovernorParameters) -> Governed:
    """Return the factor 0..1 by which all wished joint rates [rad/s] must shrink at these angles [rad]."""
    governed = Governed(1.0, Limit.NONE)
    for joint in range(3):
        rate = wished[joint]
        if abs(rate) <= NEGLIGIBLE_RATE:
            continue
        room = p.upper[joint] - angles[joint] if rate > 0.0 else angles[joint] - p.lower[joint]
        towards_limit = max(0.0, p.approach[joint] * room)
        for allowed, limit in ((p.rates[joint], Limit.RATE), (towards_limit, Limit.JOINT)):
            if allowed < governed.factor * abs(rate):
                governed = Governed(allowed / abs(rate), limit)
    return governed
