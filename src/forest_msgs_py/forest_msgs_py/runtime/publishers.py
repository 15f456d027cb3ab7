"""Who publishes on a topic, by the nodes' names."""

from rclpy.node import Node

from forest_msgs_py.interfaces.topics import Topic

UNKNOWN = "_NODE_NAME_UNKNOWN_"  # as the middleware says: a publisher is found some moments before its node


def publishers_of(node: Node, topic: Topic) -> list[str]:
    """Return the names of the nodes that publish on a topic; who was just found may be `UNKNOWN`."""
    return [end.node_name for end in node.get_publishers_info_by_topic(node.resolve_topic_name(topic.name))]
