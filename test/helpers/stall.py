"""What a busy machine keeps from processes: it is none of their faults, and no claim is about it.

Linux tells of every thread how long it was ready to run and did not get a processor (schedstat, 2nd number).
"""

from __future__ import annotations

import contextlib
import math
import os
import time
from pathlib import Path

PERIOD_S = 0.05  # between readings: reading must not be what the machine is busy with


class Stall:
    """Time for which threads of processes, and of this one, waited for a processor from now on [s]."""

    def __init__(self, *pids: int) -> None:
        self._pids, self._seen, self._readings = (os.getpid(), *pids), {}, []
        self._read()

    def look(self) -> bool:
        """Read now and then, for threads that end tell no more; always true, to stand before a condition."""
        if time.monotonic() - self._readings[-1][0] > PERIOD_S:
            self._read()
        return True

    def seconds(self, until: float = math.inf) -> float:
        """Sum over the threads, as one may have waited for the other, until a time [s, time.monotonic]."""
        self._read()
        waited = next((waited for at, waited in self._readings if at >= until), self._readings[-1][1])
        return waited - self._readings[0][1]

    def _read(self) -> None:
        for pid in self._pids:
            for task in _tasks(pid):
                # A thread that has just ended tells nothing; some kernels do not count at all.
                with contextlib.suppress(OSError, IndexError):
                    self._seen[task] = int((task / "schedstat").read_text().split()[1]) * 1e-9
        self._readings.append((time.monotonic(), sum(self._seen.values())))


def _tasks(pid: int) -> list[Path]:
    try:
        return list(Path(f"/proc/{pid}/task").iterdir())
    except OSError:
        return []
