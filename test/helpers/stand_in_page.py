"""A page without a browser: it takes the seat, holds the deadman and tells of its hands, as the page does.

As a program it drives until it is killed: ``stand_in_page.py ADDRESS``.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import math
import struct
import sys
import time
from collections.abc import AsyncIterator
from typing import Any

import aiohttp

from forest_station.operator.hands_message import Hands, encode_hands

PERIOD = 0.02  # [s]
FRAME_HEAD = 16  # bytes
MET_S, PLAYED_S = 60.0, 120.0
CENTRED = (0.0,) * 6
UP, DOWN = (0.0, 0.0, 0.0, 0.5, 0.0, 0.0), (0.0, 0.0, 0.0, -0.5, 0.0, 0.0)
STICKS = itertools.cycle((UP, DOWN))
PRESSED_AFTER, MOVED_AFTER, SETTLED = 5, 10, 10  # messages
TURNED_AFTER, CENTRED_FOR = 100, 10  # messages; without a turn the crane comes to its end


def opposite(stick: tuple[float, ...]) -> tuple[float, ...]:
    """The stick on the other side."""
    return tuple(0.0 - axis for axis in stick)


class StandInPage:
    """One page; use as an asynchronous context manager.

    Args:
        address: of the server, or of a relay before it.
        host: what the page takes it for.
        stick: axes when it drives.
    """

    def __init__(self, address: str, host: str | None = None, stick: tuple[float, ...] = UP) -> None:
        self.address, self.headers = address, {"Host": host} if host else {}
        self.stick = stick
        self.number = self.pong = 0
        self.heard: dict[str, dict] = {}  # the newest message of each kind
        self.answers: list[dict] = []
        self.frames, self.frame, self.settled = 0, b"", False

    async def __aenter__(self) -> StandInPage:
        self._stack = contextlib.AsyncExitStack()
        session = await self._stack.enter_async_context(aiohttp.ClientSession())
        self.socket = await session.ws_connect(f"{self.address}/socket", headers=self.headers)
        self._stack.push_async_callback(self.socket.close)
        self._listener = asyncio.create_task(self._listen())
        return self

    async def __aexit__(self, *_: object) -> None:
        self._listener.cancel()
        await self._stack.aclose()

    async def ask(self, what: str, /, **arguments: object) -> dict:
        """Put a request and give its answer."""
        self.number += 1
        number = self.number
        await self.socket.send_str(json.dumps({"do": what, "number": number, **arguments}))
        end = time.monotonic() + MET_S
        while not (found := [answer for answer in self.answers if answer["to"] == number]):
            assert time.monotonic() < end
            await asyncio.sleep(0.005)
        return found[0]

    async def send(self, held: bool, axes: tuple[float, ...] = CENTRED) -> None:
        self.number += 1
        hands = Hands(held, self.number, time.monotonic(), axes, 0, self.pong)
        await self.socket.send_bytes(encode_hands(hands))

    async def take_seat(self) -> None:
        """Ask for the seat until it is had: a driver that has just gone may not be missed yet."""
        while self.seat["driver"] is None or self.seat["driver"] != self.heard["welcome"]["you"]:
            await self.ask("take_seat")
            await asyncio.sleep(0.05)

    async def drive(self) -> None:
        """Press, deflect a stick, and go on until cancelled.

        A busy computer may end the first tries; once it has gone well for a while, it is not pressed again.
        Each turn rests in the centre, as a hand's does: a controller that lost a state is armed there again.
        """
        k = held = 0
        while True:
            await self.send(k >= PRESSED_AFTER, self._turned() if k >= MOVED_AFTER else CENTRED)
            await asyncio.sleep(PERIOD)
            k += 1
            held = held + 1 if self.seat["deadman"]["state"] == "held" else 0
            self.settled = self.settled or held >= SETTLED
            if not self.settled and not held and k > MOVED_AFTER + SETTLED:
                k = 0

    async def steer(self) -> None:
        """Hold the deadman, pressed anew when it is lost, and the stick as it is set, until cancelled.

        The stick waits in the centre until the controller is armed: a busy computer may disarm it.
        """
        while True:
            state, armed = self.seat["deadman"]["state"], self.value("controller/status/armed") == 1.0
            await self.send(state != "waiting", self.stick if state == "held" and armed else CENTRED)
            await asyncio.sleep(PERIOD)

    def value(self, signal: str) -> float:
        """The value of a signal in the newest frame; NaN where it is not known."""
        names = [name for name, _ in self.heard["welcome"]["signals"]]
        if signal not in names or len(self.frame) != FRAME_HEAD + 4 * len(names):
            return math.nan
        found: float = struct.unpack_from("<f", self.frame, FRAME_HEAD + 4 * names.index(signal))[0]
        return found

    def _turned(self) -> tuple[float, ...]:
        """The stick at this message: to one side, centred, to the other."""
        turn, message = divmod(self.number, TURNED_AFTER)
        if message < CENTRED_FOR:
            return CENTRED
        return self.stick if turn % 2 == 0 else opposite(self.stick)

    async def hold(self) -> None:
        """Hold the deadman and a stick from the beginning, until cancelled."""
        while True:
            await self.send(True, self.stick)
            await asyncio.sleep(PERIOD)

    @property
    def seat(self) -> dict:
        return self.heard.get("seat", {"driver": None})

    async def _listen(self) -> None:
        async for message in self.socket:
            if message.type == aiohttp.WSMsgType.BINARY:
                self.frames += 1
                self.frame = message.data
                continue
            told = json.loads(message.data)
            if told["kind"] == "answer":
                self.answers.append(told)
            elif told["kind"] == "pong":
                self.pong = told["number"]
            self.heard[told["kind"]] = told


def play(scenario: Any) -> None:
    """Run a scenario, at most `PLAYED_S`."""
    asyncio.run(asyncio.wait_for(scenario, PLAYED_S))


@contextlib.asynccontextmanager
async def driving(crane: Any, address: str | None = None) -> AsyncIterator[tuple[StandInPage, asyncio.Task]]:
    """A page that drives the crane, and the task in which it does."""
    crane.ears.forget()
    host = f"127.0.0.1:{crane.port}"
    async with StandInPage(address or crane.address, host, next(STICKS)) as page:
        await page.take_seat()
        hands = asyncio.create_task(page.drive())
        try:
            await crane.ears.moving()
            yield page, hands
        finally:
            hands.cancel()


async def main(address: str) -> None:
    async with StandInPage(address) as page:
        await page.take_seat()
        await page.drive()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1]))
