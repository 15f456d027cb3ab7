"""The driver's place on the server's clock: what pages say goes to /joy, and ends there in time."""

import asyncio
import contextlib
import math
import time
from collections.abc import Callable
from typing import Any

from forest_msgs_py.interfaces.topics import JOY_RATE_HZ
from forest_station.graph.crane_graph import CraneGraph
from forest_station.graph.joystick_output import NAMELESS
from forest_station.operator import deadman
from forest_station.operator.cab import Cab
from forest_station.operator.hands_message import Hands, HandsError, decode_hands

PERIOD = 1.0 / JOY_RATE_HZ  # [s]
SOONEST = 0.004  # [s] between two samples: a flood of a page's must not become one of /joy
LOOK_PERIOD = 1.0  # [s] between two looks for another publisher of /joy
STOPPED = "The emergency stop was pressed."

Tell = Callable[[str, dict[str, Any]], None]


class Driving:
    """Runs the cab.

    Args:
        graph: of the crane.
        cab: seat, deadman and levers.
        tell: sends a message to every page.
    """

    def __init__(self, graph: CraneGraph, cab: Cab, tell: Tell) -> None:
        self._graph, self._cab, self._tell = graph, cab, tell
        self._due = asyncio.Event()
        self._published, self._looked = 0.0, 0.0
        self._told: dict[str, Any] = {}
        self._published_for: str | None = None  # the driver whose samples /joy has had
        self._arrived = 0  # when the first sample came that is not yet published [ns]; 0: none
        self._why_not = ""

    def hear(self, page: str, data: bytes) -> Hands | None:
        """Take in a message of a page; return it if the page drives and may be answered."""
        now = time.monotonic()
        try:
            hands = decode_hands(data)
        except HandsError as error:
            if page == self._cab.seat.driver:
                self.stop(f"{error}.")
            return None
        if not self._cab.hear(page, hands, now):
            return None
        self._arrived = self._arrived or time.time_ns()
        self._cab.sent_pong(hands.number, now)
        self._tell_seat()
        if now - self._published >= SOONEST:
            self._due.set()
        return hands

    def take(self, page: str) -> bool:
        """Ask for the seat; tell whether the page has it."""
        taken = self._cab.take(page, time.monotonic())
        self._why_not = ""
        self._change()
        return taken

    def leave(self, page: str, heir: str | None) -> None:
        """Have the driver leave the seat."""
        self._cab.leave(page, heir, time.monotonic())
        self._change()

    def gone(self, page: str) -> None:
        """Have a page go: if it drove, its deadman is released."""
        self._cab.gone(page)
        self._change()

    def stop(self, cause: str) -> None:
        """Release the deadman, and say why."""
        self._cab.stop(cause)
        self._change()

    async def run(self) -> None:
        """Publish what the cab says, until cancelled; last words: released and centred."""
        try:
            while True:
                self._due.clear()
                wait = self._step(time.monotonic())
                with contextlib.suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(self._due.wait(), wait)
        finally:
            self._cab.stop("")
            self._cab.judge(math.inf)
            self._say(self._cab.seat.driver)

    def _step(self, now: float) -> float:
        """Judge and publish; return how long nothing has to happen [s]."""
        if self._graph.stop_button.active:
            self._cab.stop(STOPPED)
        self._cab.judge(now)
        self._refuse_rivals(now)
        self._say(self._cab.seat.driver)
        self._published = now
        self._tell_seat()
        return max(0.0, min(PERIOD, deadman.expiry(self._cab.deadman) - now))

    def _say(self, driver: str | None) -> None:
        """Publish a sample for a driver, and one at the seat's end: without one /joy is somebody else's."""
        if driver is not None or self._published_for is not None:
            self._graph.joystick.publish(self._cab.joystick())
        self._published_for = driver
        if self._arrived:
            self._graph.latency.follow(self._arrived)
            self._arrived = 0

    def _refuse_rivals(self, now: float) -> None:
        """End the seat if another node publishes /joy: two that command one crane are one too many."""
        driver, asks = self._cab.seat.driver, NAMELESS in self._why_not
        if (driver is None and not asks) or now - self._looked < LOOK_PERIOD:
            return
        self._looked = now
        if rivals := self._graph.joystick.rivals():
            self._why_not = f"Another node publishes /joy: {', '.join(rivals)}."
            if driver is not None:
                self._cab.leave(driver, None, now)

    def _change(self) -> None:
        """Publish at once, and tell the pages."""
        self._due.set()
        self._tell_seat()

    def _tell_seat(self) -> None:
        seat, held = self._cab.seat, self._cab.deadman
        told = {
            "driver": seat.driver,
            "asking": list(seat.asking),
            "deadman": {
                "state": held.state.name.lower(),
                "text": deadman.text(held),
                "cause": held.cause,
            },
            "why_not": self._why_not,
        }
        if told != self._told:
            self._told = told
            self._tell("seat", told)
