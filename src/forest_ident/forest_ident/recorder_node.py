"""The recorder node: every topic it can see, as raw bytes, into a bag.

It watches the graph, subscribes to each topic with its publishers' QoS, and copies bytes; it decodes nothing.
In a namespace it records that namespace, and the topics of the ROS graph (absolute in the topic table).
"""

from __future__ import annotations

import sys
from operator import itemgetter
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from forest_msgs_py.bag_writer import FLUSH_PERIOD_S, BagWriter
from forest_msgs_py.inbox import Inbox
from forest_msgs_py.node import NodeFailure, run_node, timer
from forest_msgs_py.parameters import ParameterError, declare
from forest_msgs_py.sequences import SequenceGaps
from forest_msgs_py.topics import TOPICS, find, message_class, unlisted

QUEUE_DEPTH = 1000  # messages: five seconds of a 200 Hz topic while the disk thinks
DRAIN_PERIOD_S = 0.01  # waking up once for all that arrived is several times cheaper than for each message
QUICK_POLL_S, SLOW_POLL_S = 0.05, 0.25
QUICK_POLLS = 100  # the first five seconds, while a graph comes up


class _Watched:
    """One topic being recorded: its publishers so far, the QoS that suits them all, and the gaps."""

    def __init__(self) -> None:
        self.publishers: dict[bytes, TopicEndpointInfo] = {}
        self.inbox: Inbox | None = None
        self.qos: tuple[ReliabilityPolicy, DurabilityPolicy] | None = None
        self.gaps = SequenceGaps()


class RecorderNode(Node):
    """Records until it is told to stop."""

    def __init__(self) -> None:
        super().__init__("recorder")
        output = declare(self, "output", "", "Directory to be made for the bag")
        excluded = declare(self, "exclude", [""], "Topics not to record")
        if not output:
            raise ParameterError("parameter 'output' is ''; allowed: a directory that does not exist yet")
        self._excluded = {self.resolve_topic_name(name) for name in excluded if name}
        try:
            self._recorder = BagWriter(output)
        except OSError as error:
            raise ParameterError(
                f"parameter 'output' is {output!r}: {error}; allowed: a directory that does not exist yet"
            ) from error
        self._watched: dict[str, _Watched] = {}
        self._refused: set[str] = set()
        self._failed = False
        self._polls = 0
        self._poll_timer = timer(self, QUICK_POLL_S, self._poll)
        timer(self, DRAIN_PERIOD_S, self._drain)
        timer(self, FLUSH_PERIOD_S, self._flush)
        self.get_logger().info(f"recording to {output}")

    def stop(self) -> None:
        """Close the bag; the last chunk, the footer and the metadata are written here."""
        if not self._failed:
            self._drain()
        try:
            self._recorder.close()
        except OSError as error:
            if not self._failed:
                raise self._disk_failure(error) from error
        if not self._failed:
            lost = sum(self._recorder.lost.values())
            self.get_logger().info(
                f"recorded {self._recorder.message_count} messages, {len(self._watched)} topics, lost {lost}"
            )

    def _poll(self) -> None:
        """Subscribe to what has appeared since the last look."""
        self._polls += 1
        if self._polls == QUICK_POLLS:
            self._poll_timer.timer_period_ns = int(SLOW_POLL_S * 1e9)
        # The joystick last: a source that waits for listeners then waits for the other topics, too.
        for name, types in sorted(
            self.get_topic_names_and_types(), key=lambda found: found[0].endswith("/joy")
        ):
            if self._wanted(name, types):
                self._follow(name, types[0])

    def _wanted(self, name: str, types: list[str]) -> bool:
        hidden = any(part.startswith("_") for part in name.split("/"))
        if hidden or name in self._excluded or name in self._refused:
            return False
        row = find(name)
        if row is not None and not row.recorded:
            return False
        if len(types) != 1:
            self._refuse(name, f"has {len(types)} types ({', '.join(types)}); allowed: one")
            return False
        namespace = self.get_namespace().rstrip("/") + "/"
        return name.startswith(namespace) or name in {row.name for row in TOPICS}

    def _follow(self, name: str, type_name: str) -> None:
        """Learn the topic's publishers, and subscribe, or subscribe anew if a new one offers less."""
        watched = self._watched.get(name) or _Watched()
        self._meet_publishers(name, watched)
        if not watched.publishers:
            return
        wanted = _common_qos(list(watched.publishers.values()))
        if wanted == watched.qos:
            return
        if name not in self._watched and not self._open_topic(name, type_name, watched):
            return
        if watched.inbox is not None:
            self._drain()
            self.destroy_subscription(watched.inbox.subscription)
        watched.qos = wanted
        qos = QoSProfile(depth=QUEUE_DEPTH, reliability=wanted[0], durability=wanted[1])
        watched.inbox = Inbox(self, message_class(unlisted(name, type_name)), name, qos, raw=True)

    def _meet_publishers(self, name: str, watched: _Watched) -> int:
        for endpoint in self.get_publishers_info_by_topic(name):
            watched.publishers.setdefault(bytes(endpoint.endpoint_gid), endpoint)
        return len(watched.publishers)

    def _open_topic(self, name: str, type_name: str, watched: _Watched) -> bool:
        try:
            message_class(unlisted(name, type_name))
        except (ImportError, AttributeError, ValueError):
            self._refuse(name, f"is of {type_name}, whose package is not installed here")
            return False
        endpoints = list(watched.publishers.values())
        profiles = [_profile(endpoint.qos_profile) for endpoint in endpoints]
        self._recorder.add_topic(name, type_name, profiles, str(endpoints[0].topic_type_hash))
        self._watched[name] = watched
        return True

    def _refuse(self, name: str, reason: str) -> None:
        self._refused.add(name)
        self.get_logger().info(f"not recorded: {name} {reason}")

    def _drain(self) -> None:
        """Write what has arrived since the last time, in the order of arrival."""
        arrived = [
            (info["received_timestamp"], name, data, info)
            for name, watched in self._watched.items()
            if watched.inbox is not None
            for data, info in watched.inbox.take()
        ]
        arrived.sort(key=itemgetter(0))
        for received, name, data, info in arrived:
            sequence = info.get("publication_sequence_number") or 0
            self._count_gaps(name, sequence)
            try:
                self._recorder.write(name, data, received, info["source_timestamp"], sequence)
            except OSError as error:
                raise self._disk_failure(error) from error

    def _count_gaps(self, name: str, sequence: int) -> None:
        """Look for a gap before a message; the graph is asked only when a number does not follow on."""
        watched = self._watched[name]
        watched.gaps.observe(sequence, lambda: self._meet_publishers(name, watched))
        self._recorder.lost[name] = watched.gaps.lost

    def _flush(self) -> None:
        try:
            self._recorder.flush()
        except OSError as error:
            raise self._disk_failure(error) from error

    def _disk_failure(self, error: OSError) -> NodeFailure:
        self._failed = True
        place, count = self._recorder.directory, self._recorder.message_count
        return NodeFailure(
            f"cannot write the bag in {place}: {error.strerror}; it ends after {count} messages"
        )


def _common_qos(endpoints: list[TopicEndpointInfo]) -> tuple[ReliabilityPolicy, DurabilityPolicy]:
    """The most that every publisher offers: asking for more than one of them offers would not match it."""
    profiles = [endpoint.qos_profile for endpoint in endpoints]
    reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in profiles)
    latched = all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in profiles)
    return (
        ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


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


def main(args: list[str] | None = None) -> int:
    """Entry point of the console script."""
    return run_node(RecorderNode, args)


if __name__ == "__main__":
    sys.exit(main())
