"""The driver's hands on /joy."""

from typing import Any

from rclpy.node import Node

from forest_control.operator.joystick_watch import HEARTBEAT
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import JoyValues
from forest_msgs_py.runtime.node import publisher, raw_publish
from forest_msgs_py.runtime.publishers import UNKNOWN, publishers_of
from forest_msgs_py.serialization.packing import pack_joy
from forest_station.operator.cab import JoystickState

NAMELESS = "a node that was just found"


class JoystickOutput:
    """Publishes /joy, and knows who else does.

    Args:
        node: that publishes.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher: Any = publisher(node, topics.JOY)
        self._publish = raw_publish(self._publisher)

    def publish(self, state: JoystickState) -> None:
        """Publish a sample."""
        stamp = int(self._node.get_clock().now().nanoseconds)
        self._publish(pack_joy(stamp, f"{HEARTBEAT}{state.heartbeat}", JoyValues(state.axes, state.buttons)))

    def rivals(self) -> list[str]:
        """Return the names of other nodes that publish /joy.

        A publisher is found some moments before its node's name: such a one is `NAMELESS`.
        """
        if self._node.count_publishers(topics.JOY.name) <= 1:
            return []
        names = publishers_of(self._node, topics.JOY)
        own = self._node.get_name()
        return sorted(NAMELESS if name == UNKNOWN else name for name in names if name != own) or [own]
