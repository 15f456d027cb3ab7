"""What the node for taught work hears and tells: conversions only, which decide nothing."""

from typing import Any

from forest_control.operator.levers import RIGHT_Y
from forest_control.taught.taught_work import Seen, TaughtWork
from forest_description.types import Vec3
from forest_msgs_py.interfaces import topics
from forest_msgs_py.serialization.unpacking import ArrayReader, read_joy_data
from forest_msgs_py.types import NS_PER_S

STATUS_TIMEOUT = 0.1  # [s] at which the controller counts as not armed: as its state_timeout


class CycleInputs:
    """The joystick, and whether the controller lets it move the crane.

    Args:
        clock: of the node, whose subscriptions are used.
        centre: deflection of a stick that counts as none.
        button: the joystick's, that waits for a person.
    """

    def __init__(self, clock: Any, centre: float, button: int = 0) -> None:
        self._clock, self._centre, self._button = clock, centre, button
        self._joy = clock.polled_subscription(topics.JOY)
        self._sticks, self._down = (0.0,), True  # whether the button is
        self._controller = clock.polled_subscription(topics.CONTROLLER_STATUS)
        self._reader = ArrayReader(topics.CONTROLLER_STATUS, ("armed",))
        self._armed, self._sent = False, 0.0

    def seen(self, tip: Vec3, stamp: int) -> Seen:
        """Return what crane and operator do, with the tip at a place [m] at a stamp [ns]."""
        pressed = self._read_joystick()
        centred = max(map(abs, self._sticks)) <= self._centre
        return Seen(tip, stamp / NS_PER_S, self._is_armed(), centred, pressed)

    def _read_joystick(self) -> bool:
        """Take in where the sticks are; tell whether the button was pressed."""
        pressed = False
        for data, _ in self._joy.arrivals():
            reading, _ = read_joy_data(data, RIGHT_Y + 1, self._button + 1)
            if not reading.problem:
                axes, buttons = reading.values
                self._sticks, down = axes[: RIGHT_Y + 1], buttons[self._button] == 1
                pressed, self._down = pressed or (down and not self._down), down
        return pressed

    def _is_armed(self) -> bool:
        """Tell whether the controller lets the levers move the crane, by its newest word."""
        if arrival := self._controller.newest():
            reading = self._reader.read(arrival.message, 0)
            self._armed, self._sent = not reading.problem and reading.values == (1.0,), arrival.time
        return self._armed and self._clock.now() - self._sent <= STATUS_TIMEOUT


class Report:
    """What a person is waited for, as a source of /diagnostics.

    Args:
        work: that is told of.
    """

    def __init__(self, work: TaughtWork) -> None:
        self.waiting, self.values = work.waiting, work.values
        self._told: tuple[str, dict[str, Any]] | None = None

    def unheard(self) -> str:
        """Return "": whether a controller is heard, the work itself tells when it is asked for."""
        return ""

    def has_changed(self) -> bool:
        """Tell whether there is something else to tell than when this was asked last."""
        before, self._told = self._told, (self.waiting(), self.values())
        return self._told != before
