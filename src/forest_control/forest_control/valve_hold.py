"""When a small command opens a valve: every opening crosses the overlap, and noise would do so for ever.

| symbol | name | unit |
|---|---|---|
| c | command of the ideal valve, with what leaks | V |
| z | hold zone: a steady command up to this leaves the valve shut | V |

A command that cannot be noise is obeyed at once. A smaller one opens the valve when its low-passed value is
over the zone, and shuts it when that has gone back to a quarter of the zone, or turned round.

An over-compensated inverse cannot open a valve a little: the actuator jumps, overshoots, is sent back,
and so on. So a valve that small commands open again soon after it was shut has its zone doubled, up to
`WIDEST` times; in `FORGOTTEN` s of peace that fades.
"""

import math
from typing import NamedTuple

OPENING_LAG, SHUTTING_LAG = 0.1, 0.02  # [s] of the low-passes that decide
SHUT_SHARE = 0.25  # of the zone
SOON = 1.0  # [s] after shutting
WIDEST, FORGOTTEN = 16.0, 5.0
BARELY = 1e-9  # [V] of an open valve whose command's noise has turned round


class Hold(NamedTuple):
    """One valve's state."""

    slow: float = 0.0  # c behind either low-pass [V]
    quick: float = 0.0
    way: float = 0.0  # 1, -1 open; 0 shut
    shut_for: float = 0.0  # [s]
    wide: float = 1.0  # z over what is set


SHUT = Hold(0.0, 0.0, 0.0, SOON, 1.0)


def obeyed(hold: Hold, c: float, zone: float, noise: float, dt: float) -> tuple[Hold, float]:
    """Return the state a period of dt [s] on, and the command to obey: 0 where the valve shall stay shut.

    Args:
        hold: state.
        c: command [V]; 0 is none: shut.
        zone: z [V]; 0: every command is obeyed.
        noise: c up to this may be noise [V].
        dt: period [s].
    """
    wide = 1.0 + (hold.wide - 1.0) * math.exp(-dt / FORGOTTEN)
    if c == 0.0:
        return Hold(0.0, 0.0, 0.0, hold.shut_for + dt, wide), 0.0
    slow, quick = _passed(hold.slow, c, OPENING_LAG, dt), _passed(hold.quick, c, SHUTTING_LAG, dt)
    least = wide * zone
    if abs(c) > max(2.0 * least, noise) or zone == 0.0:
        return Hold(slow, quick, math.copysign(1.0, c), 0.0, wide), c
    way, shut_for = hold.way, hold.shut_for + dt
    if way != 0.0 and way * quick < SHUT_SHARE * least:
        way, shut_for = 0.0, 0.0
    elif way == 0.0 and abs(slow) > least:
        way = math.copysign(1.0, slow)
        if shut_for < SOON:
            wide = min(WIDEST, 2.0 * wide)
    if way == 0.0:
        return Hold(slow, quick, 0.0, shut_for, wide), 0.0
    return Hold(slow, quick, way, 0.0, wide), c if c * way > 0.0 else way * BARELY


def _passed(before: float, c: float, lag: float, dt: float) -> float:
    """Return the low-passed command [V]; the first after none counts whole."""
    return c if before == 0.0 else before + (1.0 - math.exp(-dt / lag)) * (c - before)
