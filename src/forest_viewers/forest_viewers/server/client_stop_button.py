"""The one thing that clients may publish: an emergency stop."""

from collections.abc import Callable

from forest_msgs_py.interfaces import topics
from forest_msgs_py.serialization.cdr import CdrError, cdr_type
from forest_viewers.server.client_requests import Published


class StopButton:
    """Takes what clients publish.

    Args:
        topic: resolved name of the emergency stop.
        press: stops the crane.
        warn: shows a sentence to the clients.
    """

    def __init__(self, topic: str, press: Callable[[], object], warn: Callable[[str], object]) -> None:
        self._topic, self._press, self._warn = topic, press, warn

    def hear(self, said: Published) -> None:
        """Stop the crane if this is true on the topic; say why nothing is done with anything else."""
        if said.topic != self._topic:
            self._warn(f"{said.topic} is not taken from here; allowed: {self._topic}")
            return
        try:
            pressed = bool(cdr_type(topics.EMERGENCY_STOP.type).decode(said.data).data)
        except CdrError as error:
            self._warn(f"{said.topic}: {error}")
            return
        if pressed:
            self._press()
        else:
            self._warn(f"{said.topic} takes true; to reset, call the service reset_emergency_stop")
