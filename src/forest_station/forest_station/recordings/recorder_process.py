"""The project's recorder as a process of the station's: begun with a bag, ended with it, never killed first.

It is the recorder that everybody uses, so its bags survive what those survive. It ends its bag when the
station asks it to, when the station ends, and when the station is killed (the kernel tells it).
"""

import asyncio
import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

from forest_bag.storage.bag_files import BagError
from forest_bag.write.bag_writer import FLUSH_PERIOD_S
from forest_msgs_py.runtime.environment import PARENT_VARIABLE
from forest_station.recordings.bag_directory import BagDirectory

NODE = "station_recorder"  # not the name of a graph's own recorder: both may record
STARTED_S, ENDED_S = 20.0, 30.0  # longest start; longest end, in which a slow disk takes what is left
POLL_S = 0.05
LITTLE_DISK = 1e9  # bytes; the demo's topics write that in an hour and a half
_LOG_LINE = re.compile(r"^\[\w+\] \[[\d.]+\] \[[^\]]*\]: ")


class RecordingState(NamedTuple):
    """How a recording is going; ``text`` is a sentence for the person."""

    active: bool
    name: str
    seconds: float
    bytes: int
    text: str


class RecorderProcess:
    """Records one bag at a time.

    Args:
        bags: where.
        namespace: of the crane, "/" or "/name".
    """

    def __init__(self, bags: BagDirectory, namespace: str = "/") -> None:
        self._bags, self._namespace = bags, namespace
        self._process: subprocess.Popen[bytes] | None = None
        self._log = os.memfd_create("recorder")  # of its lines: a full disk must not swallow its last words
        self._read = 0  # bytes of the log
        self._path: Path | None = None  # of the bag, or of the last one
        self._begun = self._ended = 0.0  # monotonic [s]
        self._text, self._heard = "Nothing is recorded.", False  # whether it is the recorder's own
        self._changing = asyncio.Lock()

    @property
    def active(self) -> bool:
        """Whether a recorder runs."""
        return self._process is not None

    @property
    def _name(self) -> str:
        return "" if self._path is None else self._path.name

    async def start(self, name: str | None = None) -> str:
        """Begin a bag; return a sentence.

        Args:
            name: of the bag, below the directory; None: date and time.

        Raises:
            BagError: one is recorded already, the name is not allowed, or the recorder does not start.
        """
        async with self._changing:
            if self.active:
                raise BagError(f"{self._name} is recorded already; allowed: stop it first")
            path = self._bags.new(name)
            self._launch(path)
            deadline = time.monotonic() + STARTED_S
            while self.state().active and not path.exists():
                if time.monotonic() > deadline:
                    await self._end()
                    raise BagError(f"the recorder did not begin {path.name} within {STARTED_S:g} s")
                await asyncio.sleep(POLL_S)
            if not self.active:
                raise BagError(self._text)
            return f"Recording to {path.name}."

    async def stop(self) -> str:
        """End the bag; return what it holds, as a sentence.

        Raises:
            BagError: nothing is recorded.
        """
        async with self._changing:
            if not self.active:
                raise BagError("nothing is recorded; allowed: start a recording first")
            await self._end()
            return self._text

    async def close(self) -> None:
        """End the bag, if there is one, with the station."""
        if self.active:
            with contextlib.suppress(BagError):
                await self.stop()
        os.close(self._log)

    def state(self) -> RecordingState:
        """Return how it is going; notices a recorder that ended by itself."""
        if self._process is not None:
            self._take_lines()
            if (code := self._process.poll()) is not None:
                self._over(code)
        until = time.monotonic() if self.active else self._ended
        path = self._path
        size = sum(file.stat().st_size for file in path.iterdir()) if path and path.is_dir() else 0
        return RecordingState(self.active, self._name, until - self._begun, size, self._sentence())

    def _launch(self, path: Path) -> None:
        self._bags.path.mkdir(parents=True, exist_ok=True)
        names = ["-r", f"__node:={NODE}", "-r", f"__ns:={self._namespace}"]
        argv = [
            sys.executable,
            "-m",
            "forest_bag.recorder_node",
            "--ros-args",
            *names,
            "-p",
            f"output:={path}",
        ]
        environment = {**os.environ, PARENT_VARIABLE: str(os.getpid())}
        # A session of its own: Ctrl-C in the station's terminal is for the station, which then ends the bag.
        self._process = subprocess.Popen(
            argv,
            stdin=subprocess.PIPE,
            stdout=self._log,
            stderr=self._log,
            env=environment,
            start_new_session=True,
        )
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError), self._process.stdin as go:
            go.write(b"1")
        self._path, self._begun = path, time.monotonic()
        self._text, self._heard = "The recorder starts.", False

    async def _end(self) -> None:
        """Ask the process to end; kill it only if it does not: its bag is readable even then."""
        assert self._process is not None
        self._process.send_signal(signal.SIGINT)
        deadline = time.monotonic() + ENDED_S
        while self.state().active:
            if time.monotonic() > deadline and self._process is not None:
                self._process.kill()
            await asyncio.sleep(POLL_S)

    def _over(self, code: int) -> None:
        self._take_lines()
        self._process, self._ended = None, time.monotonic()
        if code < 0:
            what_is_left = f"All but the last {FLUSH_PERIOD_S:g} s of {self._name} can be read"
            killed = f"The recorder was ended by {signal.Signals(-code).name}."
            self._text = f"{killed} {what_is_left}; `forest-bag recover` makes it whole."
        elif code > 0 and not self._heard:
            self._text = f"The recorder ended with exit code {code}."

    def _take_lines(self) -> None:
        """Keep the recorder's last line: it says how it goes and, at the end, what the bag holds."""
        data = os.pread(self._log, 1 << 16, self._read)
        whole = data[: data.rfind(b"\n") + 1]
        self._read += len(whole)
        for line in whole.decode("utf-8", "replace").splitlines():
            if text := _LOG_LINE.sub("", line).strip():
                self._heard = True
                self._text = text.replace(str(self._path), self._name)

    def _sentence(self) -> str:
        if not self.active:
            return self._text
        free = shutil.disk_usage(self._bags.path).free
        return f"Only {free / 1e9:.1f} GB of the disk are free." if free < LITTLE_DISK else self._text
