"""The WebSocket of a page."""

import asyncio
import contextlib
import socket
import time
from typing import Any

from aiohttp import WSMsgType, web

from forest_station.server.outbox import Outbox
from forest_station.server.requests import Request, answered, read_request
from forest_station.server.server_state import Station

LARGEST = 16384  # [bytes] of a message of a page
SEND_BUFFER = 32768  # [bytes] what the system keeps for a page that does not read
LEAVE = 1.0  # [s] for which a page that is sent away may go on talking
PING = 10.0  # [s] between two questions whether a page is still there
MOST_MESSAGES = 500  # of a page in a second; a driving page sends 50 to 150


class PageSocket:
    """Serves `/socket`.

    Args:
        station: the server's state.
        requests: what a page may ask.
    """

    def __init__(self, station: Station, requests: dict[str, Request]) -> None:
        self._station, self._requests = station, requests
        self._open: set[web.WebSocketResponse] = set()

    async def serve(self, request: web.Request) -> web.WebSocketResponse:
        """Talk with a page until it goes."""
        peer = web.WebSocketResponse(
            heartbeat=PING, compress=False, max_msg_size=LARGEST, writer_limit=0, timeout=LEAVE
        )
        _keep_little(request)
        await peer.prepare(request)
        page = self._station.open()
        self._open.add(peer)
        sender = asyncio.create_task(_send(peer, self._station.pages[page]))
        try:
            await self._listen(peer, page)
        finally:
            sender.cancel()
            self._open.discard(peer)
            self._station.close(page)
        return peer

    async def close(self) -> None:
        """Close every page's socket: the server ends."""
        for peer in list(self._open):
            await peer.close(code=1001, message=b"The station ends.")

    async def _listen(self, peer: web.WebSocketResponse, page: str) -> None:
        begun, count = time.monotonic(), 0
        tasks: set[asyncio.Task[None]] = set()
        async for message in peer:
            now = time.monotonic()
            begun, count = (now, 1) if now - begun > 1.0 else (begun, count + 1)
            if count > MOST_MESSAGES:
                await peer.close(code=1008, message=b"Too many messages.")
                return
            if message.type == WSMsgType.BINARY:
                hands = self._station.driving.hear(page, message.data)
                if hands is not None:
                    self._station.pages[page].put("pong", {"number": hands.number})
            elif message.type == WSMsgType.TEXT:
                task = asyncio.create_task(self._answer(page, message.data))
                tasks.add(task)
                task.add_done_callback(tasks.discard)

    async def _answer(self, page: str, text: str) -> None:
        answer = await answered(self._station, page, read_request(text), self._requests)
        outbox = self._station.pages.get(page)
        if outbox is not None:
            outbox.put_line("answer", answer)


async def _send(peer: web.WebSocketResponse, outbox: Outbox) -> None:
    """Send what waits for a page, as fast as it takes it."""
    with contextlib.suppress(ConnectionError):
        while True:
            item = await outbox.take()
            await (peer.send_bytes(item) if isinstance(item, bytes) else peer.send_str(item))


def _keep_little(request: web.Request) -> None:
    """Have a page that does not read find little of the past when it reads again."""
    transport: Any = request.transport
    transport.set_write_buffer_limits(high=0)
    with contextlib.suppress(OSError):
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
