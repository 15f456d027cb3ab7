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


class Knot(NamedTuple):
    """A sample and when it was sent [s]."""

    time: float
    levers: Levers


# Samples that are kept: more than `DELAY` periods hold.
Knots = tuple[Knot, Knot, Knot, Knot, Knot, Knot]


class InterpolatedLevers(NamedTuple):
    """The levers between samples, and what they are read from."""

    levers: Levers
    knots: Knots  # oldest first; of fewer samples the oldest stands several times
    period: float = 0.0  # T [s]
    at: float = -math.inf  # t [s]


NO_KNOT = Knot(-math.inf, REST)
CENTRED = InterpolatedLevers(REST, (NO_KNOT, NO_KNOT, NO_KNOT, NO_KNOT, NO_KNOT, NO_KNOT))


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
    knots, period, last = before.knots, before.period, before.knots[5]
    if last.time == -math.inf:
        knots = _filled(Knot(sent, newest))
    elif sent > last.time:
        period = _averaged(period, sent - last.time)
        knots = _with(Knot(sent, newest), knots)
    elif newest != last.levers:  # the watch does not believe the newest sample
        one, two, three, four, five, six = knots
        knots = (
            _corrected(one, last, newest),
            _corrected(two, last, newest),
            _corrected(three, last, newest),
            _corrected(four, last, newest),
            _corrected(five, last, newest),
            _corrected(six, last, newest),
        )
    if sent == now and period <= AT_ONCE * dt:
        return InterpolatedLevers(newest, knots, period, now)
    aim = now - DELAY * period
    off = aim - (before.at + dt)
    on_time = abs(off) < ASTRAY and before.period > 0.0
    at = before.at + dt + dt / CLOCK_LAG * off if on_time else aim
    return InterpolatedLevers(_read(knots, at), knots, period, at)


def _averaged(period: float, gap: float) -> float:
    """Return the joystick's period [s] after a gap [s] between two samples."""
    lasted = min(gap, LONGEST_LINE)
    return lasted if period == 0.0 else period + PERIOD_WEIGHT * (lasted - period)


def _with(knot: Knot, knots: Knots) -> Knots:
    """Return the knots with a new one."""
    if knot.time - knots[5].time > LONGEST_LINE:  # the last sample held until shortly before this one
        knots = _filled(Knot(knot.time - LONGEST_LINE, knots[5].levers))
    return knots[1], knots[2], knots[3], knots[4], knots[5], knot


def _filled(knot: Knot) -> Knots:
    return knot, knot, knot, knot, knot, knot


def _corrected(knot: Knot, last: Knot, newest: Levers) -> Knot:
    """Return a knot, with other levers if it is the last one."""
    return Knot(knot.time, newest) if knot.time == last.time else knot


def _read(knots: Knots, time: float) -> Levers:
    """Return the levers at a time [s]; before the first sample and after the last one they stand still."""
    before = knots[0]
    for i in range(6):
        after = knots[i]
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
