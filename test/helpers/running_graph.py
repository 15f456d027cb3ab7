"""A supervisor with its nodes as a process, for the tests of a module."""

import contextlib
import os
import signal
import socket
import time
from collections.abc import Iterator
from pathlib import Path

from processes import ForkedNode

STARTED_S, ENDED_S = 60.0, 20.0


def free_port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


@contextlib.contextmanager
def running(module: str, log: Path, domain: int, *options: str) -> Iterator[ForkedNode]:
    """A supervisor with its nodes; it ends with the block."""
    process = ForkedNode(module, list(options), log, {**os.environ, "ROS_DOMAIN_ID": str(domain)})
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(ENDED_S)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def wait_for_text(process: ForkedNode, log: Path, text: str) -> None:
    """Wait until a process has said something."""
    end = time.monotonic() + STARTED_S
    while text not in log.read_text():
        assert process.poll() is None, log.read_text()
        assert time.monotonic() < end, log.read_text()
        time.sleep(0.02)
