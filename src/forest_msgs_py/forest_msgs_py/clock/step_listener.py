"""Hears a run in lockstep: what its nodes say in each step, in an order that repeats, with stamps as times.

It reads the nodes' batches (:mod:`forest_msgs_py.clock.step_batch`) instead of their topics. Whatever else is
said in the graph is heard beside it, as ever, at the time of the last complete step. The machine is told how
far everything was taken, and stays near.
"""

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cache

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from forest_msgs_py.clock.clock_parameters import ListenerParameters
from forest_msgs_py.clock.lockstep import END
from forest_msgs_py.clock.step_batch import read_batch
from forest_msgs_py.clock.step_order import StepOrder
from forest_msgs_py.clock.step_topics import DEPTH, lockstep_qos, no_output_subscription
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import stamp_to_ns
from forest_msgs_py.interfaces.qos_profiles import Qos
from forest_msgs_py.interfaces.topic_qos import offered_qos, qos
from forest_msgs_py.interfaces.topics import find, message_class, unlisted
from forest_msgs_py.introspection.graph_listener import DiscoveredTopic, GraphListener, ReceivedMessage
from forest_msgs_py.runtime.node import Finished, NodeFailure
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_msgs_py.serialization.packing import pack_clock
from forest_msgs_py.types import PERIOD_NS

WALL_CLOCK = "/parameter_events"  # carries the time of day: no two runs say the same
ANNOUNCEMENT_DEPTH = 100  # nodes
PAUSE = 0.04  # [s] between two takes: nobody waits for the recorder, and publishers keep far more
PATIENCE = 10.0  # [s] beyond the guard: who waits for one node, and not for all, shall speak first

Wanted = Callable[[str, Sequence[str]], bool]
Offered = Callable[[DiscoveredTopic], object]
Refused = Callable[[str, str], None]
Settled = Callable[[Sequence[str]], bool]


class StepListener:
    """Like a `GraphListener`, of a run in lockstep.

    Args:
        node: that subscribes.
        wanted: as of the `GraphListener`; so are the next two.
        offered: the same.
        refused: the same.
        settled: whether nothing is waited for of these nodes but their messages.
        nodes: of the run.
        guard: how long it waits for a step [s, wall clock].
    """

    def __init__(
        self,
        node: Node,
        wanted: Wanted,
        offered: Offered,
        refused: Refused,
        settled: Settled,
        nodes: Sequence[str],
        guard: float,
    ) -> None:
        self._node, self._wanted, self._offered, self._guard = node, wanted, offered, guard
        self._nodes, self._settled = nodes, settled
        self.pause = PAUSE
        self._order = StepOrder(nodes)
        self._beside = GraphListener(node, self._leaves, offered, refused)
        transient_local = QoSProfile(
            depth=ANNOUNCEMENT_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
        )
        self._announcements = PolledSubscription(
            node, message_class(topics.ANNOUNCEMENT), topics.ANNOUNCEMENT.name, transient_local
        )
        # All nodes' batches wait in one queue, with `lockstep_quiet` 1 one of each step: the simulator may be
        # hundreds of steps ahead, and what the queue lets go would be missing in the bag.
        depth = DEPTH * len(nodes)
        self._batches = PolledSubscription(
            node, message_class(topics.STEP_BATCH), topics.STEP_BATCH.name, lockstep_qos(depth), raw=True
        )
        self._no_output_subscriptions = no_output_subscription(node, topics.NO_OUTPUT)
        self._taken = node.create_publisher(
            message_class(topics.RECORDED), topics.RECORDED.name, lockstep_qos()
        )
        self._found: set[str] = set()  # topics announced whose publishers have been seen
        self._transient_local: dict[str, PolledSubscription] = {}
        self._sequence: Counter[str] = Counter()
        self._is_wanted = cache(lambda name: wanted(name, ()))  # asked of every message
        self._told, self._end, self._finished = 0, -1, False  # steps
        self._progress = time.monotonic()

    def look(self) -> None:
        """Subscribe to what has appeared beside the run since the last look."""
        self._beside.look()

    def context_ns(self) -> int:
        """Log time of what is told beside messages [ns]: 0, since when a node answers is chance."""
        return 0

    def take(self) -> list[ReceivedMessage]:
        """Return the messages of the steps that have become complete since the last time.

        Raises:
            Finished: once, when the run's last step was taken the last time.
            NodeFailure: a batch was lost, or no step was completed for as long as the guard allows.
        """
        if self._order.lost:
            raise NodeFailure(f"{self._order.lost}: the record ends before it")
        over = 0 <= self._end <= self._told
        if over and not self._finished and self._settled(self._nodes):
            self._finished = True
            raise Finished
        self._listen()
        heard = [
            self._heard(name, step * PERIOD_NS, data)
            for name, step, data in self._order.complete()
            if self._is_wanted(name)
        ]
        now = self._order.reached * PERIOD_NS
        heard += [one._replace(received_ns=now, sent_ns=now) for one in self._beside.take()]
        self._tell()
        if time.monotonic() - self._progress > self._guard and not over:
            raise NodeFailure(f"waited {self._guard:g} s; {self._order.missing()}")
        return heard

    def _leaves(self, name: str, types: Sequence[str]) -> bool:
        """Whether a topic is none of the run's, and wanted."""
        own = name in self._order.types or name == WALL_CLOCK
        return self._order.is_begun and not own and self._wanted(name, types)

    def _heard(self, name: str, stamp: int, data: bytes) -> ReceivedMessage:
        self._sequence[name] += 1
        return ReceivedMessage(stamp, name, data, stamp, self._sequence[name], 0)

    def _listen(self) -> None:
        for message, _info in self._announcements.take():
            self._order.add_announcement(message.data)
        for name in self._order.types.keys() - self._found:
            self._look_for(name, self._order.types[name])
        for name, polled in self._transient_local.items():
            for data, _info in polled.take():
                self._order.add_transient_local(name, data)
        if self._order.is_begun and self._found == self._order.types.keys():
            for data, _info in self._batches.take():
                self._order.add_batch(*read_batch(data))
        for header, _info in self._no_output_subscriptions.take():
            if header.frame_id == END:
                self._end = stamp_to_ns(header.stamp) // PERIOD_NS

    def _look_for(self, name: str, type_name: str) -> None:
        """Offer a topic, once its publisher can be seen, which tells the type's hash.

        The bag gets the QoS with which the topic is offered live: the depth and the memory that publishers
        have in lockstep are the run's, not the topic's, and no player shall repeat them.
        """
        endpoints = self._node.get_publishers_info_by_topic(name)
        if not endpoints:
            return
        self._found.add(name)
        row = find(name) or unlisted(name, type_name)
        if name in self._order.transient_local:
            kind = message_class(unlisted(name, type_name))
            self._transient_local[name] = PolledSubscription(
                self._node, kind, name, qos(row, reading=True), raw=True
            )
        if self._wanted(name, (type_name,)):
            self._offered(
                DiscoveredTopic(name, type_name, [offered_qos(row)], str(endpoints[0].topic_type_hash))
            )

    def _tell(self) -> None:
        """Tell how far everything was taken."""
        if self._order.reached > self._told:
            self._told, self._progress = self._order.reached, time.monotonic()
            self._taken.publish(pack_clock(self._told * PERIOD_NS))


def listener(
    node: Node,
    wanted: Wanted,
    offered: Offered,
    refused: Refused,
    settled: Settled,
    overrides: Mapping[str, Qos] | None = None,
) -> GraphListener | StepListener:
    """The listener that a node's parameters ask for: live, or of a run in lockstep.

    Args:
        node: that subscribes.
        wanted: see `GraphListener`.
        offered: see `GraphListener`.
        refused: see `GraphListener`.
        settled: whether nodes have told all that is to be heard of them.
        overrides: QoS of subscriptions by topic; in lockstep the batches have their own.
    """
    p = declare(node, ListenerParameters)
    nodes = [name for name in p.lockstep_nodes if name]
    if not nodes:
        return GraphListener(node, wanted, offered, refused, overrides)
    return StepListener(node, wanted, offered, refused, settled, nodes, p.lockstep_guard + PATIENCE)
