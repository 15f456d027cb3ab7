"""How long it takes from a stick's sample to the first voltage that can answer it.

A voltage carries the stamp of the machine's state that it was computed from. A state that was
sampled after the stick's sample was published finds this sample in the controller's queue. So the
first voltage with a later stamp can answer it. The time until this voltage was published is told.
"""

import time

from rclpy.node import Node

from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.polled_subscription import polled_subscription
from forest_msgs_py.serialization.unpacking import ArrayReader
from forest_msgs_py.types import NS_PER_S

UNSTAMPED = -1  # [ns] of a voltage that carries no stamp: it answers nothing
GIVEN_UP = NS_PER_S  # [ns] after which a sample is not answered any more


class Latency:
    """Follows one sample at a time.

    Args:
        node: that listens to the voltages.
    """

    def __init__(self, node: Node) -> None:
        self._voltages = polled_subscription(node, topics.VALVE_VOLTAGES)
        self._reader = ArrayReader(topics.VALVE_VOLTAGES)
        self._arrived: int | None = None  # when the sample that is followed came from the page [ns]
        self._published = 0  # when it was published [ns]
        self._worst: float | None = None

    def follow(self, arrived_ns: int) -> None:
        """Follow a sample that came at a time [ns] and was published just now, unless one is followed."""
        now = time.time_ns()
        if self._arrived is None or now - self._published > GIVEN_UP:
            self._arrived, self._published = arrived_ns, now

    def read(self) -> None:
        """Look at the voltages that have come; call it at least as often as they fill their queue."""
        for data, info in self._voltages.take():
            stamp = self._reader.read(data, UNSTAMPED).stamp_ns
            if self._arrived is not None and stamp >= self._published:
                took = (info["source_timestamp"] - self._arrived) * 1e-6
                self._worst = max(took, self._worst or 0.0)
                self._arrived = None

    def told(self) -> float | None:
        """Return the longest since this was last asked [ms]; None if no sample was answered."""
        worst, self._worst = self._worst, None
        return worst
