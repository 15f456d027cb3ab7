"""A live graph on two hosts with the levers of `live_crane`: joystick here; machine and recorder there.

Where the controller runs is a choice. All is judged by the machine's host: by the recorder's bag.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import hosts
import numpy as np
from live_crane import AGAIN, BEGUN, ENDS, LINKS, MACHINE, PLAYING, REST, write_levers

from forest_bag.read.timeseries import Bag, read_bag
from forest_description.geometry.kinematics import tip_position
from forest_msgs_py.interfaces import topics

HERE, THERE = "10.79.0.1", "10.79.0.2"
STARTED_S = 60.0
RECORDING = "]: recording to"  # the machine has told its first state
LATE_LINK = 9  # `limit` of controller/status
Start = Callable[[list[str], Mapping[str, str]], Any]  # a command in an environment; gives its `Told`


class Times(NamedTuple):
    """Of the levers, as in `live_crane`, since the joystick's first sample [s]."""

    begun: float = BEGUN
    rest: float = REST
    again: float = AGAIN
    ends: float = ENDS


class Outcome(NamedTuple):
    """What the machine's host recorded; times from the joystick's first sample."""

    opened: np.ndarray  # [s] of each message that opens a valve
    shut: np.ndarray  # [s] of each that shuts all
    time: np.ndarray  # [s] of each state of the machine
    tip: np.ndarray  # [m] its tip
    share: float  # smallest of their speed that the levers had for a late link; 1: it never was
    unanswered: int  # states, in motion, for which no command came
    told: tuple[str, ...]  # warnings in the logs of both

    def zero_after(self, cut: float, healed: float) -> float:
        """Return how long after a cut the valves were told to shut [s]; inf: not before it healed."""
        last = self.opened[self.opened < healed].max(initial=-float("inf"))
        later = self.shut[(self.shut > last) & (self.shut < healed)]
        return max(0.0, float(later.min() - cut)) if later.size else float("inf")

    def moved(self, begin: float, end: float) -> bool:
        """Tell whether a valve was open in a time."""
        return bool(((self.opened >= begin) & (self.opened < end)).any())


class TwoHosts:
    """The two halves of a graph, on joined hosts; the operator's begins when the machine tells its state.

    Args:
        start: starts a process.
        at: the two hosts.
        folder: for levers, logs and bag.
        times: of the levers.
        here: nodes on the operator's host.
        machine_environment: further variables of the machine's host.
    """

    def __init__(
        self,
        start: Start,
        at: Sequence[str],
        folder: Path,
        times: Times,
        here: Sequence[str] = ("joystick", "controller"),
        machine_environment: Mapping[str, str] | None = None,
    ) -> None:
        self._at, self._bag, self._times = at, folder / "bag", times
        levers, nodes = (
            write_levers(folder / "levers.csv", *times),
            ["controller", "valve_driver", "simulator", "recorder"],
        )
        there = [name for name in nodes if name not in here]
        self._halves = list[Any]()
        for host, peer, names, more in (
            (at[1], HERE, there, machine_environment or {}),
            (at[0], THERE, here, {}),
        ):
            own = folder / host
            own.mkdir()  # for its lock: of another host's graph it knows nothing
            network = {"FOREST_NETWORK": peer, "TMPDIR": str(own), **more}
            given = {**os.environ, **network}
            given.pop("FASTRTPS_DEFAULT_PROFILES_FILE", None)
            words = ["--machine", MACHINE, "--joystick", str(levers), "--record", str(self._bag)]
            module = [sys.executable, "-m", "forest_bringup.graph", *words, "--only", ",".join(names)]
            self._halves.append(start(hosts.on(host, *module), given))
            self._wait(lambda: RECORDING in self.text(), STARTED_S)

    def until(self, seconds: float) -> None:
        """Wait until a time since the joystick's first sample [s]."""
        self._wait(lambda: time.time() >= self.played() + seconds, STARTED_S + seconds)

    def _wait(self, done: Callable[[], bool], longest_s: float) -> None:
        end = time.monotonic() + longest_s
        while not done():
            assert time.monotonic() < end, self.text()
            assert all(half.poll() is None for half in self._halves), self.text()
            time.sleep(0.005)

    def played(self) -> float:
        """Return when the joystick began to play [s, time.time]; infinite: it has not."""
        found = PLAYING.search(self.text())
        return float(found[1]) if found else float("inf")

    def text(self) -> str:
        """Return what both halves have printed."""
        return "".join(half.text() for half in reversed(self._halves))

    def cut(self, seconds: float) -> tuple[float, float, float]:
        """Cut the link for a time [s].

        Returns:
            When it still held, when it was cut, and until when, since the joystick's first sample [s].
        """
        held = time.time()
        hosts.ip("-n", self._at[1], "link", "set", "link0", "down")
        gone = time.time()
        while time.time() < gone + seconds:
            time.sleep(0.002)
        healed = time.time()
        hosts.ip("-n", self._at[1], "link", "set", "link0", "up")
        return held - self.played(), gone - self.played(), healed - self.played()

    def end(self, clock_ahead: float = 0.0) -> Outcome:
        """Let the levers play to their end, stop both halves, and read the bag."""
        self.until(self._times.ends)
        codes = [half.stop() for half in reversed(self._halves)]
        # A clock that is shifted in libc alone stretches waits of a simulator that shall end.
        assert codes == [0, 0] or clock_ahead, self.text()
        return _outcome(read_bag(self._bag), self.played() + clock_ahead, self._times, self.text())


def _outcome(bag: Bag, played: float, p: Times, text: str) -> Outcome:
    def since(topic: Any) -> np.ndarray:
        return bag.sent_ns(topic) * 1e-9 - played

    def between(times: np.ndarray) -> int:
        return int(((times >= p.begun) & (times < p.rest)).sum())

    volts = bag.series(topics.VALVE_VOLTAGES).values
    states = bag.series(topics.JOINT_STATES).values[:, :3]
    share, limit = bag.series(topics.CONTROLLER_STATUS).values[:, :2].T
    times, commands = since(topics.JOINT_STATES), since(topics.VALVE_COMMANDS)
    warned = [line.split("]: ", 1)[-1] for line in text.splitlines() if "[WARN]" in line]
    return Outcome(
        opened=since(topics.VALVE_VOLTAGES)[volts.any(axis=1)],
        shut=since(topics.VALVE_VOLTAGES)[~volts.any(axis=1)],
        time=times,
        tip=np.array([tip_position(tuple(state), LINKS) for state in states]),
        share=float(share[limit == LATE_LINK].min(initial=1.0)),
        unanswered=max(0, between(times) - between(commands)),
        told=tuple(dict.fromkeys(warned)),
    )
