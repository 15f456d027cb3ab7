"""What a scripted operator reads besides the sample on which it steps: the newest of each topic, its age."""

from __future__ import annotations

import math
from typing import Any

from forest_description.types import Vec3
from forest_ident.driving.safety_monitor import Seen, seen_ports
from forest_ident.experiments.experiments import Plan
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.serialization.unpacking import ArrayReader

NOTHING = math.nan


class Inputs:
    """Pressures at the watched ports, of the supply, and the oil's temperature.

    Args:
        clock: of the node.
        plan: of the experiment; a rig is stepped by its pressures, a crane by its joints.
    """

    def __init__(self, clock: Any, plan: Plan) -> None:
        self.ports = seen_ports(plan)
        self._ports = ArrayReader(topics.PRESSURES, self.ports) if self.ports else None
        self._subscription = (
            clock.polled_subscription(topics.PRESSURES) if self.ports and not plan.bench else None
        )
        labels = {topics.SUPPLY: "pressure", topics.AUXILIARY: "tank_temperature"}
        if clock.lockstep:  # in which nobody can wait for what the table says that nobody reads
            del labels[topics.AUXILIARY]
        self._slow = [
            (clock.polled_subscription(topic), ArrayReader(topic, (label,)))
            for topic, label in labels.items()
        ]
        self._values = [NOTHING, NOTHING]
        self._pressures: tuple[float, ...] = ()
        self._received = -math.inf

    def pressures(self, data: bytes, sent: float) -> tuple[int, str]:
        """Take in the watched pressures; return their stamp [ns], and what is wrong with them."""
        if self._ports is None:
            return 0, f"the machine has no transducers; allowed: one with {topics.PRESSURES.name}"
        reading = self._ports.read(data, 0)
        if not reading.problem:
            self._pressures, self._received = reading.values, sent
        return reading.stamp_ns, reading.problem

    def read(self, angles: Vec3) -> Seen:
        """Return what is seen together with the joints' angles [rad]."""
        if self._subscription is not None and (arrival := self._subscription.newest()):
            self.pressures(arrival.message, arrival.time)
        for place, (subscription, reader) in enumerate(self._slow):
            if arrival := subscription.newest():
                reading = reader.read(arrival.message, 0)
                self._values[place] = NOTHING if reading.problem else reading.values[0]
        return Seen(angles, self._pressures, *self._values)

    def missing(self, now: float, timeout: float) -> Topic | None:
        """Return the topic whose watched part has not come for a time [s]."""
        return topics.PRESSURES if self.ports and now - self._received > timeout else None
