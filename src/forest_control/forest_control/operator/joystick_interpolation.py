"""Levers between the samples of a joystick that is slower than the controller.

A joystick publishes 20 to 100 times a second, the controller steps 200 times. Held levers would be
a staircase: a scheme that feeds the command's acceleration forward would move the valves at every
tread. So the levers are read `DELAY` periods in the past, on straight lines between the samples.
The time t at which they are read goes by the machine's even stamps, and follows the clock slowly.

| symbol | name | unit |
|---|---|---|
| t | time at which the levers are read, by the controller's clock | s |
| T | period of the joystick, averaged | s |
| now | when the machine's state was sent, by the controller's clock | s |

In lockstep a joystick publishes for the very step: it is followed without delay.
"""

import math
from typing import NamedTuple

from forest_control.operator.levers import REST, Levers

LONGEST_LINE = 0.1  # [s] longest line between two samples: a lever that moves after a pause must not creep
DELAY = 2.0  # [1] periods T that t is behind: a sample may be late by one
AT_ONCE = 1.5  # [1] controller periods: a joystick of at most this period may be one in lockstep
PERIOD_WEIGHT = 0.2  # [1] weight of a new period in the average T: chosen; not measured
CLOCK_LAG = 0.2  # [s] time constant with which t follows the clock: chosen; not measured
ASTRAY = 0.3  # [s] error of t from which it is set anew: the clock was set, or the controller stalled
KNOTS = 6  # [1] samples that are kept: more than `DELAY` periods hold


class Knot(NamedTuple):
    """A sample and when it was sent [s]."""

    time: float
    levers: Levers


class InterpolatedLevers(NamedTuple):
    """The levers between samples, and what they are read from."""

    levers: Levers
    knots: tuple[Knot, ...] = ()  # oldest first
    period: float = 0.0  # T [s]
    at: float = -math.inf  # t [s]


CENTRED = InterpolatedLevers(REST)


def interpolated(
    before: InterpolatedLevers, newest: Levers, sent: float, now: float, dt: float
) -> InterpolatedLevers:
    """Return the levers dt [s] on.

    Args:
        before: as they were.
        newest: sample of the joystick.
        sent: when, by the controller's clock [s].
        now: when the machine's state was sent, by the same clock [s].
        dt: of the controller, by the machine's time [s].
    """
    knots, period = before.knots, before.period
    if not knots:
        knots = (Knot(sent, newest),)
    elif sent > knots[-1].time:
        knots, period = _with(Knot(sent, newest), knots, period)
    elif newest != knots[-1].levers:  # the watch does not believe the newest sample
        knots = (*knots[:-1], Knot(knots[-1].time, newest))
    if sent == now and period <= AT_ONCE * dt:
        return InterpolatedLevers(newest, knots, period, now)
    aim = now - DELAY * period
    off = aim - (before.at + dt)
    on_time = abs(off) < ASTRAY and before.period > 0.0
    at = before.at + dt + dt / CLOCK_LAG * off if on_time else aim
    return InterpolatedLevers(_read(knots, at), knots, period, at)


def _with(knot: Knot, knots: tuple[Knot, ...], period: float) -> tuple[tuple[Knot, ...], float]:
    """Return the knots with a new one, and the joystick's period [s]."""
    gap = knot.time - knots[-1].time
    lasted = min(gap, LONGEST_LINE)
    if gap > LONGEST_LINE:  # the last sample held until shortly before this one
        knots = (Knot(knot.time - LONGEST_LINE, knots[-1].levers),)
    period = lasted if period == 0.0 else period + PERIOD_WEIGHT * (lasted - period)
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
