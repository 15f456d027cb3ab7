"""What waits to be sent to a page that is slower than the graph: the newest of each kind, never a queue."""

import asyncio
import json
from collections import deque
from typing import Any

MOST_LINES = 100  # answers and log lines that wait for a page; older ones are dropped
FRAME = "frame"


class Outbox:
    """Of one page."""

    def __init__(self) -> None:
        self._newest: dict[str, str | bytes] = {}  # by kind
        self._lines: deque[str] = deque(maxlen=MOST_LINES)
        self._filled = asyncio.Event()

    def put(self, kind: str, content: dict[str, Any]) -> None:
        """Have a message wait, in place of an older one of its kind."""
        self._newest[kind] = encoded(kind, content)
        self._filled.set()

    def put_line(self, kind: str, content: dict[str, Any]) -> None:
        """Have a message wait that others of its kind do not replace."""
        self._lines.append(encoded(kind, content))
        self._filled.set()

    def put_frame(self, frame: bytes) -> None:
        """Have a frame wait, in place of an older one."""
        self._newest[FRAME] = frame
        self._filled.set()

    def forget_frame(self) -> None:
        """Drop the frame that waits: its signals have changed."""
        self._newest.pop(FRAME, None)

    async def take(self) -> str | bytes:
        """Return what is to be sent next, once there is something."""
        while True:
            if self._lines:
                return self._lines.popleft()
            if self._newest:
                return self._newest.pop(next(iter(self._newest)))
            self._filled.clear()
            await self._filled.wait()


def encoded(kind: str, content: dict[str, Any]) -> str:
    """Return a message of the protocol."""
    return json.dumps({"kind": kind, **content}, allow_nan=False)
