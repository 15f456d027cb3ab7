"""Bags are read in a process of its own: it may take long, it may need memory, and the bag may be anybody's.

The station's loop judges the deadman. So nothing of a bag is read or decoded there: a nice process does it,
with a limit to its memory and to its time, and it ends with the station, however that ends.
"""

import asyncio
import contextlib
import os
import resource
import signal
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from forest_bag.storage.bag_files import BagError
from forest_description.machine import Machine
from forest_station.recordings.replay_bag import ReplayBag
from forest_station.recordings.replay_frames import frames, window

LONGEST_ANSWER_S = 60.0
MOST_MEMORY = 1 << 30  # bytes; 200 MB is usual, a hostile chunk may ask for any
MOST_OPEN = 2  # bags: one, and the one laid over it
NICE = 10


class ReplayWorker:
    """Asks the process, one question after the other; starts it with the first, and again when it died.

    Args:
        own: the station's machine.
        longest_answer: [s], after which the process is ended.
    """

    def __init__(self, own: Machine, longest_answer: float = LONGEST_ANSWER_S) -> None:
        self._own, self._longest_answer = own, longest_answer
        self._thread = ThreadPoolExecutor(1, "replay")
        self._process: subprocess.Popen[bytes] | None = None
        self._pipe: Connection | None = None

    async def describe(self, path: Path) -> dict[str, Any]:
        """Return what the page needs of a bag before its first frame; see `ReplayBag.description`.

        Raises:
            BagError: it cannot be read.
        """
        found: dict[str, Any] = await self._ask("describe", str(path))
        return found

    async def frames(self, path: Path, start: float, end: float, rate: float) -> bytes:
        """Return the frames of a window of a bag; see `replay_frames.window`.

        Raises:
            BagError: it cannot be read, or the window is none.
        """
        found: bytes = await self._ask("frames", str(path), start, end, rate)
        return found

    def close(self) -> None:
        """End the process."""
        self._thread.shutdown(wait=False, cancel_futures=True)
        self._end()

    async def _ask(self, *question: Any) -> Any:
        answer = await asyncio.get_running_loop().run_in_executor(self._thread, self._exchange, question)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def _exchange(self, question: tuple[Any, ...]) -> Any:
        try:
            pipe = self._running()
            pipe.send(question)
            if pipe.poll(self._longest_answer):
                return pipe.recv()
            told = f"reading the bag took longer than {self._longest_answer:g} s"
        except (EOFError, OSError):
            told = "the process that reads bags ended"
        self._end()
        return BagError(f"{told}: {Path(question[1]).name} is not shown")

    def _running(self) -> Connection:
        if self._pipe is None:
            ours, theirs = socket.socketpair()
            with theirs:
                number = theirs.fileno()
                argv = [sys.executable, "-m", __name__, str(number)]
                self._process = subprocess.Popen(argv, pass_fds=[number], start_new_session=True)
            self._pipe = Connection(ours.detach())
            self._pipe.send(self._own)
        return self._pipe

    def _end(self) -> None:
        pipe, process, self._pipe, self._process = self._pipe, self._process, None, None
        if process is not None:
            process.kill()
            process.wait()
        if pipe is not None:
            pipe.close()


class _OpenBags:
    """The bags that were asked for last; one that has grown is opened anew."""

    def __init__(self, own: Machine) -> None:
        self._own = own
        self._bags: dict[tuple[Any, ...], ReplayBag] = {}

    def get(self, path: str) -> ReplayBag:
        files = sorted(Path(path).iterdir()) if Path(path).is_dir() else [Path(path)]
        key = (path, *((file.name, file.stat().st_size, file.stat().st_mtime_ns) for file in files))
        bag = self._bags.pop(key, None) or ReplayBag(path, self._own)
        self._bags[key] = bag  # the newest last
        while len(self._bags) > MOST_OPEN:
            self._bags.pop(next(iter(self._bags))).close()
        return bag

    def answer(self, what: str, path: str, *numbers: float) -> Any:
        """Answer a question; what is wrong is the answer, too."""
        try:
            if what == "describe":
                return self.get(path).description()
            wanted = window(*numbers)
            return frames(self.get(path), wanted)
        except BagError as error:
            return BagError(str(error))
        except MemoryError:
            return BagError(f"{Path(path).name} needs more memory than a replay may take")
        except OSError as error:
            return BagError(f"{Path(path).name} cannot be read: {error.strerror or error}")


def _serve(pipe: Connection) -> None:
    """Answer until the station is gone."""
    with contextlib.suppress(EOFError, OSError):
        bags = _OpenBags(pipe.recv())
        while True:
            pipe.send(bags.answer(*pipe.recv()))


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(NICE)
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    _serve(Connection(int(sys.argv[1])))
