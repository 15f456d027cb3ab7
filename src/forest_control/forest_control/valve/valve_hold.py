"""The hold of a valve: when a small command opens it. Noise would cross the overlap for ever.

| symbol | name | unit |
|---|---|---|
| c | command of the ideal valve, with what leaks | V |
| z | hold zone: a steady command up to this leaves the valve shut | V |

A command that cannot be noise is motion. It passes at once, and so do others for a while after. At
rest a small command opens the valve when its low-passed value is over the zone. It shuts the valve
when that value has gone back to a quarter of the zone, or turned round.

An over-compensated inverse cannot open a valve a little: the actuator jumps, overshoots, is sent
back, and so on. So every time that a valve is opened the other way soon after it was shut or
turned, its zone doubles.

- The first time does not count. The zone grows up to `WIDEST` / 2 times.
- It shrinks again in `FORGOTTEN`, and at once in motion.
- What opens again the same way is slow motion, unless it feeds leakage.
- What is turned back within `BRIEF` is noise and no cycle.
- An actuator that is held for `BRIEF` has come to rest.
"""

import math
from typing import NamedTuple

OPENING_LAG = 0.2  # [s] of the low-pass that decides about opening: noise averages out; chosen
SHUTTING_LAG = 0.02  # [s] of the low-pass that decides about shutting: four periods; chosen
SHUT_SHARE = 0.25  # [1] of the zone at which a valve shuts: hysteresis against chatter; chosen
MOVING_SHARE = 0.2  # [1] of the zone that opens in motion: a slow reversal must not wait
BRIEF = 0.05  # [s] shut for less: noise, or a reversal in motion; ten periods
SOON = 1.0  # [s] after which an opening the other way is no cycle; chosen, not measured
SURE = 14.0  # [1] zones of a command that no cycle reaches; chosen, not measured
CALM = 0.5  # [s] without a command that must be motion: longer than a reversal takes
WIDEST = 32.0  # [1] greatest factor of the zone, doubled: five turns of a cycle; chosen
FORGOTTEN = 5.0  # [s] time constant with which the zone shrinks again; chosen, not measured
MOST_HELD = 5.0  # [1] zones that a motion may start late by; chosen, not measured
BARELY = 1e-9  # [V] command of an open valve whose noise has turned round: it stays where it is


class HoldState(NamedTuple):
    """One valve's state."""

    slow: float = 0.0  # c behind either low-pass [V]
    quick: float = 0.0
    way: float = 0.0  # 1, -1 open; 0 shut
    last: float = 0.0  # way that it was open last
    turned_for: float = SOON  # [s] since it opened the other way than before
    shut_for: float = SOON  # [s]
    calm_for: float = CALM  # [s] since c was more than noise
    wide: float = 1.0  # twice for every turn of a cycle


SHUT = HoldState()


def held_command(
    hold: HoldState, c: float, zone: float, opens: float, noise: float, held: bool, learns: bool, dt: float
) -> tuple[HoldState, float]:
    """Return the state a period of dt [s] on, and the command that passes: 0 where the valve shall stay shut.

    Args:
        hold: state.
        c: command [V]; 0 is none: shut.
        zone: z [V]; 0: every command passes.
        opens: a steady command over this opens [V]; z, or less where leakage must be fed.
        noise: c up to this may be noise [V].
        held: no motion is commanded, c is leakage alone.
        learns: the overlap is adapted, which ends a cycle: no motion need start late.
        dt: period [s].
    """
    wide = 1.0 + (hold.wide - 1.0) * math.exp(-dt / FORGOTTEN)
    calmed = dt * CALM / BRIEF if held else dt  # [s]
    turned_for, shut_for, calm_for = hold.turned_for + dt, hold.shut_for + dt, hold.calm_for + calmed
    if c == 0.0:
        return HoldState(
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
        return HoldState(
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
    # Opened the same way again by a command: slow motion, no cycle.
    again = hold.way == 0.0 and (turns or held) and BRIEF < shut_for < SOON
    if again or (turns and BRIEF < turned_for < SOON):
        wide = min(WIDEST, 2.0 * wide)
    turned_for = 0.0 if turns else turned_for
    passed = c if c * way > 0.0 else way * BARELY
    return HoldState(
        slow=slow,
        quick=quick,
        way=way,
        last=way,
        turned_for=turned_for,
        shut_for=0.0,
        calm_for=calm_for,
        wide=wide,
    ), passed


def _passed(before: float, c: float, lag: float, dt: float) -> float:
    """Return the low-passed command [V]; the first after none counts whole."""
    return c if before == 0.0 else before + (1.0 - math.exp(-dt / lag)) * (c - before)
