"""The watch over taught commands: when the tip may follow one, and what ends that.

A run is what a person began: each time that a cycle is played or resumed. The player gives it a number that
rises. Once a run has ended, whatever ended it, none of its commands counts again: a person must begin
another.

| what ends a run | what follows |
|---|---|
| a command without speed: the player is done | the tip is held |
| a lever is deflected by more than `centre` | the levers move the tip at once |
| the crane may not move: deadman, joystick, emergency stop, sensors | as without a run |
| no command for `TIMEOUT` | TROUBLE |
| a command that cannot be read, or cannot be | TROUBLE |
| the path is further than `FARTHEST` from the tip | TROUBLE |
| the joystick shows no life for `frozen_timeout`: a deadman that hangs would be held for ever | TROUBLE |

TROUBLE stops the tip along its path, as a released deadman does. Nothing moves until the deadman was
released, or a person begins another run.
"""

import math
from typing import NamedTuple

from forest_control.operator.joystick_watch import Watch, WatchParameters, is_centred
from forest_control.operator.taught_command import (
    NO_COMMAND,
    TaughtCommand,
    distance_from_path,
    implausible,
)
from forest_description.types import Vec3

TIMEOUT = 0.1  # [s] age at which a command is lost: as of the machine's state
FARTHEST = 0.1  # [m] of a path from the tip: it is led back at 0.3 m/s at the most; chosen
NO_RUN = 0.0  # [1] number of no run: a player's are later
LOST = f"taught command: none for {TIMEOUT:g} s; allowed: a new run"
AWAY = f"taught command: its path is further than {FARTHEST:g} m from the tip; allowed: a path near it"
NO_LIFE = "taught command: the joystick shows no life for frozen_timeout; allowed: any button at times"


class TaughtWatch(NamedTuple):
    """What is remembered between commands."""

    command: TaughtCommand = NO_COMMAND  # the newest
    run: float = NO_RUN  # its run
    received: float = -math.inf  # [s] when it was sent
    ended: float = NO_RUN  # the newest run that has ended
    cause: str = ""  # of the trouble that ended it: while it stands, nothing moves


REST = TaughtWatch()


def heard(
    watch: TaughtWatch, run: float, command: TaughtCommand, received: float, problem: str = ""
) -> TaughtWatch:
    """Take in a command of a run; one of an older run counts for nothing.

    Args:
        watch: before.
        run: its number.
        command: what it says.
        received: when it was sent, by the local clock [s].
        problem: why it cannot be read: it ends the run that is under way.
    """
    if problem:
        return ended(watch, problem)
    if run < watch.run or run <= watch.ended:
        return watch
    watch = watch._replace(run=run, command=command, received=received, cause="")
    if trouble := implausible(command):
        return ended(watch, trouble)
    return watch if command.speed > 0.0 else ended(watch)


def ended(watch: TaughtWatch, cause: str = "") -> TaughtWatch:
    """Return the watch with no run under way."""
    if watch.run <= watch.ended:
        return watch
    return watch._replace(ended=watch.run, command=NO_COMMAND, cause=cause)


def assessed(
    watch: TaughtWatch, allowed: bool, joystick: Watch, tip: Vec3, now: float, p: WatchParameters
) -> tuple[TaughtWatch, TaughtCommand]:
    """Return the watch at a time [s], and the command that the tip may follow, or `NO_COMMAND`.

    Args:
        watch: after all commands that have come.
        allowed: the levers may move the crane.
        joystick: whose deadman is held.
        tip: its place by the angles that count [m].
        now: local time [s].
        p: of the joystick watch.
    """
    if not allowed:
        watch = ended(watch)._replace(cause="")
    elif watch.run > watch.ended:
        levers = not is_centred(joystick.levers, p.centre)
        cause = "" if levers else _trouble(watch, joystick, tip, now, p)
        watch = ended(watch, cause) if levers or cause else watch
    return watch, watch.command


def _trouble(watch: TaughtWatch, joystick: Watch, tip: Vec3, now: float, p: WatchParameters) -> str:
    """Return what is wrong with the run, or ""."""
    if not now - watch.received <= TIMEOUT:
        return LOST
    if not distance_from_path(watch.command, tip) <= FARTHEST:
        return AWAY
    hangs = p.frozen_timeout > 0.0 and not now - joystick.moved < p.frozen_timeout
    return NO_LIFE if hangs else ""
