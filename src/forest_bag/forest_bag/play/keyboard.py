"""Single keys from a terminal, which is put back as it was however the program ends."""

import contextlib
import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Callable, Mapping
from types import TracebackType

NAMES = {
    "\x1b[A": "up",
    "\x1b[B": "down",
    "\x1b[C": "right",
    "\x1b[D": "left",
    "\x1bOA": "up",
    "\x1bOB": "down",
    "\x1bOC": "right",
    "\x1bOD": "left",
    " ": "space",
}
LONGEST = max(map(len, NAMES))


class Keyboard:
    """Calls an action for each key; a context manager.

    Without a terminal, or in the background (reading would stop the process), it does nothing. Ctrl-C and
    Ctrl-Z keep their meaning.

    Args:
        actions: what to do by key: a character, "space", "up", "down", "left" or "right".
        descriptor: of the terminal; None: standard input.
    """

    def __init__(self, actions: Mapping[str, Callable[[], object]], descriptor: int | None = None) -> None:
        self._actions = actions
        self._terminal = descriptor
        self._before: list[object] | None = None
        self._wake = os.pipe()
        self._thread = threading.Thread(target=self._watch, name="keyboard", daemon=True)

    @property
    def active(self) -> bool:
        """Whether there is a terminal to read."""
        return self._before is not None

    def __enter__(self) -> "Keyboard":
        """Take the terminal, if there is one and this process has it."""
        with contextlib.suppress(OSError, ValueError, termios.error):
            terminal = sys.stdin.fileno() if self._terminal is None else self._terminal
            if os.isatty(terminal) and os.tcgetpgrp(terminal) == os.getpgrp():
                before = termios.tcgetattr(terminal)
                tty.setcbreak(terminal)
                self._terminal, self._before = terminal, before
                self._thread.start()
        return self

    def __exit__(
        self, _type: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        """Put the terminal back."""
        os.write(self._wake[1], b".")
        if self._before is not None and self._terminal is not None:
            self._thread.join()
            with contextlib.suppress(termios.error):
                termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)  # type: ignore[arg-type]
        for end in self._wake:
            os.close(end)

    def _watch(self) -> None:
        assert self._terminal is not None
        while True:
            ready, _, _ = select.select([self._terminal, self._wake[0]], [], [])
            if self._wake[0] in ready:
                return
            try:
                text = os.read(self._terminal, 64).decode("utf-8", "replace")
            except OSError:
                return
            if not text:
                return
            for key in split_keys(text):
                if (action := self._actions.get(key)) is not None:
                    action()


def split_keys(text: str) -> list[str]:
    """Keys in what a terminal sent; several may come at once, and a cursor key is three characters."""
    keys = []
    while text:
        sequence = next((s for s in NAMES if text.startswith(s)), text[0])
        keys.append(NAMES.get(sequence, sequence))
        text = text[len(sequence) :]
    return keys
