"""The hold of a valve: when a small command opens it. Noise would cross the overlap for ever.

| symbol | name | unit |
|---|---|---|
| c | command of the ideal valve, with what leaks | V |
| z | hold zone: a steady command up to this leaves the valve shut | V |

A command that cannot be noise is motion. It passes at once, and so do others for a while after. At
rest a small command opens the valve when its low-passed value is over the zone. It shuts the valve
when that value has gone back to a quarter of the zone, or turned round. An actuator that is held for
`BRIEF` has come to rest.

A valve that feeds what leaks stays on its side at rest. A command that turns round takes it back into the
overlap by and by: where the overlap is narrower than believed, a valve that jumped would feed by strokes.
"""

import math
from typing import NamedTuple

OPENING_LAG = 0.2  # [s] of the low-pass that decides about opening: noise averages out; chosen
SHUTTING_LAG = 0.02  # [s] of the low-pass that decides about shutting: four periods; chosen
SHUT_SHARE = 0.25  # [1] of the zone at which a valve shuts: hysteresis against chatter; chosen
MOVING_SHARE = 0.2  # [1] of the zone that opens in motion: a slow reversal must not wait
BRIEF = 0.05  # [s] in which an actuator that is held has come to rest: ten periods
CALM = 0.5  # [s] without a command that must be motion: longer than a reversal takes
BARELY = 1e-9  # [V] command of an open valve whose noise has turned round: it stays where it is


class HoldState(NamedTuple):
    """One valve's state."""

    slow: float = 0.0  # c behind either low-pass [V]
    quick: float = 0.0
    way: float = 0.0  # 1, -1 open; 0 shut
    calm_for: float = CALM  # [s] since c was more than noise


SHUT = HoldState()


def held_command(
    hold: HoldState, c: float, zone: float, opens: float, side: float, noise: float, held: bool, dt: float
) -> tuple[HoldState, float]:
    """Return the state a period of dt [s] on, and the command that passes: 0 where the valve shall stay shut.

    One that passes against the state's `way` leads the valve from the edge into the overlap.

    Args:
        hold: state.
        c: command [V]; 0 is none: shut.
        zone: z [V]; 0: every command passes.
        opens: a steady command over this opens [V]; z, or less where leakage must be fed.
        side: -1, 1: leakage must be fed, on this side of the overlap; at rest the valve stays on it. 0: none.
        noise: c up to this may be noise [V].
        held: no motion is commanded, c is leakage alone.
        dt: period [s].
    """
    calm_for = hold.calm_for + (dt * CALM / BRIEF if held else dt)
    if c == 0.0:
        return HoldState(calm_for=calm_for), 0.0
    stops = held and hold.calm_for < CALM  # what it moved at is past
    slow = c if stops else _passed(hold.slow, c, OPENING_LAG, dt)
    quick = _passed(hold.quick, c, SHUTTING_LAG, dt)
    if abs(c) > max(zone, noise) or zone == 0.0:
        calm_for = 0.0
    way = hold.way
    if calm_for < CALM:
        way = math.copysign(1.0, c) if abs(c) > MOVING_SHARE * zone else 0.0
    elif way != 0.0 and way != side:
        way = way if way * quick >= SHUT_SHARE * opens else 0.0
    elif way == 0.0 and abs(slow) > opens:
        way = math.copysign(1.0, slow)
    if calm_for >= CALM and way * side < 0.0:
        way = 0.0  # what leaks brings the actuator back
    after = HoldState(slow=slow, quick=quick, way=way, calm_for=calm_for)
    if way == 0.0:
        return after, 0.0
    feeds = calm_for >= CALM and way == side
    return after, c if c * way > 0.0 or feeds else way * BARELY


def _passed(before: float, c: float, lag: float, dt: float) -> float:
    """Return the low-passed command [V]; the first after none counts whole."""
    return c if before == 0.0 else before + (1.0 - math.exp(-dt / lag)) * (c - before)
