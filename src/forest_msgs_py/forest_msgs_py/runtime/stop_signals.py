"""Signals by which people and systems ask a process to stop: all end it in order, with its files closed."""

import signal
from collections.abc import Sequence

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # Ctrl-C, `timeout`, a terminal that closes


def heeded(numbers: Sequence[signal.Signals] = STOP_SIGNALS) -> tuple[signal.Signals, ...]:
    """Return those of some signals that are to stop this process; `nohup` has it ignore the hang-up."""
    kept = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    return tuple(number for number in numbers if not (kept and number == signal.SIGHUP))
