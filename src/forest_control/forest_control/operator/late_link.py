"""A late link: the later an operator sees what the levers do, the slower they move the crane.

| symbol | name | unit |
|---|---|---|
| d | how much older a joystick's new sample is than the machine's state, low-passed | s |
| T | round trip, from a hand to what it sees of its motion: 2 d, the way back taken to be as late | s |

Up to `UNFELT` people move as if nothing were late. Beyond, they stop to see what came of it. The levers'
speed is then scaled by `UNFELT` / T: the tip goes no farther in a round trip than it went in `UNFELT`.

Both stamps are ROS time, so the clocks of joystick and machine must agree. A joystick's clock that is ahead,
or behind by more than `ANOTHER_CLOCK`, is another clock: nothing is known of the link, and nothing slows.
"""

import math
from typing import NamedTuple

from forest_control.operator.joystick_watch import NO_STAMP

UNFELT = 0.2  # [s] round trip from which operators begin to move and wait (literature on teleoperation)
LAG = 0.5  # [s] of the low-pass: one late sample is no late link; chosen
ANOTHER_CLOCK = 2.0  # [s] age that is no way's, but a difference of clocks, or a bag that is played; chosen


class LateLink(NamedTuple):
    """What is remembered of a joystick's link."""

    age: float = 0.0  # d [s]
    stamp: int = NO_STAMP  # [ns] of the newest sample
    since: float = 0.0  # [s] since it came


IN_TIME = LateLink()


def updated_link(before: LateLink, stamp: int, state: int, dt: float) -> LateLink:
    """Return the link after a state of the machine.

    Args:
        before: as it was.
        stamp: of the joystick's newest sample [ns].
        state: stamp of the machine's state [ns].
        dt: since the state before [s].
    """
    since = before.since + dt
    if stamp == before.stamp:
        return before._replace(since=since)
    age = 1e-9 * (state - stamp)
    if stamp == NO_STAMP or state == NO_STAMP or age < 0.0 or age > ANOTHER_CLOCK:
        age = 0.0
    return LateLink(before.age + (1.0 - math.exp(-since / LAG)) * (age - before.age), stamp, 0.0)


def round_trip(link: LateLink) -> float:
    """Return T [s]."""
    return 2.0 * link.age


def speed_scale(link: LateLink) -> float:
    """Return by what the speed of the levers is scaled, 0..1."""
    return UNFELT / max(UNFELT, round_trip(link))
