"""When a small command opens a valve: every opening crosses the overlap, and noise would do so for ever.

| symbol | name | unit |
|---|---|---|
| c | command of the ideal valve, with what leaks | V |
| z | hold zone: a steady command up to this leaves the valve shut | V |

A command that cannot be noise is motion: it is obeyed at once, and others for a while after. At rest a small
one opens the valve when its low-passed value is over the zone, and shuts it when that has gone back to a
quarter of the zone, or turned round.

An over-compensated inverse cannot open a valve a little: the actuator jumps, overshoots, is sent back, and so
on. So every time that a valve is opened the other way soon after it was shut or turned, its zone doubles, but
for the first time, up to `WIDEST` / 2 times; that fades in `FORGOTTEN` s, and at once in motion. What opens
again the same way is slow motion, unless it feeds what leaks. What is turned back within `BRIEF` is noise and
no cycle. An actuator that is held for as long has come to rest.
"""

import math
from typing import NamedTuple

OPENING_LAG, SHUTTING_LAG = 0.2, 0.02  # [s] of the low-passes that decide
SHUT_SHARE = 0.25  # of the zone
MOVING_SHARE = 0.2  # of the zone, in motion: a slow reversal must not wait
BRIEF, SOON = 0.05, 1.0  # [s] shut: briefer is noise or a reversal in motion
SURE = 14.0  # zones, a command that no cycle reaches
CALM = 0.5  # [s] without a command that must be motion: longer than a reversal takes
WIDEST, FORGOTTEN = 32.0, 5.0
MOST_HELD = 5.0  # zones that a motion may start late by
BARELY = 1e-9  # [V] of an open valve whose command's noise has turned round


class Hold(NamedTuple):
    """One valve's state."""

    slow: float  # c behind either low-pass [V]
    quick: float
    way: float  # 1, -1 open; 0 shut
    last: float  # way that it was open last
    turned_for: float  # [s] since it opened the other way than before
    shut_for: float  # [s]
    calm_for: float  # [s] since c was more than noise
    wide: float  # twice for every turn of a cycle


SHUT = Hold(slow=0.0, quick=0.0, way=0.0, last=0.0, turned_for=SOON, shut_for=SOON, calm_for=CALM, wide=1.0)


def obeyed(
    hold: Hold, c: float, zone: float, opens: float, noise: float, held: bool, learns: bool, dt: float
) -> tuple[Hold, float]:
    """Return the state a period of dt [s] on, and the command to obey: 0 where the valve shall stay shut.

    Args:
        hold: state.
        c: command [V]; 0 is none: shut.
        zone: z [V]; 0: every command is obeyed.
        opens: a steady command over this opens [V]; z, or less where leakage must be fed.
        noise: c up to this may be noise [V].
        held: nobody wishes any motion, c is leakage alone.
        learns: the overlap is being learnt, which ends a cycle: no motion need start late.
        dt: period [s].
    """
    wide = 1.0 + (hold.wide - 1.0) * math.exp(-dt / FORGOTTEN)
    calmed = dt * CALM / BRIEF if held else dt  # [s]
    turned_for, shut_for, calm_for = hold.turned_for + dt, hold.shut_for + dt, hold.calm_for + calmed
    if c == 0.0:
        return Hold(
            slow=0.0,
            quick=0.0,
            way=0.0,
            last=hold.last,
            turned_for=turned_for,
            shut_for=shut_for,
            calm_for=calm_for,
            wide=wide,
        ), 0.0
    stops = held and hold.calm_for < CALM  # what it moved at is past
    slow = c if stops else _passed(hold.slow, c, OPENING_LAG, dt)
    quick = _passed(hold.quick, c, SHUTTING_LAG, dt)
    most = 1.0 if learns else MOST_HELD
    widened = max(1.0, 0.5 * wide)  # once is no cycle
    least = widened * opens
    if abs(c) > max(1.5 * min(widened, most) * zone, noise) or zone == 0.0:
        calm_for = 0.0
    if abs(c) > max(SURE * zone, noise):
        wide = 1.0
    way = hold.way
    if calm_for < CALM:
        way = math.copysign(1.0, c) if abs(c) > MOVING_SHARE * zone else 0.0
    elif way != 0.0:
        way = way if way * quick >= SHUT_SHARE * least else 0.0
    elif abs(slow) > least:
        way = math.copysign(1.0, slow)
    if way == 0.0:
        shut_for = 0.0 if hold.way != 0.0 else shut_for
        return Hold(
            slow=slow,
            quick=quick,
            way=0.0,
            last=hold.last,
            turned_for=turned_for,
            shut_for=shut_for,
            calm_for=calm_for,
            wide=wide,
        ), 0.0
    turns = way * hold.last < 0.0
    # Opened the same way again, for a wish: slow motion, no cycle.
    again = hold.way == 0.0 and (turns or held) and BRIEF < shut_for < SOON
    if again or (turns and BRIEF < turned_for < SOON):
        wide = min(WIDEST, 2.0 * wide)
    turned_for = 0.0 if turns else turned_for
    obey = c if c * way > 0.0 else way * BARELY
    return Hold(
        slow=slow,
        quick=quick,
        way=way,
        last=way,
        turned_for=turned_for,
        shut_for=0.0,
        calm_for=calm_for,
        wide=wide,
    ), obey


def _passed(before: float, c: float, lag: float, dt: float) -> float:
    """Return the low-passed command [V]; the first after none counts whole."""
    return c if before == 0.0 else before + (1.0 - math.exp(-dt / lag)) * (c - before)
