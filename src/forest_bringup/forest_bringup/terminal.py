"""Questions to the person at the terminal. What was typed before a question is no answer to it."""

from __future__ import annotations

import contextlib
import select
import sys
import termios

from forest_ident.measurements.session import SessionError

NOBODY = "nobody answers at this terminal any more"


def ask(question: str) -> str:
    """Return a person's answer, without blanks around it.

    Raises:
        SessionError: the input has ended.
    """
    _forget_typed()
    try:
        return input(question).strip()
    except EOFError:
        print(flush=True)
        raise SessionError(NOBODY) from None


class Question:
    """A question that is answered by Enter while the program has other things to watch."""

    def __init__(self, text: str) -> None:
        _forget_typed()
        print(text, end="", flush=True)

    def answered(self) -> bool:
        """Tell whether Enter was pressed since; does not wait.

        Raises:
            SessionError: the input has ended.
        """
        if not select.select([sys.stdin], [], [], 0.0)[0]:
            return False
        if not sys.stdin.readline():
            print(flush=True)
            raise SessionError(NOBODY)
        return True


def _forget_typed() -> None:
    with contextlib.suppress(OSError, ValueError, termios.error):
        termios.tcflush(sys.stdin, termios.TCIFLUSH)
