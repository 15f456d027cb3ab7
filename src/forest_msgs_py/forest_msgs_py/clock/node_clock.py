"""A node's clock: live it is the system's, in lockstep it counts the steps of the graph.

A node asks its clock for the time, its publishers and its subscriptions, and is written once:

=======================  ===============================  ==============================================
of a clock               live                             in lockstep
=======================  ===============================  ==============================================
``now()``                monotonic clock [s]              k·dt of the step being made [s]
``stamp()``              system time [ns]                 k·dt [ns]
``on``                   calls when a message arrives     calls when all inputs of step k are here
``polled_subscription``  newest message until now         message of step k
``every``                a timer on the steady clock      every so many steps
``publisher``            publishes                        publishes once a step, or reports no output
``run``                  None: the executor does it all   the loop over the steps
=======================  ===============================  ==============================================

Messages come as bytes; see :mod:`forest_msgs_py.serialization.unpacking`.
"""

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from forest_msgs_py.clock.clock_parameters import ClockParameters, LeaderParameters
from forest_msgs_py.clock.lockstep import LockstepClock
from forest_msgs_py.clock.step_topics import StepPublisher
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.runtime.node import publisher, raw_publish, subscription, timer
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.polled_subscription import ReceivedCount, polled_subscription, sent_at
from forest_msgs_py.serialization.packing import NumberPublisher, Packer


class LiveClock:
    """The clock of a graph that runs in real time."""

    lockstep = False
    run = None

    def __init__(self, node: Node) -> None:
        self._node = node

    def now(self) -> float:
        """The time by which staleness is judged [s]."""
        return time.monotonic()

    def stamp(self) -> int:
        """ROS time [ns]."""
        return int(self._node.get_clock().now().nanoseconds)

    def publisher(self, topic: Topic) -> Any:
        """A publisher with the type and the QoS of the table."""
        return publisher(self._node, topic)

    def polled_subscription(self, topic: Topic, answered: bool = False) -> Any:  # noqa: ARG002  matters in lockstep
        """A subscription to be read when its messages are needed."""
        return polled_subscription(self._node, topic)

    def on(self, topic: Topic, callback: Callable[[bytes, float], None]) -> ReceivedCount:
        """Call with each message of a topic and the time at which it was sent, by `now`'s clock [s]."""
        received = ReceivedCount()

        def arrived(data: bytes, info: dict[str, int]) -> None:
            received.note(info)
            callback(data, sent_at(info))

        received.subscription = subscription(self._node, topic, arrived, raw=True)
        return received

    def every(self, period: float, callback: Callable[[], None]) -> None:
        """Call once in a period [s]."""
        timer(self._node, period, callback)


def number_publisher(
    clock: LiveClock | LockstepClock, topic: Topic, frame: str = "", plain: bool = False
) -> NumberPublisher:
    """A publisher of a topic whose messages are stamps and numbers; see `Packer`."""
    return NumberPublisher(publishes_bytes(clock.publisher(topic)), Packer(topic, frame, plain))


def publishes_bytes(publisher: Any) -> Callable[[bytes], None]:
    """The call that publishes a message's bytes by a clock's publisher."""
    return publisher.publish if isinstance(publisher, StepPublisher) else raw_publish(publisher)


def node_clock(node: Node, leads: bool = False) -> LiveClock | LockstepClock:
    """The clock that the parameter ``lockstep`` asks for.

    A node takes its clock's ``run`` as its own.

    Args:
        node: whose clock it is.
        leads: whether the node begins each step, as the simulator does.
    """
    p = declare(node, ClockParameters)
    run = declare(node, LeaderParameters) if leads else LeaderParameters()
    if not p.lockstep:
        return LiveClock(node)
    return LockstepClock(
        node,
        p.lockstep_guard,
        leads=leads,
        steps=run.steps,
        recorded=run.wait_for_recorder,
        quiet=p.lockstep_quiet,
    )
