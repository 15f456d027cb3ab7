"""A joystick that is played from a source: the thesis' test input, a CSV of levers, or a bag.

Levers of the test input and of a CSV rest for `LEAD_IN`, play with the deadman held, and rest with
the deadman released for `LEAD_OUT`. A bag's messages are repeated as they are. Faults act at set
times.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from forest_control.operator.joystick_bag import JoyRecord, is_bag, read_joy_record
from forest_control.operator.joystick_fault_injection import (
    BAD,
    FROZEN,
    LOST,
    RELEASED,
    faults_at,
    parse_joystick_faults,
)
from forest_control.operator.joystick_sources import (
    LEAD_IN,
    LEAD_OUT,
    THESIS_DURATION,
    JoystickParameters,
    LeverRecord,
    read_levers,
    thesis_levers,
)
from forest_control.operator.joystick_watch import HEARTBEAT
from forest_control.operator.levers import BUTTON_COUNT, REST, Levers, axes_from_levers
from forest_msgs_py.runtime.parameter_table import ParameterError
from forest_msgs_py.types import NS_PER_S


class JoyMessage(NamedTuple):
    """A Joy message without its stamp."""

    frame: str
    axes: tuple[float, ...]
    buttons: tuple[int, ...]


class ScriptedJoystick:
    """What a joystick sends, by the time since it began.

    Args:
        p: source and faults.
        decode: makes a message of a bag's bytes.

    Raises:
        ParameterError: the faults are none.
        LeverError: the source cannot be read.
    """

    def __init__(self, p: JoystickParameters, decode: Callable[[bytes], JoyMessage]) -> None:
        try:
            self._faults = parse_joystick_faults(p.faults)
        except ValueError as error:
            raise ParameterError(f"parameter 'faults': {error}") from error
        self._p, self._decode = p, decode
        self._levers: LeverRecord | None = None
        self._bag: JoyRecord | None = None
        length, path = THESIS_DURATION, Path(p.source)
        if p.source != "thesis" and is_bag(path):
            self._bag = read_joy_record(path)
            length = self._bag.length
        elif p.source != "thesis":
            self._levers = read_levers(path)._replace(interpolated=p.interpolate)
            length = self._levers.times[-1]
        self.length = p.duration or length  # [s] of playing
        self._count, self._place = 0, -1
        self._last: JoyMessage | None = None

    def message(self, elapsed: float) -> JoyMessage | None:
        """Return the message at a time [s], or None: nothing is sent."""
        message = self._repeated(elapsed) if self._bag else self._played(elapsed - LEAD_IN)
        faults = faults_at(self._faults, elapsed)
        if FROZEN in faults and self._last is not None:
            message = self._last
        if message is None or LOST in faults:
            return None
        if RELEASED in faults:
            deadman = self._p.deadman_button
            buttons = tuple(down * (place != deadman) for place, down in enumerate(message.buttons))
            message = message._replace(buttons=buttons)
        if BAD in faults:
            message = message._replace(axes=(math.nan,) * len(message.axes))
        self._last = message
        return message

    def is_over(self, elapsed: float) -> bool:
        """Tell whether nothing follows after a time [s]."""
        if self._bag:
            return elapsed > self.length
        return elapsed - LEAD_IN >= self.length + LEAD_OUT

    def released(self) -> JoyMessage:
        """Return the last words: levers at rest, deadman released."""
        return self._made(REST, False)

    def _played(self, time: float) -> JoyMessage:
        """Return the message at a time [s] of the levers' source."""
        if not 0.0 <= time < self.length:
            return self._made(REST, time < self.length)
        levers = self._levers.at(time) if self._levers else thesis_levers(time, self._p.tip_speed)
        return self._made(levers, True)

    def _made(self, levers: Levers, held: bool) -> JoyMessage:
        self._count += 1  # a script may hold still for ever: the heartbeat tells that it lives
        buttons = tuple(int(held and place == self._p.deadman_button) for place in range(BUTTON_COUNT))
        return JoyMessage(f"{HEARTBEAT}{self._count}", axes_from_levers(levers), buttons)

    def _repeated(self, elapsed: float) -> JoyMessage | None:
        """Return the bag's message at a time [s], or None if it has been sent."""
        assert self._bag is not None
        place = self._bag.newest(round(elapsed * NS_PER_S))
        if place == self._place:
            return None
        self._place = place
        return self._decode(self._bag.messages[place])
