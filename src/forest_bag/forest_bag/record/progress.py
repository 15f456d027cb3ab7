"""How a recording is going, in one line that overwrites itself, or in a line now and then."""

import sys
from collections.abc import Callable

from forest_msgs_py.runtime.command_line import StatusLine

TERMINAL_PERIOD = 0.5  # [s]
LOG_PERIOD = 10.0  # [s]


def status_line(seconds: float, size: int, messages: int, rate: float, lost: int) -> str:
    """Return duration, size, rate and losses as text."""
    minutes, rest = divmod(seconds, 60.0)
    hours, minutes = divmod(int(minutes), 60)
    clock = f"{hours:d}:{minutes:02d}:{rest:04.1f}"
    return f"{clock}, {size / 1e6:.2f} MB, {messages} messages, {rate:.0f}/s, lost {lost}"


class RecordingStatus:
    """Shows how the recording is going when it is time to.

    Args:
        log: takes a line, where there is no terminal.
        now: of the start [s].
    """

    def __init__(self, log: Callable[[str], object], now: float) -> None:
        self._line = StatusLine(sys.stdout, log)
        self._period = TERMINAL_PERIOD if self._line.terminal else LOG_PERIOD
        self._begin, self._last, self._messages = now, now, 0

    def due(self, now: float) -> bool:
        """Whether it is time."""
        return now - self._last >= self._period

    def show(self, now: float, size: int, messages: int, lost: int) -> None:
        """Show it."""
        rate = max(0, messages - self._messages) / (now - self._last) if now > self._last else 0.0
        self._last, self._messages = now, messages
        self._line.show(status_line(now - self._begin, size, messages, rate, lost))

    def end(self) -> None:
        """Leave the terminal's line as it is, and go to the next."""
        self._line.end()
