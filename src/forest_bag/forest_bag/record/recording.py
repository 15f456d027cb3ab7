"""What the recorder node does with a session, one thread at a time; a full disk ends it."""

import threading
import time
from collections.abc import Callable, Iterable

from forest_bag.record.progress import RecordingStatus
from forest_bag.write.bag_session import Session
from forest_bag.write.bag_writer import FLUSH_PERIOD_S
from forest_msgs_py.introspection.graph_listener import ReceivedMessage
from forest_msgs_py.runtime.node import NodeFailure

LOGS = ("/rosout", "/parameter_events")  # the recorder hears its own words there before anybody is found


class Refusal(Exception):
    """What was asked cannot be done now; the text says why."""


class Recording:
    """A session that several threads use.

    Args:
        session: what is recorded.
        take: what has arrived since it was called last.
        log: takes lines for the log.
    """

    def __init__(
        self, session: Session, take: Callable[[], Iterable[ReceivedMessage]], log: Callable[[str], object]
    ) -> None:
        self.session = session
        self._take, self._log = take, log
        self._lock = threading.RLock()
        self._failure: NodeFailure | None = None
        self._flushed = 0.0
        self._begun = self._said_so = False  # somebody was heard; it was said that this is recorded
        self._status = RecordingStatus(log, time.monotonic())

    def turn(self) -> None:
        """Write what has arrived; flush the first of it at once, then now and then; say how it is going.

        Raises:
            NodeFailure: the disk is full.
        """
        with self._lock:
            if self._failure is not None:
                raise self._failure
            now = time.monotonic()
            self.guard(self._drain)
            begins = self._begun and not self._said_so
            if begins or now - self._flushed >= FLUSH_PERIOD_S:
                self._flushed = now
                self.guard(self.session.flush)
            if begins:
                self._said_so = True
                self._log(f"recording to {self.session.directory}")
            if self._status.due(now):
                lost = sum(self.session.lost.values())
                self._status.show(now, self.session.size, self.session.message_count, lost)

    def guard(self, action: Callable[[], object]) -> None:
        """Do something with the session.

        Raises:
            NodeFailure: the disk is full; the bag is closed, and what it holds is named.
        """
        with self._lock:
            try:
                action()
            except OSError as error:
                self._failure = self._give_up(error)
                raise self._failure from error

    def _give_up(self, error: OSError) -> NodeFailure:
        place = self.session.directory
        hint = ""
        try:
            self.session.stop()
        except OSError:
            hint = f"; `forest-bag recover {place}` makes it whole"
        reason = error.strerror or error
        return NodeFailure(
            f"cannot write the bag in {place}: {reason}; it ends after {self.session.written} messages{hint}"
        )

    def end(self) -> None:
        """Close the bag and say what was lost of which topic.

        Raises:
            NodeFailure: the disk is full.
        """
        self._status.end()
        if self._failure is None and self.session.recording:
            self._log(self.stop())

    def start(self) -> str:
        """Begin a take.

        Raises:
            Refusal: one is open, or there is no place for it.
        """
        with self._lock:
            if self.session.recording:
                raise Refusal(f"recording already, to {self.session.directory}")
            try:
                directory = self.session.start()
                self._begun = self._said_so = True
                return f"recording to {directory}"
            except OSError as error:
                raise Refusal(f"cannot record: {error}") from error

    def stop(self) -> str:
        """Close the take.

        Raises:
            Refusal: none is open.
            NodeFailure: the disk is full.
        """
        with self._lock:
            self._drained()
            session, lost = self.session, self.session.lost
            self.guard(session.stop)
        each = "".join(f", {missed} of {name}" for name, missed in sorted(lost.items()) if missed)
        total = sum(lost.values())
        place = session.directory
        return (
            f"recorded {session.written} messages, {session.topic_count} topics, lost {total}{each}: {place}"
        )

    def split(self) -> str:
        """Begin the next file; refusals and failures as `stop`."""
        with self._lock:
            self._drained()
            self.guard(self.session.split)
            return f"the next file of {self.session.directory} begins"

    def snapshot(self) -> str:
        """Write the last seconds; refusals and failures as `stop`."""
        with self._lock:
            self._drained()
            count = self.session.waiting
            if not count:
                raise Refusal("no message waits; allowed: with parameter 'snapshot_seconds' above 0")
            self.guard(self.session.snapshot)
            return f"wrote the last {count} messages to {self.session.directory}"

    def demand_take(self) -> None:
        """Refuse what makes no sense without an open take.

        Raises:
            Refusal: none is open.
        """
        if not self.session.recording:
            raise Refusal("not recording")

    def _drained(self) -> None:
        self.demand_take()
        self.guard(self._drain)

    def _drain(self) -> None:
        """Write what has arrived since the last time, in the order of arrival."""
        session = self.session
        for received, name, data, sent, sequence, missed in self._take():
            session.write(name, data, received, sent, sequence)
            session.missed(name, missed)
            self._begun = self._begun or (session.recording and name not in LOGS)


def answered(verb: Callable[[], str], say: Callable[[str], object]) -> Callable[[], tuple[bool, str]]:
    """Return the action of a service: success and what the verb tells, or why not; `say` logs it."""

    def answer() -> tuple[bool, str]:
        try:
            told = True, verb()
        except (NodeFailure, Refusal) as error:  # a failure ends the node at its next turn
            told = False, str(error)
        say(told[1])
        return told

    return answer
