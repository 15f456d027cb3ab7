"""A page that does not read costs the station nothing, and finds the present when it reads again."""

import asyncio
import json
from types import SimpleNamespace

import aiohttp
import pytest
from aiohttp import web

from forest_station.server.outbox import Outbox
from forest_station.server.page_socket import PageSocket
from forest_station.server.requests import Request

FRAME = 4000  # bytes
FRAMES = 5000  # 20 MB: far more than all buffers on the way hold


class Station:
    """What a socket needs of the station."""

    def __init__(self):
        self.pages, self.heard, self.closed = {}, [], 0
        self.driving = SimpleNamespace(hear=lambda page, data: self.heard.append((page, data)))
        self.cab = SimpleNamespace(seat=SimpleNamespace(driver="1"))

    def open(self):
        self.pages["1"] = Outbox()
        return "1"

    def close(self, page):
        del self.pages[page]
        self.closed += 1


async def _echo(_station, _page, arguments):
    return str(arguments["text"])


@pytest.fixture
def talk():
    """Runs a conversation with a socket's server."""

    def run(conversation):
        async def serve():
            station = Station()
            app = web.Application()
            app.router.add_get("/socket", PageSocket(station, {"echo": Request(_echo)}).serve)
            runner = web.AppRunner(app)
            await runner.setup()
            site = web.TCPSite(runner, "127.0.0.1", 0)
            await site.start()
            port = runner.addresses[0][1]
            try:
                async with (
                    aiohttp.ClientSession() as session,
                    session.ws_connect(f"http://127.0.0.1:{port}/socket") as socket,
                ):
                    await conversation(station, socket)
            finally:
                await runner.cleanup()

        asyncio.run(asyncio.wait_for(serve(), 30.0))

    return run


def test_a_page_that_did_not_read_finds_the_newest_frame_and_little_of_the_past(talk):
    async def conversation(station, socket):
        reader = socket._response.connection.transport
        reader.pause_reading()
        for number in range(FRAMES):
            station.pages["1"].put_frame(number.to_bytes(4, "little") + bytes(FRAME))
            await asyncio.sleep(0)
        reader.resume_reading()
        numbers = []
        while not numbers or numbers[-1] != FRAMES - 1:
            message = await socket.receive()
            numbers.append(int.from_bytes(message.data[:4], "little"))
        assert numbers == sorted(numbers)
        assert len(numbers) < FRAMES / 2

    talk(conversation)


def test_hands_go_to_the_cab_and_requests_are_answered(talk):
    async def conversation(station, socket):
        await socket.send_bytes(b"hands")
        await socket.send_str(json.dumps({"do": "echo", "number": 7, "text": "yes"}))
        told = json.loads((await socket.receive()).data)
        assert told == {"kind": "answer", "to": 7, "ok": True, "text": "yes"}
        assert station.heard == [("1", b"hands")]
        await socket.close()
        while not station.closed:
            await asyncio.sleep(0.01)
        assert station.pages == {}

    talk(conversation)


@pytest.mark.parametrize("data", [bytes(20_000), "x" * 20_000])
def test_a_message_that_is_too_large_ends_the_socket(talk, data):
    async def conversation(station, socket):
        await (socket.send_bytes(data) if isinstance(data, bytes) else socket.send_str(data))
        assert (await socket.receive()).type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED)
        assert socket.close_code == 1009
        assert station.heard == []

    talk(conversation)
