"""The driver's place: seat, deadman and levers together; what it says is the joystick of the crane."""

import math
from typing import NamedTuple

from forest_control.operator.levers import AXIS_COUNT, BUTTON_COUNT
from forest_station.operator import deadman as deadman_rule
from forest_station.operator import seat as seat_rule
from forest_station.operator.deadman import Deadman, State
from forest_station.operator.hands_message import Hands
from forest_station.operator.seat import Seat

CENTRED = (0.0,) * AXIS_COUNT
KEPT_PONGS = 64  # more than go out in `ROUND_TRIP`


class JoystickState(NamedTuple):
    """What /joy is to say."""

    heartbeat: int  # one more with each heartbeat of the page, and with each change of the deadman
    axes: tuple[float, ...] = CENTRED
    buttons: tuple[int, ...] = (0,) * BUTTON_COUNT


class Cab:
    """Seat, deadman and levers.

    Args:
        deadman_button: of /joy that means "held"; what a page says of this button counts for nothing.
    """

    def __init__(self, deadman_button: int) -> None:
        self._button = deadman_button
        self.seat, self.deadman = Seat(), deadman_rule.REST
        self._hands: Hands | None = None  # newest of the driver, while its heartbeat counts
        self._heartbeat = 0
        self._pongs: dict[int, float] = {}  # when they were sent [s], by number

    def take(self, page: str, now: float) -> bool:
        """Ask for the seat; tell whether the page has it."""
        self._sit(seat_rule.asked(self.seat, page, now), "")
        return self.seat.driver == page

    def leave(self, page: str, heir: str | None, now: float) -> None:
        """Have the driver leave the seat to another page, or to nobody (None)."""
        self._sit(seat_rule.left(self.seat, page, heir, now), "")

    def gone(self, page: str) -> None:
        """Have a page go."""
        self._sit(seat_rule.gone(self.seat, page), "")

    def hear(self, page: str, hands: Hands, received: float) -> bool:
        """Take in a message of a page, received at a time [s]; tell whether the page drives."""
        if page != self.seat.driver:
            return False
        self.seat = seat_rule.heard(self.seat, received)
        round_trip = received - self._pongs.get(hands.pong, -math.inf)
        before = self.deadman.heartbeats
        self._use(deadman_rule.heard_hands(self.deadman, hands, received, round_trip))
        if self.deadman.heartbeats > before:
            self._hands, self._heartbeat = hands, self._heartbeat + 1
        return True

    def sent_pong(self, number: int, now: float) -> None:
        """Note when the driver was answered [s]."""
        self._pongs[number] = now
        while len(self._pongs) > KEPT_PONGS:
            del self._pongs[next(iter(self._pongs))]

    def stop(self, cause: str) -> None:
        """Have the deadman released and pressed anew, and say why."""
        self._use(deadman_rule.stopped(self.deadman, cause))

    def judge(self, now: float) -> None:
        """Let what is too old stop counting at a time [s]."""
        self._use(deadman_rule.judged(self.deadman, now))
        if now >= self.deadman.heartbeat + deadman_rule.TIMEOUT:
            self._hands = None

    def joystick(self) -> JoystickState:
        """Return what /joy is to say."""
        if self._hands is None:
            return JoystickState(self._heartbeat)
        buttons = [self._hands.buttons >> place & 1 for place in range(BUTTON_COUNT)]
        buttons[self._button] = int(self.deadman.state == State.HELD)
        return JoystickState(self._heartbeat, self._hands.axes, tuple(buttons))

    def _sit(self, seat: Seat, cause: str) -> None:
        """Give the seat: a new driver begins with a deadman of its own."""
        if seat.driver != self.seat.driver:
            self._use(Deadman(cause=cause))
            self._hands, self._pongs = None, {}
        self.seat = seat

    def _use(self, deadman: Deadman) -> None:
        if (deadman.state == State.HELD) != (self.deadman.state == State.HELD):
            self._heartbeat += 1
        self.deadman = deadman
