"""What the operator wants to be remembered, said on /events."""

from rclpy.node import Node

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.node import publisher


class Events:
    """Says events.

    Args:
        node: of the station.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = publisher(node, topics.EVENTS)

    def say(self, text: str) -> bool:
        """Say an event; tell whether anybody hears it."""
        if not self._publisher.get_subscription_count():
            return False
        self._publisher.publish(message_class(topics.EVENTS)(data=text))
        return True
