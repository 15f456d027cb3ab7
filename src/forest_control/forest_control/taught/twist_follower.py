"""A program's tip velocity becomes a taught command: the way that it draws is kept, and the time gives.

The way grows in the direction that is wished, as far as the tip has come. So a limit that slows the tip
changes where it is on its way, not the way. Only a person lets the crane move: the deadman is held, the
sticks are centred. After anything that ended a run, a wish of zero must come before the next run: a program
that hangs, or runs on, does not set the crane off when the deadman is pressed.

| symbol | name | unit |
|---|---|---|
| w | wished velocity of the tip | m/s |
| p, t | end of the way that the tip has come; direction of w | m, 1 |
"""

import math
from typing import NamedTuple

from forest_control.operator.taught_command import NO_COMMAND, TaughtCommand
from forest_control.taught.taught_work import Seen
from forest_description.types import ZERO, Vec3

TIMEOUT = 0.1  # [s] age at which a wish is lost: as of the machine's state
NEGLIGIBLE = 1e-3  # [m/s] of a wish that counts as zero
AHEAD = 1.0  # [m] of way that is told to be left: the program says when it ends
FRAMES = ("", "base_link")


class TwistError(ValueError):
    """A wish cannot be followed; the message says what is allowed."""


class Wish(NamedTuple):
    """The newest wish of a program."""

    velocity: Vec3  # w
    received: float  # [s]


NO_WISH = Wish(ZERO, -math.inf)


class Follower(NamedTuple):
    """What is remembered between steps."""

    run: float = 0.0  # number of the newest run: when it began [s]
    runs: bool = False
    place: Vec3 = ZERO  # p
    zeroed: bool = False  # a wish of zero has come since a run was broken off


def wish_of(frame: str, linear: Vec3, angular: Vec3, received: float) -> Wish:
    """Return the wish that a message holds.

    Raises:
        TwistError: it is in another frame, turns, or is no finite number.
    """
    if frame not in FRAMES:
        raise TwistError(f"velocity of the tip: frame {frame!r}; allowed: {FRAMES[1]!r} or none")
    if not all(map(math.isfinite, (*linear, *angular))):
        raise TwistError("velocity of the tip: not finite; allowed: m/s of x, y, z")
    if any(angular):
        raise TwistError("velocity of the tip: it turns; allowed: angular 0, for three joints turn no tip")
    return Wish(linear, received)


def step(state: Follower, wish: Wish, seen: Seen, now: float) -> tuple[Follower, TaughtCommand | None]:
    """Return the state at a time, and the command that is to be said, if any.

    Args:
        state: before.
        wish: the newest.
        seen: what crane and operator do.
        now: by the clock of the wish [s].
    """
    size = math.sqrt(sum(w * w for w in wish.velocity))
    heard = seen.armed and seen.centred and now - wish.received <= TIMEOUT
    if not heard or size < NEGLIGIBLE:
        return Follower(run=state.run, zeroed=heard), NO_COMMAND if state.runs else None
    if not state.runs:
        if not state.zeroed:
            return state, None
        state = Follower(run=seen.time, runs=True, place=seen.tip, zeroed=True)
    w, (x, y, z), tip = wish.velocity, state.place, seen.tip
    t = w[0] / size, w[1] / size, w[2] / size
    ahead = (tip[0] - x) * t[0] + (tip[1] - y) * t[1] + (tip[2] - z) * t[2]
    place = x + ahead * t[0], y + ahead * t[1], z + ahead * t[2]
    return state._replace(place=place), TaughtCommand(place, t, ZERO, size, AHEAD)
