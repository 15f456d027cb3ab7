"""Log times by /clock in place of the system's clock: a recorder's --use-sim-time."""

from collections.abc import Callable, Iterable
from typing import Protocol

from forest_bag.write.transient_local import is_transient_local
from forest_msgs_py.clock.step_listener import Offered, Wanted
from forest_msgs_py.interfaces.stamps import stamp_in
from forest_msgs_py.interfaces.topics import CLOCK
from forest_msgs_py.introspection.graph_listener import DiscoveredTopic, ReceivedMessage


class Listener(Protocol):
    """What hears the topics of a graph."""

    pause: float  # [s] between two takes

    def look(self) -> None:
        """Subscribe to what has appeared since the last look."""

    def take(self) -> list[ReceivedMessage]:
        """Return what has arrived since the last time, in the order of arrival."""

    def context_ns(self) -> int:
        """Log time of what is told now beside messages [ns]."""


class SimTimeListener:
    """A listener that gives each message the last time on /clock before it.

    Before the first time, only what transient-local topics say is kept: it is said once. It gets the
    first time.

    Args:
        make: makes the listener, of what is wanted and what is called with a topic.
        wanted: whether a topic is to be recorded; /clock is heard in any case.
        offered: called with a topic that is to be recorded.
    """

    def __init__(self, make: Callable[[Wanted, Offered], Listener], wanted: Wanted, offered: Offered) -> None:
        self._wanted, self._offered = wanted, offered
        self._now_ns: int | None = None
        self._said_once: set[str] = set()  # transient-local topics
        self._early: list[ReceivedMessage] = []
        self._listener = make(lambda name, types: name == CLOCK.name or wanted(name, types), self._meet)
        self.pause = self._listener.pause
        self.look, self.context_ns = self._listener.look, self._listener.context_ns

    def take(self) -> list[ReceivedMessage]:
        """Return what has arrived since the last time, under simulated time."""
        return self.stamped(self._listener.take())

    def stamped(self, heard: Iterable[ReceivedMessage]) -> list[ReceivedMessage]:
        """Return messages, in the order of arrival, under simulated time."""
        told: list[ReceivedMessage] = []
        for message in heard:
            if message.name == CLOCK.name:
                self._now_ns = stamp_in(CLOCK.type, message.data)
            if self._now_ns is None:
                self._early += [message] * (message.name in self._said_once)
                continue
            due, self._early = [*self._early, message], []
            now = self._now_ns
            told += [m._replace(received_ns=now) for m in due if self._wanted(m.name, ())]
        return told

    def _meet(self, offer: DiscoveredTopic) -> None:
        if is_transient_local(offer.profiles):
            self._said_once.add(offer.name)
        if self._wanted(offer.name, ()):
            self._offered(offer)
