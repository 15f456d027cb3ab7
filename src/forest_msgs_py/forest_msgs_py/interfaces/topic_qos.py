"""The QoS of the table's topics, for our publishers, for our subscriptions, and as bags hold it.

This module imports no ROS: ``qos`` does so when it is called.
"""

from typing import TYPE_CHECKING, Any

from forest_msgs_py.interfaces.topics import Topic

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

STREAM_RATE_HZ = 100.0  # from here on a topic counts as a stream and gets the deeper queue
STREAM_DEPTH = 200  # 1 s at the sensor rate, from which a reader that was held up still gets what it missed
READER_DEPTH = 10  # what our nodes keep: after a stall they want the present, not the past
EVENT_DEPTH = 10


def queue_depth(topic: Topic) -> int:
    """Length of the publisher's queue, messages."""
    if topic.transient_local:
        return 1
    return STREAM_DEPTH if topic.rate_hz >= STREAM_RATE_HZ else EVENT_DEPTH


def qos(topic: Topic, reading: bool = False) -> "QoSProfile":
    """Publishers are reliable; transient-local topics keep their last message for those who come late.

    A subscription to what is sensed is best-effort: it hears reliable publishers and best-effort ones, and a
    lost sample does not hold back those after it until it was repeated. Of a transient-local topic it keeps
    more than one message, or the last of one publisher would take the place of another's.

    Args:
        topic: row of the table.
        reading: for a subscription, whose queue is short.
    """
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    durability = DurabilityPolicy.TRANSIENT_LOCAL if topic.transient_local else DurabilityPolicy.VOLATILE
    lossy = reading and topic.sensed
    reliability = ReliabilityPolicy.BEST_EFFORT if lossy else ReliabilityPolicy.RELIABLE
    depth = READER_DEPTH if reading else queue_depth(topic)
    return QoSProfile(depth=depth, reliability=reliability, durability=durability)


def offered_qos(topic: Topic) -> dict[str, Any]:
    """What our publisher of a topic offers, with the keys and words of rosbag2's metadata."""
    never = {"sec": 9223372036, "nsec": 854775807}
    return {
        "history": "keep_last",
        "depth": queue_depth(topic),
        "reliability": "reliable",
        "durability": "transient_local" if topic.transient_local else "volatile",
        "deadline": never,
        "lifespan": never,
        "liveliness": "automatic",
        "liveliness_lease_duration": never,
        "avoid_ros_namespace_conventions": False,
    }
