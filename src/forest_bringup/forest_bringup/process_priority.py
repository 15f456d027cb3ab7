"""Live nodes come before other programs, where the user may ask for that.

A control loop of 200 Hz that waits for its turn behind other programs is late, and a busy computer has them
wait for tenths of a second. Root, and whoever `limits.conf` or a container allows it, may take precedence;
for others nothing changes, and nothing is said.
"""

import contextlib
import os
from pathlib import Path

NICE = -10  # about ten times the share of a program that asks for nothing


def raise_priority(process: int) -> None:
    """Give a process precedence, by its id, before it has threads; where that is not allowed, do nothing.

    Linux may share the processor between sessions first (autogroups), and each of our nodes has its own: then
    the session's precedence counts, not the process'.
    """
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, process, NICE)
    with contextlib.suppress(OSError):
        Path(f"/proc/{process}/autogroup").write_text(str(NICE), encoding="ascii")
