"""Whether a command reaches the valves: what the valve driver's node does with each of them.

| what happens | verdict |
|---|---|
| the command is older than the timeout when it is read: left over from a stall | SKIP |
| it is not zero, and its stamp stands still or goes back | REFUSE |
| it cannot be read | CENTRE |
| the emergency stop is pressed | CENTRE |
| none in time was good for `GONE`, or ever, and none since was zero | CENTRE |
| no command for the timeout (`is_lost`) | CENTRE |
| none of these | STEP |

Commands that were gone for long must be zero once before they count again: the levers are let go. Meanwhile
the controller may have gone on, and its reference with it. What this process itself slept through was gone,
too, and what was said before it began: a driver that is started anew in mid-motion moves nothing.
"""

import math
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

from forest_description.types import ZERO, Vec3
from forest_msgs_py.runtime import stamp_order

GONE = 0.3  # [s] in which a reference goes 0.15 m at 0.5 m/s: the valves shut sooner, and open again
NOT_ZERO = "a command is not zero; release the deadman"
AT_ONCE = "valve_commands: not zero at the start or after a gap; allowed: zero first, release the deadman"


class Verdict(IntEnum):
    """What the driver does."""

    SKIP = 0  # the command counts for nothing
    REFUSE = 1  # nor does it, but /diagnostics tells why
    CENTRE = 2  # zero voltage at once
    STEP = 3  # the driver steps with the command


class Command(NamedTuple):
    """A message on /valve_commands."""

    values: Vec3  # [V] of ideal valves
    stamp: int  # [ns]
    sent: float  # [s] local clock
    problem: str = ""  # why it cannot be read


class CommandGate:
    """The newest command, and what follows from each.

    Args:
        timeout: age at which a command is lost [s].
        now: the local time [s].
    """

    def __init__(self, timeout: float, now: Callable[[], float]) -> None:
        self.timeout, self._now = timeout, now
        self.problem = ""  # of the newest command, in one sentence
        self._order, self._sent, self._values = stamp_order.FIRST, -math.inf, ZERO
        self._waits = False  # for a command of zero

    def decide(self, command: Command, pressed: bool) -> Verdict:
        """Return what follows from a command that was just read; `pressed`: the emergency stop is."""
        if self._now() - command.sent > self.timeout:
            return Verdict.SKIP  # `is_lost` acts meanwhile
        self.problem = command.problem
        if not self.problem and command.values != ZERO:  # zero counts in any order
            order, stamp = self._order, command.stamp
            self.problem = stamp_order.disorder(order, "valve_commands", stamp)
            self._order = stamp_order.updated_order(order, stamp, command.sent, self.timeout)
            if self.problem:
                return Verdict.REFUSE  # what is past moves nothing; `is_lost` acts if nothing newer comes
        if self.problem:
            return Verdict.CENTRE
        was_gone = command.sent - self._sent > GONE  # before the first they were, for ever
        self._waits = (self._waits or was_gone) and command.values != ZERO
        self._sent, self._values = command.sent, command.values
        if self._waits:
            self.problem = AT_ONCE
        return Verdict.CENTRE if pressed or self._waits else Verdict.STEP

    def is_lost(self) -> bool:
        """Tell whether no good command has come for the timeout."""
        return self._now() - self._sent > self.timeout

    def against_reset(self) -> str:
        """Return why the emergency stop may not be reset, or ""."""
        return NOT_ZERO if self._values != ZERO and not self.is_lost() else ""
