"""What a busy machine keeps from processes: it is none of their faults, and no claim is about it.

Linux tells of every thread how long it was ready to run and did not get a processor (schedstat, 2nd number).
"""

from __future__ import annotations

import os
import time
from pathlib import Path

PERIOD_S = 0.05  # between readings: reading must not be what the machine is busy with


class Stall:
    """Time for which threads of processes, and of this one, waited for a processor from now on [s]."""

    def __init__(self, *pids: int) -> None:
        tasks = [task for pid in (os.getpid(), *pids) for task in Path(f"/proc/{pid}/task").iterdir()]
        self._first = {task: _waited(task) for task in tasks}
        self._last, self._looked = dict(self._first), time.monotonic()

    def look(self) -> bool:
        """Read now and then, for threads that end tell no more; always true, to stand before a condition."""
        if time.monotonic() - self._looked > PERIOD_S:
            self._read()
        return True

    def seconds(self) -> float:
        """Sum over the threads: one may have waited for the other."""
        self._read()
        return sum(self._last[task] - first for task, first in self._first.items())

    def _read(self) -> None:
        self._looked = time.monotonic()
        for task, last in self._last.items():
            self._last[task] = max(last, _waited(task))


def _waited(task: Path) -> float:
    try:
        return int((task / "schedstat").read_text().split()[1]) * 1e-9
    except (OSError, IndexError):  # the thread has ended, or the kernel does not count
        return 0.0
