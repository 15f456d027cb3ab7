"""A network between page and server that delays, holds back, and dies without a word."""

from __future__ import annotations

import asyncio
import contextlib


class Relay:
    """Hands bytes on in both directions; use as an asynchronous context manager.

    Args:
        port: of the server.
    """

    def __init__(self, port: int) -> None:
        self._port = port
        self.delay = 0.0  # [s] of what the page sends
        self.open = asyncio.Event()  # cleared: what the page sends waits
        self.open.set()
        self.dead = False  # nothing comes through any more, and nobody is told
        self._tasks: set[asyncio.Task] = set()
        self._writers: list[asyncio.StreamWriter] = []

    async def __aenter__(self) -> Relay:
        self._server = await asyncio.start_server(self._meet, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]
        return self

    async def __aexit__(self, *_: object) -> None:
        self._server.close()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for writer in self._writers:
            writer.close()

    async def _meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, back = await asyncio.open_connection("127.0.0.1", self._port)
        self._writers += [writer, back]
        waiting: asyncio.Queue = asyncio.Queue()
        for job in (self._read(reader, waiting), self._write(waiting, back), self._answer(there, writer)):
            self._tasks.add(asyncio.create_task(job))

    async def _read(self, reader: asyncio.StreamReader, waiting: asyncio.Queue) -> None:
        while data := await reader.read(65536):
            waiting.put_nowait((asyncio.get_running_loop().time() + self.delay, data))

    async def _write(self, waiting: asyncio.Queue, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(ConnectionError):
            while True:
                due, data = await waiting.get()
                await asyncio.sleep(due - asyncio.get_running_loop().time())
                await self.open.wait()
                if not self.dead:
                    writer.write(data)

    async def _answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(65536):
                if not self.dead:
                    writer.write(data)
