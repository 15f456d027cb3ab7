"""Which share of the processor a graph's processes get beside other programs.

A control loop of 200 Hz that waits for its turn behind other programs is late, and a busy computer has them
wait for tenths of a second. Root, and whoever `limits.conf` or a container allows it, may take precedence;
for others nothing changes, and nothing is said.
"""

import contextlib
import os
from pathlib import Path

URGENT = -10  # about ten times the share of a program that asks for nothing


def set_priority(process: int, nice: int) -> None:
    """Give a process that has no threads yet, and its session, a priority; if not allowed, do nothing.

    Linux may share the processor between sessions first (autogroups), and each of our nodes has its own: then
    the session's priority counts, and a new session starts without any.

    Args:
        process: its id, which leads a session.
        nice: from -20, which comes first, to 19.
    """
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, process, nice)
    with contextlib.suppress(OSError):
        Path(f"/proc/{process}/autogroup").write_text(str(nice), encoding="ascii")


def own_priority() -> int:
    """Return how nice this process is."""
    return os.getpriority(os.PRIO_PROCESS, 0)
