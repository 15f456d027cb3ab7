"""What has arrived on a topic that is not read often, as messages."""

from typing import Any

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import stamp_to_ns
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_msgs_py.serialization.cdr import CdrError, cdr_type


def decoded_arrivals(waiting: PolledSubscription, topic: topics.Topic) -> list[tuple[float, Any]]:
    """Return stamp [s] and message of all that has arrived, oldest first."""
    found = []
    kind = cdr_type(topic.type)
    for arrival in waiting.arrivals():
        try:
            message = kind.decode(arrival.message)
        except CdrError:
            continue
        found.append((stamp_to_ns(message.header.stamp) * 1e-9, message))
    return found
