"""Playing a bag in time: the core of `forest-bag play`, without ROS.

===============  ===========================================================================================
symbol           meaning
===============  ===========================================================================================
bag time         log time of what is being played, ns
wall time        monotonic clock, ns
anchor           a wall time and the bag time that belonged to it; made anew by pause, rate and seek
rate             seconds of bag time per second of wall time; 0: as fast as possible
due              wall time of a message: anchor_wall + (log time - anchor_bag) / rate
lateness         wall time at which a message is handed over minus its due time
===============  ===========================================================================================

Due times are absolute, so that lateness never adds up. A player that is `LAG_NS` late was suspended or cannot
keep up: it goes on from there rather than pour out what it has missed.
"""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from typing import NamedTuple, Protocol

from forest_bag.play.lateness import Lateness
from forest_bag.storage.raw_messages import RawMessage
from forest_msgs_py.types import NS_PER_S

LAG_NS = NS_PER_S
ALL = sys.maxsize  # messages: more than any bag has
SHARES = (50, 99, 99.9)  # of the messages, in the summary [%]


class Plan(NamedTuple):
    """What to play; times are bag times, ns."""

    start_ns: int
    end_ns: int
    rate: float = 1.0
    loop: bool = False
    paused: bool = False
    clock_period_ns: int = 0  # wall time between two ticks of /clock; 0: none


class Source(Protocol):
    """A bag, as the player needs it."""

    def messages(self, start_ns: int) -> Iterator[RawMessage]:
        """Messages from a log time on, in order."""

    def transient_local(self, position_ns: int, renew: bool) -> list[RawMessage]:
        """What transient-local topics held at a log time; `renew`: where nothing yet, what comes first."""


class Sink(Protocol):
    """Where messages go."""

    def publish(self, message: RawMessage) -> None:
        """Send a message."""

    def clock(self, bag_ns: int) -> None:
        """Send the bag time."""


class WallClock:
    """The time outside of the bag."""

    def now(self) -> int:
        """Monotonic time, ns."""
        return time.monotonic_ns()

    def wait(self, condition: threading.Condition, seconds: float | None) -> None:
        """Wait until notified, or for some time."""
        condition.wait(seconds)


class Player:
    """Plays in the thread that calls `run`; every other method may be called from any thread."""

    def __init__(self, source: Source, sink: Sink, plan: Plan, wall: WallClock | None = None) -> None:
        self.lateness = Lateness()
        self.played = 0
        self.slips = 0  # times that the player was LAG_NS late
        self._source, self._sink, self._plan = source, sink, plan
        self._wall = wall or WallClock()
        self._changed = threading.Condition()
        self._rate, self._paused = plan.rate, plan.paused
        self._stopped = self._running = False
        self._steps = 0  # messages to be played although paused
        self._stepped = 0  # of them, played
        self._target: int | None = None  # bag time to go to
        self._anchor_wall = self._next_tick = self._wall.now()
        self._anchor_bag = plan.start_ns

    @property
    def paused(self) -> bool:
        """Whether it waits for `resume`."""
        return self._paused

    @property
    def rate(self) -> float:
        """Seconds of bag time per second; 0: as fast as possible."""
        return self._rate

    @property
    def position_ns(self) -> int:
        """Bag time now."""
        with self._changed:
            return self._bag_time(self._wall.now())

    def summary(self, stats: bool) -> str:
        """Say what was played and, with `stats`, how late."""
        told, late = [f"played {self.played} messages"], self.lateness
        if stats and late.count:
            shares = ", ".join(f"p{share:g} {1e3 * late.quantile(share / 100):.2f}" for share in SHARES)
            told.append(f"late by {shares}, at most {late.largest_ns / 1e6:.2f} ms")
        if self.slips:
            told.append(f"{self.slips} times over 1 s late: the process was stopped, or cannot keep up")
        return "; ".join(told)

    def pause(self) -> None:
        """Hold on before the next message."""
        self._change(paused=True)

    def resume(self) -> None:
        """Go on."""
        self._change(paused=False)

    def set_rate(self, rate: float) -> None:
        """Play at another rate from now on."""
        self._change(rate=rate)

    def seek(self, bag_ns: int) -> None:
        """Go to a bag time; one outside of what is played becomes its start or end."""
        with self._changed:
            self._target = min(max(bag_ns, self._plan.start_ns), self._plan.end_ns)
            self._changed.notify_all()

    def step(self) -> bool:
        """Play one message although paused; False if it is not paused."""
        with self._changed:
            self._steps += self._paused
            self._changed.notify_all()
            return self._paused

    def begin_burst(self, count: int) -> None:
        """Play so many messages at once although paused; 0: all to the end."""
        with self._changed:
            self._steps = count or ALL
            self._changed.notify_all()

    def burst(self, count: int) -> int:
        """Play so many messages at once; return how many there were: none if it is not paused or has ended.

        Args:
            count: 0: all to the end.
        """
        with self._changed:
            if not (self._paused and self._running):
                return 0
            before = self._stepped
            self.begin_burst(count)
            while self._steps and self._running:
                self._changed.wait()
            return self._stepped - before

    def stop(self) -> None:
        """End `run` at once."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def run(self) -> None:
        """Play to the end, or until stopped.

        Raises:
            Damaged: bytes of the bag were changed.
        """
        self._running = True
        try:
            self._run()
        finally:
            with self._changed:
                self._running = False
                self._changed.notify_all()

    def _run(self) -> None:
        position, renew = self._plan.start_ns, False
        while not self._stopped:
            before = self.played
            self._play_from(position, renew)
            with self._changed:
                self._steps *= self._target is not None  # a burst ends where the bag does
                self._changed.notify_all()
                if self._target is not None:
                    position, self._target = self._target, None
                elif self._plan.loop and not (self._stopped or self._is_empty(position, before)):
                    position = self._plan.start_ns
                else:
                    return
                renew = True

    def _is_empty(self, position_ns: int, before: int) -> bool:
        """Whether there was nothing from the start on: that cannot be played again and again."""
        return position_ns == self._plan.start_ns and self.played == before

    def _play_from(self, position_ns: int, renew: bool) -> None:
        """Play until the end, or until something else is asked for."""
        with self._changed:
            self._anchor(position_ns, self._wall.now())
        shown = set()
        for message in self._source.transient_local(position_ns, renew):
            self._sink.publish(message)
            shown.add((message.channel.topic, message.log_ns, message.data))
        with closing(self._source.messages(position_ns)) as messages:  # type: ignore[type-var]
            for place, message in enumerate(messages):
                if place == 0:  # the file's first bytes may have taken their time
                    with self._changed:
                        self._anchor(position_ns, self._wall.now())
                if message.log_ns > self._plan.end_ns:
                    return
                if shown and (message.channel.topic, message.log_ns, message.data) in shown:
                    continue
                if not self._wait_for(message.log_ns):
                    return
                self._sink.publish(message)
                self.played += 1

    def _wait_for(self, log_ns: int) -> bool:
        """Wait until a message is due; False if something else is asked for first."""
        with self._changed:
            while not self._stopped and self._target is None:
                now = self._wall.now()
                self._tick(now)
                if self._steps:
                    self._steps -= 1
                    self._stepped += 1
                    self._anchor(log_ns, now)
                    if not self._steps:
                        self._changed.notify_all()
                    return True
                if not self._paused and self._is_due(log_ns, now):
                    return True
                self._wall.wait(self._changed, self._until_next(log_ns, now))
        return False

    def _is_due(self, log_ns: int, now: int) -> bool:
        if self._rate == 0.0:
            self._anchor(log_ns, now)
            return True
        late = now - self._due(log_ns)
        if late < 0:
            return False
        self.lateness.add(late)
        if late > LAG_NS:
            self.slips += 1
            self._anchor(log_ns, now)
        return True

    def _due(self, log_ns: int) -> int:
        return self._anchor_wall + int((log_ns - self._anchor_bag) / self._rate)

    def _until_next(self, log_ns: int, now: int) -> float | None:
        """Seconds until there is something to do; None: only when somebody asks."""
        times = [] if self._paused else [self._due(log_ns)]
        if self._plan.clock_period_ns:
            times.append(self._next_tick)
        return max(0, min(times) - now) / NS_PER_S if times else None

    def _tick(self, now: int) -> None:
        """Send the bag time if it is time for it; time stands still while paused, the ticks do not."""
        period = self._plan.clock_period_ns
        if not period or now < self._next_tick:
            return
        self._sink.clock(self._bag_time(now))
        self._next_tick += period * ((now - self._next_tick) // period + 1)

    def _bag_time(self, now: int) -> int:
        if self._paused:
            return self._anchor_bag
        return min(self._anchor_bag + int((now - self._anchor_wall) * self._rate), self._plan.end_ns)

    def _anchor(self, bag_ns: int, now: int) -> None:
        self._anchor_bag, self._anchor_wall = bag_ns, now

    def _change(self, rate: float | None = None, paused: bool | None = None) -> None:
        with self._changed:
            now = self._wall.now()
            self._anchor(self._bag_time(now), now)
            self._rate = self._rate if rate is None else rate
            self._paused = self._paused if paused is None else paused
            self._steps = 0 if not self._paused else self._steps
            self._changed.notify_all()
