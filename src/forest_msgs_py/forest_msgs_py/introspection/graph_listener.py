"""Hears the topics of a graph as raw bytes, whoever publishes them and whenever they appear."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import itemgetter
from typing import Any, NamedTuple

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from forest_msgs_py.interfaces.qos_profiles import Qos
from forest_msgs_py.interfaces.topics import message_class, unlisted
from forest_msgs_py.introspection.raw_publishers import qos_profile
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_msgs_py.runtime.sequences import SequenceGaps

QUEUE_DEPTH = 10_000  # messages: three seconds of 3 kHz, in which a disk may think
PAUSE = 0.01  # [s] waking up once for all that arrived is several times cheaper than for each message
LOOKS = 10  # of them, one counts not only the publishers but asks who they are, which takes far longer


class ReceivedMessage(NamedTuple):
    """One message: serialized, its times [ns], its publisher's count, and how many are missing before it."""

    received_ns: int
    name: str
    data: bytes
    sent_ns: int
    sequence: int
    missed: int


class DiscoveredTopic(NamedTuple):
    """A topic as its publishers offer it; profiles with the keys of rosbag2's metadata."""

    name: str
    type: str
    profiles: list[dict[str, Any]]
    type_hash: str


class _ListenedTopic:
    """One topic: its publishers so far, the QoS that suits them all, and the gaps."""

    def __init__(self) -> None:
        self.publishers: dict[bytes, TopicEndpointInfo] = {}
        self.told = 0  # of the publishers, to who listens
        self.present = 0  # at the last look
        self.polled: PolledSubscription | None = None
        self.qos: Qos | None = None
        self.gaps = SequenceGaps()


class GraphListener:
    """Subscribes to what it finds and is wanted.

    Args:
        node: that subscribes.
        wanted: whether a topic (resolved name) of some types is to be heard.
        offered: called with a topic before its first message, and again when a publisher has come.
        refused: called with the name of a topic that cannot be heard, and why.
        overrides: QoS of subscriptions by topic, in place of the most that every publisher offers.
    """

    def __init__(
        self,
        node: Node,
        wanted: Callable[[str, Sequence[str]], bool],
        offered: Callable[[DiscoveredTopic], object],
        refused: Callable[[str, str], None],
        overrides: Mapping[str, Qos] | None = None,
    ) -> None:
        self._overrides = overrides or {}
        self.pause = PAUSE  # [s] between two takes
        self._node, self._wanted, self._offered, self._tell_refused = node, wanted, offered, refused
        self._watched: dict[str, _ListenedTopic] = {}
        self._refused: set[str] = set()
        self._looks = 0
        self._moved: list[ReceivedMessage] = []  # from subscriptions that were made anew

    def look(self) -> None:
        """Subscribe to what has appeared since the last look."""
        self._looks += 1
        # The joystick last: a source that waits for listeners then waits for the other topics, too.
        found = sorted(self._node.get_topic_names_and_types(), key=lambda topic: topic[0].endswith("/joy"))
        for name, types in found:
            if name in self._refused or not self._wanted(name, types):
                continue
            if len(types) == 1:
                self._follow(name, types[0])
            else:
                self._refuse(name, f"has {len(types)} types ({', '.join(types)}); allowed: one")

    def forget(self, name: str) -> None:
        """End hearing a topic.

        One that is still wanted is heard anew at the next look: what is latched comes once more.
        """
        watched = self._watched.pop(name, None)
        if watched is not None and watched.polled is not None:
            self._node.destroy_subscription(watched.polled.subscription)

    def is_latched(self, name: str) -> bool:
        """Return whether a publisher of a topic keeps its newest messages for who comes later."""
        offered = (end.qos_profile.durability for end in self._node.get_publishers_info_by_topic(name))
        return DurabilityPolicy.TRANSIENT_LOCAL in offered

    def context_ns(self) -> int:
        """Log time of what is told now beside messages [ns]."""
        return time.time_ns()

    def take(self) -> list[ReceivedMessage]:
        """Return what has arrived since the last time, in the order of arrival."""
        heard, self._moved = self._moved, []
        for name, watched in self._watched.items():
            if watched.polled is not None:
                heard.extend(self._taken(name, watched, watched.polled))
        heard.sort(key=itemgetter(0))
        return heard

    def _taken(
        self, name: str, watched: _ListenedTopic, polled: PolledSubscription
    ) -> Iterator[ReceivedMessage]:
        observe = watched.gaps.observe

        def publishers() -> int:  # asked only when a number does not follow on
            return self._meet_publishers(name, watched)

        for data, info in polled.take():
            sequence = info.get("publication_sequence_number") or 0
            missed = observe(sequence, publishers)
            yield ReceivedMessage(
                info["received_timestamp"], name, data, info["source_timestamp"], sequence, missed
            )

    def _follow(self, name: str, type_name: str) -> None:
        """Learn the topic's publishers, and subscribe, or subscribe anew if a new one offers less."""
        watched = self._watched.get(name) or _ListenedTopic()
        present = self._node.count_publishers(name)
        if present == watched.present and self._looks % LOOKS:
            return
        watched.present = present
        if self._meet_publishers(name, watched) == watched.told:
            return
        try:
            kind = message_class(unlisted(name, type_name))
        except (ImportError, AttributeError, ValueError):
            self._refuse(name, f"is of {type_name}, whose package is not installed here")
            return
        self._watched[name] = watched
        watched.told = len(watched.publishers)
        endpoints = list(watched.publishers.values())
        profiles = [_profile(endpoint.qos_profile) for endpoint in endpoints]
        self._offered(DiscoveredTopic(name, type_name, profiles, str(endpoints[0].topic_type_hash)))
        suits_all = self._overrides.get(name) or _common_qos(endpoints)
        if suits_all != watched.qos:
            self._subscribe(name, kind, watched, suits_all)

    def _subscribe(self, name: str, kind: Any, watched: _ListenedTopic, qos: Qos) -> None:
        if watched.polled is not None:
            self._moved.extend(self._taken(name, watched, watched.polled))
            self._node.destroy_subscription(watched.polled.subscription)
        watched.qos = qos
        watched.polled = PolledSubscription(self._node, kind, name, qos_profile(qos), raw=True)

    def _meet_publishers(self, name: str, watched: _ListenedTopic) -> int:
        """Note who publishes now; return how many have done so until now."""
        for endpoint in self._node.get_publishers_info_by_topic(name):
            watched.publishers.setdefault(bytes(endpoint.endpoint_gid), endpoint)
        return len(watched.publishers)

    def _refuse(self, name: str, reason: str) -> None:
        self._refused.add(name)
        self._tell_refused(name, reason)


def _common_qos(endpoints: list[TopicEndpointInfo]) -> Qos:
    """The most that every publisher offers: asking for more than one of them offers would not match it."""
    profiles = [endpoint.qos_profile for endpoint in endpoints]
    reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in profiles)
    transient_local = all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in profiles)
    return Qos(depth=QUEUE_DEPTH, reliable=reliable, transient_local=transient_local)


def _profile(qos: QoSProfile) -> dict[str, Any]:
    """A QoS profile with the keys and words of rosbag2's metadata."""

    def duration(value: Any) -> dict[str, int]:
        sec, nsec = divmod(value.nanoseconds, 1_000_000_000)
        return {"sec": sec, "nsec": nsec}

    return {
        "history": qos.history.short_key,
        "depth": qos.depth,
        "reliability": qos.reliability.short_key,
        "durability": qos.durability.short_key,
        "deadline": duration(qos.deadline),
        "lifespan": duration(qos.lifespan),
        "liveliness": qos.liveliness.short_key,
        "liveliness_lease_duration": duration(qos.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": qos.avoid_ros_namespace_conventions,
    }
