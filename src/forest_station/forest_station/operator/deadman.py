"""Whether the deadman of a page is held, judged by what arrives here, and when.

A message of the page is a heartbeat if its number is new and it did not wait on the way. Two
measures tell that: its age against the fastest message seen, which finds a burst out of a slow
network's buffer; and its round trip, which finds a network that is slow all the time. A message
counts from the moment when it was sent, whether the way or the server was late.

| state | what it takes to get there |
|---|---|
| WAITING | the beginning; a release; no heartbeat for `TIMEOUT`; a message that is refused; a stop |
| READY | in WAITING: a heartbeat with the deadman released and the levers centred |
| HELD | in READY: a heartbeat with the deadman held |
"""

import math
from enum import IntEnum
from typing import NamedTuple

from forest_control.operator.joystick_watch import WatchParameters, is_centred
from forest_control.operator.levers import levers_from_axes
from forest_station.operator.hands_message import Hands

TIMEOUT = 0.08  # [s] without a heartbeat; the stop must begin within 0.1 s of the last one
ROUND_TRIP = 0.25  # [s] longest from a pong to the hands that tell of it: a release is heard later by less
DRIFT = 5e-4  # [1] of the page's clock against ours: what a clock that is being set may differ by
CENTRE = WatchParameters().centre

# The page says the same of its own thread: hands/late.js.
TOO_LATE = "Sticks and keys came too late: this computer or the network is too busy."


class State(IntEnum):
    """What the deadman allows; only HELD moves the crane."""

    WAITING = 0
    READY = 1
    HELD = 2


TEXTS = {
    State.WAITING: "Release the deadman and centre the sticks.",
    State.READY: "Hold the deadman to drive.",
    State.HELD: "The deadman is held.",
}


class Deadman(NamedTuple):
    """What is remembered of one page."""

    state: State = State.WAITING
    cause: str = ""  # why it waits; "": it was released, or never held
    number: int = -1  # of the newest message
    heartbeat: float = -math.inf  # when the last one was received, had it not waited [s]
    heartbeats: int = 0
    fastest: float = math.inf  # least way of a message: receive time minus the page's time [s]
    heard: float = -math.inf  # when the newest message was received [s]


REST = Deadman()


def heard_hands(before: Deadman, hands: Hands, received: float, round_trip: float) -> Deadman:
    """Take in a message.

    Args:
        before: as it was.
        hands: what the message says.
        received: when [s].
        round_trip: from the pong that the message tells of until now [s]; inf: none.
    """
    new, way = hands.number > before.number, received - hands.sent
    fastest = min(way, before.fastest + DRIFT * max(0.0, received - before.heard))
    late = way - fastest
    in_time = late < TIMEOUT and round_trip < ROUND_TRIP
    sent = received - late  # as the fastest message would have been heard
    deadman = judged(before, sent if new and in_time else received)
    deadman = deadman._replace(
        number=max(hands.number, deadman.number), fastest=fastest, heard=max(received, before.heard)
    )
    if deadman.state == State.HELD and not hands.held:  # a release counts, however late
        deadman = stopped(deadman, "")
    if not (new and in_time):
        return deadman._replace(cause=TOO_LATE) if _waits_for_time(deadman, in_time, round_trip) else deadman
    return _advanced(deadman._replace(heartbeat=sent, heartbeats=deadman.heartbeats + 1), hands)


def judged(deadman: Deadman, now: float) -> Deadman:
    """Return the deadman at a time [s]: without a heartbeat for `TIMEOUT` it has to be pressed anew."""
    if deadman.state == State.WAITING or now < expiry(deadman):
        return deadman
    held = deadman.state == State.HELD
    return stopped(deadman, TOO_LATE if held else "")


def expiry(deadman: Deadman) -> float:
    """Return when the last heartbeat stops counting [s]; inf if nothing is held."""
    return deadman.heartbeat + TIMEOUT if deadman.state != State.WAITING else math.inf


def stopped(deadman: Deadman, cause: str) -> Deadman:
    """Return a deadman that must be released, centred and pressed anew, and why."""
    return deadman._replace(state=State.WAITING, cause=cause)


def text(deadman: Deadman) -> str:
    """Return what the operator should do, after what happened."""
    return f"{deadman.cause} {TEXTS[deadman.state]}".strip()


def _waits_for_time(deadman: Deadman, in_time: bool, round_trip: float) -> bool:
    """Tell whether lateness is what keeps a page from being ready, once its round trip is known."""
    return deadman.state == State.WAITING and not in_time and math.isfinite(round_trip)


def _advanced(deadman: Deadman, hands: Hands) -> Deadman:
    """Return the state after a heartbeat."""
    centred = is_centred(levers_from_axes(hands.axes), CENTRE)
    if deadman.state == State.WAITING and not hands.held and centred:
        return deadman._replace(state=State.READY, cause="")
    if deadman.state == State.READY and hands.held:
        return deadman._replace(state=State.HELD)
    return deadman
