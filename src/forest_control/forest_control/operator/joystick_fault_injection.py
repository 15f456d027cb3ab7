"""Faults of a joystick, as people write them: `lost from 3 s until 4 s; frozen from 6 s`.

Faults stand one after the other, separated by `;` or a line's end. Each is a word

| word | the joystick |
|---|---|
| `lost` | publishes nothing |
| `frozen` | repeats its last message under new stamps |
| `released` | releases the deadman, levers as they are |
| `bad` | sends levers that are no numbers |

and may end in `from NUMBER s`, `until NUMBER s` (or `to`), or both: time since the source's first
message, in lockstep simulated time.
"""

import math
import re
from typing import NamedTuple

LOST, FROZEN, RELEASED, BAD = WORDS = ("lost", "frozen", "released", "bad")
NUMBER = r"\+?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
FORM = re.compile(
    rf"(?P<word>[a-z]+)(?:\s+from\s+(?P<start>{NUMBER})\s*s)?(?:\s+(?:until|to)\s+(?P<end>{NUMBER})\s*s)?"
)
ALLOWED = f"{', '.join(WORDS)}; each with 'from NUMBER s', 'until NUMBER s' or both after it"


class JoystickFault(NamedTuple):
    """One fault: a word, and from when until when [s]."""

    word: str
    start: float
    end: float


def parse_joystick_faults(text: str) -> tuple[JoystickFault, ...]:
    """Return the faults that a text names; an empty text names none.

    Raises:
        ValueError: an entry is no fault; the text says what is allowed.
    """
    entries = (" ".join(entry.split()) for entry in re.split(r"[;\n]", text))
    return tuple(_fault(entry) for entry in entries if entry)


def _fault(entry: str) -> JoystickFault:
    form = FORM.fullmatch(entry)
    if form is None or form["word"] not in WORDS:
        raise ValueError(f"'{entry}' is no fault of a joystick; allowed: {ALLOWED}")
    start = float(form["start"] or 0.0)
    end = float(form["end"] or math.inf)
    if not start < end:
        raise ValueError(f"'{entry}': from {start:g} s until {end:g} s; allowed: a later end")
    return JoystickFault(form["word"], start, end)


def faults_at(faults: tuple[JoystickFault, ...], time: float) -> frozenset[str]:
    """Return the words of the faults that hold at a time [s]."""
    return frozenset(fault.word for fault in faults if fault.start <= time < fault.end)
