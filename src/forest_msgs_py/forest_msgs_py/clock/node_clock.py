"""How a node keeps time: live, by the system's clock, or in lockstep, by the steps of the graph.

A node asks its pace for the time, for its publishers and its subscriptions, and is written once:

===================  ===================================  ====================================================
of a pace            live                                 in lockstep
===================  ===================================  ====================================================
``now()``            monotonic clock [s]                  k·dt of the step being made [s]
``stamp()``          system time [ns]                     k·dt [ns]
``on``               calls when a message arrives         calls when all that the node reads of step k is here
``inbox``            newest message until now             message of step k
``every``            a timer on the steady clock          every so many steps
``publisher``        publishes                            publishes, once a step; tells if it said nothing
``run``              None: the executor does it all       the loop over the steps
===================  ===================================  ====================================================

Messages come as bytes; see :mod:`forest_msgs_py.serialization.unpacking`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from forest_msgs_py.clock.clock_parameters import ClockParameters, LeaderParameters
from forest_msgs_py.clock.lockstep import Lockstep
from forest_msgs_py.clock.step_topics import StepPublisher
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.runtime.node import publisher, raw_publish, subscription, timer
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.polled_subscription import Tally, inbox, sent_at
from forest_msgs_py.serialization.packing import Packer, Speaker


class Live:
    """The pace of a machine that does not wait."""

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

    def inbox(self, topic: Topic, answered: bool = False) -> Any:  # noqa: ARG002  matters in lockstep
        """A subscription to be read when its messages are needed."""
        return inbox(self._node, topic)

    def on(self, topic: Topic, callback: Callable[[bytes, float], None]) -> Tally:
        """Call with each message of a topic and the time at which it was sent, by `now`'s clock [s]."""
        tally = Tally()

        def arrived(data: bytes, info: dict[str, int]) -> None:
            tally.note(info)
            callback(data, sent_at(info))

        tally.subscription = subscription(self._node, topic, arrived, raw=True)
        return tally

    def every(self, period: float, callback: Callable[[], None]) -> None:
        """Call once in a period [s]."""
        timer(self._node, period, callback)


def speaker(pace: Live | Lockstep, topic: Topic, frame: str = "", plain: bool = False) -> Speaker:
    """A publisher of a topic whose messages are stamps and numbers; see `Packer`."""
    return Speaker(publishes_bytes(pace.publisher(topic)), Packer(topic, frame, plain))


def publishes_bytes(publisher: Any) -> Callable[[bytes], None]:
    """The call that publishes a message's bytes by a pace's publisher."""
    return publisher.publish if isinstance(publisher, StepPublisher) else raw_publish(publisher)


def pace(node: Node, leads: bool = False) -> Live | Lockstep:
    """The pace that the parameter ``lockstep`` asks for.

    A node hands its pace's ``run`` on as its own.

    Args:
        node: whose pace it is.
        leads: whether the node begins each step, as the machine does.
    """
    p = declare(node, ClockParameters)
    run = declare(node, LeaderParameters) if leads else LeaderParameters()
    if not p.lockstep:
        return Live(node)
    return Lockstep(
        node,
        p.lockstep_guard,
        leads=leads,
        steps=run.steps,
        recorded=run.wait_for_recorder,
        quiet=p.lockstep_quiet,
    )
