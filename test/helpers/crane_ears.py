"""What the crane's topics say, kept by the middleware until a test reads it: nobody spins meanwhile."""

from __future__ import annotations

import asyncio
import math
import time
from typing import Any, NamedTuple

from rclpy.qos import QoSProfile, ReliabilityPolicy

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_msgs_py.serialization.unpacking import ArrayReader, read_joy_data

KEPT = 5000  # messages
DRIVEN = 30  # messages
SHUT = 60  # messages: 0.3 s, for a joint that is braked passes zero
DEADMAN = 9  # button
MET_S = 60.0


class Joy(NamedTuple):
    at: float  # [s, time.time] when it was sent
    held: bool
    heartbeat: str
    axes: tuple[float, ...]


class Stop(NamedTuple):
    """A stop as the topics tell it [s, time.time]."""

    heartbeat: float  # the last one that counted
    released: float  # the first sample without the deadman
    shut: float  # the first of the voltages that are all zero


class CraneEars:
    """Everything said on /joy and /valve_voltages since `forget`."""

    def __init__(self, node: Any) -> None:
        # A reliable reader keeps back what follows a lost sample until that comes again: from a station that
        # was killed never, and its last second of /joy would be missing.
        reliability = {
            topics.JOY: ReliabilityPolicy.BEST_EFFORT,
            topics.VALVE_VOLTAGES: ReliabilityPolicy.RELIABLE,
        }
        self._polled = {
            topic: PolledSubscription(
                node, message_class(topic), topic.name, QoSProfile(depth=KEPT, reliability=kind), raw=True
            )
            for topic, kind in reliability.items()
        }
        self._reader = ArrayReader(topics.VALVE_VOLTAGES)
        pose = topics.GROUND_TRUTH_TIP_POSE
        self._pose = PolledSubscription(node, message_class(pose), pose.name, QoSProfile(depth=1))
        self._tip = (math.nan,) * 3
        self.forget()

    def forget(self) -> None:
        for polled in self._polled.values():
            list(polled.take())
        self.joy: list[Joy] = []
        self.voltages: list[tuple[float, tuple[float, ...]]] = []

    def read(self) -> None:
        for data, info in self._polled[topics.JOY].take():
            reading, frame = read_joy_data(data, 6, DEADMAN + 1)
            axes, buttons = reading.values
            self.joy.append(Joy(info["source_timestamp"] * 1e-9, buttons[DEADMAN] == 1, frame, axes))
        for data, info in self._polled[topics.VALVE_VOLTAGES].take():
            self.voltages.append((info["source_timestamp"] * 1e-9, self._reader.read(data, 0).values))

    def tip(self) -> tuple[float, float, float]:
        """Where the simulated tip is [m]; NaN before it is heard."""
        for message, _ in self._pose.take():
            at = message.pose.position
            self._tip = (at.x, at.y, at.z)
        return self._tip

    async def until(self, condition: Any) -> None:
        """Wait until a condition holds, at most `MET_S`."""
        end = time.monotonic() + MET_S
        while not condition():
            assert time.monotonic() < end
            await asyncio.sleep(0.01)
            self.read()

    async def moving(self) -> None:
        """Wait until the crane is driven, and has been for a while."""
        await self.until(self.driven)

    async def still(self) -> None:
        await self.until(self.shut)

    def driven(self) -> bool:
        """Whether the valves are open, and the deadman has been held for a while."""
        opened = self.voltages and any(self.voltages[-1][1])
        return bool(opened) and all(joy.held for joy in self.joy[-DRIVEN:])

    def at_rest(self) -> bool:
        """Whether the deadman is released and the valves are shut."""
        return self.shut() and not any(joy.held for joy in self.joy[-1:])

    def shut(self) -> bool:
        """Whether the valves are shut, and have been for a while."""
        newest = self.voltages[-SHUT:]
        return len(newest) == SHUT and not any(any(values) for _, values in newest)

    def stop(self) -> Stop:
        """The newest stop, of a crane that was moved."""
        held = [place for place, joy in enumerate(self.joy) if joy.held]
        last = self.joy[held[-1]]
        beat = next(joy for joy in self.joy if joy.heartbeat == last.heartbeat)
        released = self.joy[held[-1] + 1].at if held[-1] + 1 < len(self.joy) else float("inf")
        opened = max(place for place, (_, values) in enumerate(self.voltages) if any(values))
        return Stop(beat.at, released, self.voltages[opened + 1][0])
