"""Levers between the samples of a joystick that is slower than the controller.

A joystick speaks 20 to 100 times a second, the controller steps 200 times. Levers held between two samples
would be a staircase, and a scheme that looks at the wish's acceleration would throw the valves to and fro at
every tread. So they go to the newest sample on a straight line, for `STRETCH` times as long as the joystick
took for it, since the next one may be late: then they still move. A joystick that speaks in every step is
followed at once, another one to two of its periods late.
"""

from typing import NamedTuple

from forest_control.levers import REST, Levers

LONGEST = 0.1  # [s] a lever that moves again after a pause must not creep
STRETCH = 2.0
AT_ONCE = 1.5  # controller periods: a sample that lasts no longer is taken as it is


class LeverHold(NamedTuple):
    """Where the levers are between two samples."""

    levers: Levers
    target: Levers  # the newest sample
    left: float  # [s] until it is reached


CENTRED = LeverHold(REST, REST, 0.0)


def advanced(hold: LeverHold, newest: Levers, period: float, dt: float) -> LeverHold:
    """Return the levers dt [s] on.

    Args:
        hold: as it was.
        newest: sample of the joystick.
        period: [s] between it and the one before.
        dt: of the controller [s].
    """
    left = hold.left if newest == hold.target else STRETCH * min(period, LONGEST)
    if period <= AT_ONCE * dt or left <= dt:
        return LeverHold(newest, newest, 0.0)
    share, at = dt / left, hold.levers
    levers = Levers(
        at.swing + share * (newest.swing - at.swing),
        at.boom + share * (newest.boom - at.boom),
        at.stick + share * (newest.stick - at.stick),
    )
    return LeverHold(levers, newest, left - dt)
