"""The supervisor's own node in the ROS graph: it sees who is there, and publishes zero voltage."""

from __future__ import annotations

import math
from typing import Any

import rclpy
from rclpy.signals import SignalHandlerOptions

from forest_bringup.graph_lock import GraphError
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array
from forest_msgs_py.runtime.environment import prepare_environment
from forest_msgs_py.runtime.node import publisher


class GraphMonitor:
    """A node named _supervisor: hidden, as ROS calls it, from those who ask every node for its parameters.

    Args:
        namespace: of the graph, "/" or "/name".
        may_publish: False where no voltage may be published, not even zero (shadow).

    Raises:
        GraphError: ROS does not start.
    """

    def __init__(self, namespace: str, may_publish: bool) -> None:
        prepare_environment()
        self._namespace = namespace
        self._context = rclpy.Context()
        self._node: Any = None
        try:
            rclpy.init(context=self._context, args=[], signal_handler_options=SignalHandlerOptions.NO)
            self._node = rclpy.create_node(
                "_supervisor",
                context=self._context,
                namespace=namespace,
                enable_rosout=False,
                start_parameter_services=False,  # nobody spins this node to answer them
            )
            self._valves = publisher(self._node, topics.VALVE_VOLTAGES) if may_publish else None
        except Exception as error:
            self.close()
            raise GraphError(f"ROS does not start: {' '.join(str(error).split())}") from error

    def count(self, name: str) -> int:
        """Return how many nodes of this name the namespace holds."""
        return int(self._node.get_node_names_and_namespaces().count((name, self._namespace)))

    def other_publisher(self) -> str:
        """Return a command topic with a publisher besides our controller, driver and this node, or ""."""
        voltages = 2 if self._valves is not None else math.inf  # in shadow, another driver is what we watch
        for topic, ours in ((topics.VALVE_COMMANDS, 1), (topics.VALVE_VOLTAGES, voltages)):
            if self._node.count_publishers(topic.name) > ours:
                return topic.name
        return ""

    def publish_zero(self) -> None:
        """Publish zero voltage once."""
        if self._valves is not None:
            now = self._node.get_clock().now().nanoseconds
            self._valves.publish(float_array(topics.VALVE_VOLTAGES, now, (0.0, 0.0, 0.0)))

    def close(self) -> None:
        """Leave the graph."""
        self._valves = None
        if self._node is not None:
            self._node.destroy_node()  # or this process would go on listening
            self._node = None
        rclpy.try_shutdown(context=self._context)
