"""Publishers that send messages as the bytes they were recorded as, of any type that is installed."""

import contextlib
import time
from collections.abc import Callable, Mapping
from typing import Any

from rclpy._rclpy_pybind11 import RCLError
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from forest_msgs_py.interfaces.messages import ns_to_stamp
from forest_msgs_py.interfaces.qos_profiles import Qos
from forest_msgs_py.interfaces.topics import CLOCK, message_class, unlisted

DRAIN_S = 10.0  # longest wait for readers that were slow
HASH = "RIHS01_"
TRIES = 9  # further ones: the middleware waits 0.1 s in each


class RawPublishers:
    """Publishers by the topics' names in a bag.

    Args:
        node: that publishes.
        names: under which topics are published; two may go to one.
        types: of the topics.
        profiles: QoS of the topics.
        clock: whether /clock is published, too.
        complete: reliable topics wait for their readers rather than overwrite what is not delivered yet. That
            suits who sends as fast as possible; who keeps times must not wait for anybody.
    """

    def __init__(
        self,
        node: Node,
        names: Mapping[str, str],
        types: Mapping[str, str],
        profiles: Mapping[str, Qos],
        clock: bool,
        complete: bool,
    ) -> None:
        self._node = node
        self.publishers: dict[str, Any] = {}
        self._send: dict[str, Callable[[bytes], None]] = {}
        made: dict[tuple[str, str], Any] = {}
        for topic, name in names.items():
            key = (node.resolve_topic_name(name), types[topic])
            if key not in made:
                kind, profile = message_class(unlisted(topic, types[topic])), profiles[topic]
                if complete and profile.reliable and not profile.transient_local:
                    profile = profile._replace(keep_all=True)
                made[key] = node.create_publisher(kind, name, qos_profile(profile), event_callbacks=_silent())
            self.publishers[topic] = made[key]
            self._send[topic] = made[key].handle.publish_raw  # half the time of publish()
        self._clock_type = message_class(CLOCK)
        self._clock = (
            node.create_publisher(self._clock_type, CLOCK.name, 10, event_callbacks=_silent())
            if clock
            else None
        )

    def redefined(self, hashes: Mapping[str, str]) -> list[str]:
        """Topics whose type is defined otherwise here than where it was recorded: readers would see nonsense.

        Args:
            hashes: of the recorded types, by topic; an empty one is not compared.
        """
        found = []
        for topic, recorded in hashes.items():
            endpoints = self._node.get_publishers_info_by_topic(self.publishers[topic].topic_name)
            here = {str(e.topic_type_hash) for e in endpoints if e.node_name == self._node.get_name()}
            if recorded.startswith(HASH) and here and recorded not in here:
                found.append(topic)
        return found

    def publish(self, topic: str, data: bytes) -> bool:
        """Send a message; False if the queue for a slow reader stayed full for a second."""
        try:
            self._send[topic](data)
        except RCLError:
            return any(self._try_again(topic, data) for _ in range(TRIES))
        return True

    def _try_again(self, topic: str, data: bytes) -> bool:
        with contextlib.suppress(RCLError):
            self._send[topic](data)
            return True
        return False

    def drain(self) -> None:
        """Wait until readers have what was sent, for ten seconds at most."""
        end = time.monotonic() + DRAIN_S
        for publisher in set(self.publishers.values()):
            publisher.wait_for_all_acked(Duration(seconds=max(0.0, end - time.monotonic())))

    def clock(self, time_ns: int) -> None:
        """Send a time on /clock."""
        if self._clock is not None:
            self._clock.publish(self._clock_type(clock=ns_to_stamp(time_ns)))

    def without_subscribers(self) -> list[str]:
        """Return the names under which nobody listens."""
        return sorted({p.topic_name for p in self.publishers.values() if not p.get_subscription_count()})


def is_installed(type_name: str) -> bool:
    """Whether messages of a type can be published here."""
    try:
        message_class(unlisted("", type_name))
    except (ImportError, AttributeError, ValueError):
        return False
    return True


def _silent() -> PublisherEventCallbacks:
    """No event handlers of rclpy's own: each costs the executor a look at every wake-up."""
    return PublisherEventCallbacks(use_default_callbacks=False)


def qos_profile(qos: Qos) -> QoSProfile:
    """Return a profile as ROS takes it."""
    limits = {
        "deadline": qos.deadline_ns,
        "lifespan": qos.lifespan_ns,
        "liveliness_lease_duration": qos.lease_ns,
    }
    return QoSProfile(
        depth=qos.depth,
        history=HistoryPolicy.KEEP_ALL if qos.keep_all else HistoryPolicy.KEEP_LAST,
        reliability=ReliabilityPolicy.RELIABLE if qos.reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if qos.transient_local else DurabilityPolicy.VOLATILE,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC if qos.manual else LivelinessPolicy.AUTOMATIC,
        **{name: Duration(nanoseconds=value) for name, value in limits.items() if value},
    )
