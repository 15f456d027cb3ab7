"""Log times by /clock in place of the system's clock: a recorder's --use-sim-time."""

from collections.abc import Iterable

from forest_msgs_py.interfaces.stamps import stamp_in
from forest_msgs_py.interfaces.topics import CLOCK
from forest_msgs_py.introspection.graph_listener import ReceivedMessage


class SimTime:
    """Gives each message the last time on /clock before it.

    Before the first time, only what transient-local topics say is kept: it is said once. It gets the
    first time.

    Args:
        keeps_clock: whether /clock is to be recorded, too.
    """

    def __init__(self, keeps_clock: bool) -> None:
        self._keeps_clock = keeps_clock
        self._now_ns: int | None = None
        self._said_once: set[str] = set()  # transient-local topics
        self._early: list[ReceivedMessage] = []

    def keep(self, name: str) -> None:
        """Learn that a topic is transient local."""
        self._said_once.add(name)

    def stamped(self, heard: Iterable[ReceivedMessage]) -> list[ReceivedMessage]:
        """Return messages in the order of arrival under simulated time."""
        told: list[ReceivedMessage] = []
        for message in heard:
            is_clock = message.name == CLOCK.name
            if is_clock:
                self._now_ns = stamp_in(CLOCK.type, message.data)
            if self._now_ns is None:
                self._early += [message] * (message.name in self._said_once)
                continue
            due, self._early = [*self._early, message], []
            now = self._now_ns
            told += [m._replace(received_ns=now) for m in due if self._keeps_clock or m.name != CLOCK.name]
        return told
