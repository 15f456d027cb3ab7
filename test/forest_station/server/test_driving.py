"""A server that was late itself hears what waits in its sockets before it judges a page as silent."""

import asyncio
import contextlib
import socket
from types import SimpleNamespace

import pytest

from forest_station.operator.cab import Cab
from forest_station.operator.deadman import State
from forest_station.operator.hands_message import LAYOUT, Hands, encode_hands
from forest_station.server import driving

CENTRED = (0.0,) * 6
STALL = 0.09  # [s]; a heartbeat counts for 0.08 s


class Ears(asyncio.Protocol):
    """Hands on what a page sends one turn of the loop after it was read, as a WebSocket does."""

    def __init__(self, hear):
        self._hear = hear

    def data_received(self, data):
        for start in range(0, len(data), LAYOUT.size):
            asyncio.get_running_loop().call_soon(self._hear, "1", data[start : start + LAYOUT.size])


class Page:
    """A page that drives, on a clock by hand."""

    def __init__(self, monkeypatch):
        self.now, self.number = 100.0, 0
        monkeypatch.setattr(driving, "time", SimpleNamespace(monotonic=lambda: self.now, time_ns=lambda: 1))
        graph = SimpleNamespace(
            stop_button=SimpleNamespace(active=False),
            joystick=SimpleNamespace(publish=lambda sample: None, rivals=list),
            latency=SimpleNamespace(follow=lambda arrived: None),
        )
        self.cab = Cab(9)
        self.driving = driving.Driving(graph, self.cab, lambda kind, told: None)
        self.socket, self.served = socket.socketpair()

    def send(self, held):
        self.number += 1
        self.socket.send(encode_hands(Hands(held, self.number, self.now, CENTRED, 0, self.number - 1)))
        self.now += 0.02

    async def after_a_stall(self, sent):
        """The state of the deadman after the loop stood still while the page sent some messages."""
        hears = asyncio.get_running_loop().create_connection
        served, _ = await hears(lambda: Ears(self.driving.hear), sock=self.served)
        self.driving.take("1")
        task = asyncio.ensure_future(self.driving.run())
        for held in (False, False, True):
            self.send(held)
            for _ in range(10):
                await asyncio.sleep(0)
        assert self.cab.deadman.state == State.HELD
        end = self.now + STALL
        for _ in range(sent):
            self.send(True)
        self.now = end
        self.driving.leave("2", None)  # the loop looks
        for _ in range(10):
            await asyncio.sleep(0)
        state = self.cab.deadman.state
        served.close()
        self.socket.close()
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
        return state


@pytest.mark.parametrize(("sent", "state"), [(4, State.HELD), (0, State.WAITING)])
def test_a_loop_that_stood_still_judges_by_what_has_arrived_meanwhile(monkeypatch, sent, state):
    assert asyncio.run(Page(monkeypatch).after_a_stall(sent)) == state
