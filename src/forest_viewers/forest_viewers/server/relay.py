"""The door to the Foxglove server: both names of the protocol, and no strange web page.

The server of foxglove-sdk knows its protocol as `foxglove.sdk.v1` alone. Lichtblick asks for it as
`foxglove.websocket.v1`, its earlier name; what follows is the same. And the server lets any web page
in that a browser on this computer shows. The relay asks for the page's origin.

Who reads slowly holds back only its own relay, so that the server drops that client's oldest messages.
"""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import Future
from typing import Any
from urllib.parse import urlsplit

from aiohttp import ClientSession, ClientWebSocketResponse, WSMsgType, web

LOOPBACK = "127.0.0.1"
SDK, EARLIER = "foxglove.sdk.v1", "foxglove.websocket.v1"
HOSTS = (LOOPBACK, "localhost", "app.foxglove.dev", "lichtblick-suite.github.io", None)
"""Of the pages that may connect; None: a program on the desk, which shows a file of its own."""
HIDDEN = "null"  # the origin that a sandboxed frame of any page tells


class Relay:
    """Relays clients to the server, in a thread of its own.

    Args:
        port: on the loopback address; 0: a free one.
        server: the server's port.

    Raises:
        OSError: the port cannot be had.
    """

    def __init__(self, port: int, server: int) -> None:
        self._server = f"ws://{LOOPBACK}:{server}"
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="relay", daemon=True)
        self._thread.start()
        self.port: int
        try:
            self.port, self._stop = self._wait(self._start(port))
        except OSError:
            self._end()
            raise

    def close(self) -> None:
        """Send every client away."""
        self._wait(self._stop())
        self._end()

    def _wait(self, work: Coroutine[Any, Any, Any]) -> Any:
        done: Future[Any] = asyncio.run_coroutine_threadsafe(work, self._loop)
        return done.result()

    def _end(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    async def _start(self, port: int) -> tuple[int, Callable[[], Coroutine[Any, Any, None]]]:
        page = web.Application()
        page.router.add_get("/", self._welcome)
        runner = web.AppRunner(page, access_log=None, shutdown_timeout=0.0)
        await runner.setup()
        try:
            await web.TCPSite(runner, LOOPBACK, port).start()
        except OSError:
            await runner.cleanup()
            raise
        return runner.addresses[0][1], runner.cleanup

    async def _welcome(self, request: web.Request) -> web.StreamResponse:
        asked = request.headers.get("Sec-WebSocket-Protocol", "")
        if not {name.strip() for name in asked.split(",")} & {SDK, EARLIER}:
            raise web.HTTPBadRequest(text=f"the WebSocket protocol is {asked!r}; allowed: {SDK}, {EARLIER}")
        origin = request.headers.get("Origin", "")
        if origin == HIDDEN or urlsplit(origin).hostname not in HOSTS:
            raise web.HTTPForbidden(
                text=f"the page is of {origin}; allowed: {', '.join(filter(None, HOSTS))}"
            )
        client = web.WebSocketResponse(protocols=(SDK, EARLIER), max_msg_size=0, compress=False)
        await client.prepare(request)
        async with (
            ClientSession() as session,
            session.ws_connect(self._server, protocols=(SDK,), max_msg_size=0) as server,
        ):
            ways = [
                asyncio.ensure_future(_pass(client, server)),
                asyncio.ensure_future(_pass(server, client)),
            ]
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)
        await client.close()
        return client


Socket = ClientWebSocketResponse | web.WebSocketResponse


async def _pass(source: Socket, target: Socket) -> None:
    """Pass messages on until one of the two ends."""
    async for message in source:
        if message.type == WSMsgType.TEXT:
            await target.send_str(message.data)
        elif message.type == WSMsgType.BINARY:
            await target.send_bytes(message.data)
