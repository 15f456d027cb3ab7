"""Levers between the samples of a joystick that is slower than the controller.

A joystick speaks 20 to 100 times a second, the controller steps 200 times, and neither on the dot. Levers
held between two samples would be a staircase, and a scheme that looks at the wish's acceleration would throw
the valves to and fro at every tread; so would a line to the newest sample, as often as that one is late. So
the levers are read `DELAY` periods behind the present, where later samples are there already, on straight
lines between the times at which the samples were said. The time that they are read at goes by the machine's
stamps, which are even, and follows the clock slowly.

| symbol | name | unit |
|---|---|---|
| t | time at which the levers are read, by the controller's clock | s |
| T | period of the joystick, averaged | s |
| now | when the machine's state was sent, by the controller's clock | s |

A joystick that speaks in every step, for that very step (lockstep), is followed at once.
"""

import math
from typing import NamedTuple

from forest_control.operator.levers import REST, Levers

LONGEST = 0.1  # [s] a lever that moves again after a pause must not creep
DELAY = 2.0  # periods: a sample may be late by one
AT_ONCE = 1.5  # controller periods: a joystick of this period or less may speak in every step
AVERAGED = 0.2  # share of a new period in T
FOLLOWING = 0.2  # [s] in which t comes back to where it should be
ASTRAY = 0.3  # [s] off: the clock was set, or the controller stood still
KNOTS = 6  # samples that are kept


class Knot(NamedTuple):
    """A sample and when it was said [s]."""

    time: float
    levers: Levers


class LeverHold(NamedTuple):
    """Where the levers are between samples."""

    levers: Levers
    knots: tuple[Knot, ...] = ()  # oldest first
    period: float = 0.0  # T [s]
    at: float = -math.inf  # t [s]


CENTRED = LeverHold(REST)


def advanced(hold: LeverHold, newest: Levers, said: float, now: float, dt: float) -> LeverHold:
    """Return the levers dt [s] on.

    Args:
        hold: as it was.
        newest: sample of the joystick.
        said: when, by the controller's clock [s].
        now: when the machine's state was sent, by the same clock [s].
        dt: of the controller, by the machine's time [s].
    """
    knots, period = hold.knots, hold.period
    if not knots:
        knots = (Knot(said, newest),)
    elif said > knots[-1].time:
        knots, period = _with(Knot(said, newest), knots, period)
    elif newest != knots[-1].levers:  # it is not believed any more
        knots = (*knots[:-1], Knot(knots[-1].time, newest))
    if said == now and period <= AT_ONCE * dt:
        return LeverHold(newest, knots, period, now)
    aim = now - DELAY * period
    off = aim - (hold.at + dt)
    on_time = abs(off) < ASTRAY and hold.period > 0.0
    at = hold.at + dt + dt / FOLLOWING * off if on_time else aim
    return LeverHold(_read(knots, at), knots, period, at)


def _with(knot: Knot, knots: tuple[Knot, ...], period: float) -> tuple[tuple[Knot, ...], float]:
    """Return the knots with a new one, and the joystick's period [s]."""
    gap = knot.time - knots[-1].time
    lasted = min(gap, LONGEST)
    if gap > LONGEST:  # what was said last held until shortly before
        knots = (Knot(knot.time - LONGEST, knots[-1].levers),)
    period = lasted if period == 0.0 else period + AVERAGED * (lasted - period)
    return (*knots[1 - KNOTS :], knot), period


def _read(knots: tuple[Knot, ...], time: float) -> Levers:
    """Return the levers at a time [s]; before the first sample and after the last one they stand still."""
    before = knots[0]
    for after in knots:
        if after.time >= time:
            span = after.time - before.time
            share = (time - before.time) / span if span > 0.0 else 0.0
            return between(before.levers, after.levers, share)
        before = after
    return before.levers


def between(a: Levers, b: Levers, share: float) -> Levers:
    """Return the levers at a share, 0..1, of the way from a to b."""
    return Levers(
        a.swing + share * (b.swing - a.swing),
        a.boom + share * (b.boom - a.boom),
        a.stick + share * (b.stick - a.stick),
    )
