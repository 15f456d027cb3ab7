"""When the thermocouples change over from ice to boiling water."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from forest_bringup.terminal import Question
from forest_ident.estimators import calibration


class Recorded(Exception):
    """Both baths are done."""


class Baths:
    """The thermocouples in ice, on their way, in boiling water; the supervisor watches on meanwhile.

    Thesis section 4.3.1.

    Args:
        tell: told how far it is [s].
        sure: the change needs no confirmation.
    """

    def __init__(self, tell: Callable[[float], None], sure: bool) -> None:
        self.marks: list[int] = []  # [ns] when ice ended, and boiling water began
        self._tell, self._sure = tell, sure
        self._begun = math.nan
        self._question: Question | None = None

    def watch(self) -> None:
        """Go on to the next bath when it is time and somebody says so.

        Raises:
            Recorded: both baths are done.
            SessionError: nobody can say so any more.
        """
        if self._question is not None:
            if self._question.answered():
                self._question, self._begun = None, time.monotonic()
                self.marks.append(time.time_ns())
            return
        if math.isnan(self._begun):
            self._begun = time.monotonic()
        elapsed = time.monotonic() - self._begun
        self._tell(elapsed + calibration.EACH * bool(self.marks))
        if elapsed < calibration.EACH:
            return
        if self.marks:
            raise Recorded
        self.marks.append(time.time_ns())
        if self._sure:
            self.marks.append(self.marks[0])
            self._begun = time.monotonic()
        else:
            self._question = Question("\n  Now the thermocouples into boiling water; then press Enter: ")
