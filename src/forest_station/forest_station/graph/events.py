"""What the operator wants to be remembered, said on /events."""

import asyncio
import time

from rclpy.duration import Duration
from rclpy.node import Node

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.node import publisher

ARRIVED_S = 5.0  # longest wait for who hears it
POLL_S = 0.01  # a wait inside the middleware would hold up the whole process


class Events:
    """Says events.

    Args:
        node: of the station.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = publisher(node, topics.EVENTS)

    def heard(self) -> bool:
        """Tell whether anybody hears events: a recorder does some seconds after its start."""
        return bool(self._publisher.get_subscription_count())

    async def say(self, text: str) -> bool:
        """Say an event; wait until all who hear it have it, and tell whether anybody has."""
        if not self.heard():
            return False
        self._publisher.publish(message_class(topics.EVENTS)(data=text))
        end = time.monotonic() + ARRIVED_S
        while not self._publisher.wait_for_all_acked(Duration()):
            if time.monotonic() > end:
                return False
            await asyncio.sleep(POLL_S)
        return True
