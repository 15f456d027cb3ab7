"""The recorder node: every topic it can see, as raw bytes, into a bag.

It watches the graph, subscribes to each topic with its publishers' QoS, and copies bytes; it decodes nothing.
In a namespace it records that namespace, and the topics of the ROS graph (absolute in the topic table).

A thread of its own copies and writes; the executor is left with looking for topics and with the services
`~/start`, `~/stop`, `~/split`, `~/snapshot` and `~/mark`, which publishes the parameter `event` on /events.
The thread that writes never waits for the disk: a third one syncs. In lockstep the node ends with the run's
last step.
"""

import sys
import threading
from collections.abc import Sequence
from typing import Any

from rclpy.node import Node

from forest_bag.record.recorder_parameters import RecorderParameters, overrides
from forest_bag.record.recorder_setup import new_session, topic_choice
from forest_bag.record.recording import Recording, Refusal, answered
from forest_bag.record.run_context import RunContext, versions
from forest_bag.record.sim_time import SimTime
from forest_bag.write.transient_local import is_transient_local
from forest_msgs_py.clock.step_listener import listener
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.introspection.graph_listener import DiscoveredTopic, ReceivedMessage
from forest_msgs_py.introspection.parameter_survey import ParameterSurvey
from forest_msgs_py.runtime.node import publisher, run_node, timer
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.services import offer_triggers

CLOCK = topics.CLOCK.name
QUICK_POLL_S, SLOW_POLL_S = 0.05, 0.25
QUICK_POLLS = 100  # the first five seconds, while a graph comes up


class RecorderNode(Node):
    """Records until it is told to stop."""

    def __init__(self) -> None:
        super().__init__("recorder")
        p = declare(self, RecorderParameters)
        self._chosen = topic_choice(p, self.resolve_topic_name, self.get_namespace())
        session, begins = new_session(p)
        self.get_logger().info(begins)
        by_clock = bool(self.get_parameter("use_sim_time").value)
        self._sim_time = SimTime(self._chosen.wants(CLOCK)) if by_clock else None
        self._listener = listener(
            self, self._hears, self._offered, self._refused, self._settled, overrides(p)
        )
        self._recording = Recording(session, self._take, self.get_logger().info)
        self._events = publisher(self, topics.EVENTS)
        answers = {name: getattr(self._recording, name) for name in ("start", "stop", "split", "snapshot")}
        verbs, say = answers | {"mark": self._mark}, self.get_logger().info
        offer_triggers(self, {name: answered(verb, say) for name, verb in verbs.items()})
        self._run_context = RunContext(session.attach, session.note, self.get_logger().warning)
        session.note("forest_versions", versions())
        self._survey = ParameterSurvey(self, self._learn)
        self._polls = 0
        self._poll_timer = timer(self, QUICK_POLL_S, self._poll)

    def run(self, stopping: threading.Event) -> None:
        """Copy what arrives until the node is to stop."""
        while not stopping.wait(self._listener.pause):
            self._recording.turn()

    def stop(self) -> None:
        """Close the bag; the last chunk, the footer and the metadata are written here."""
        self._recording.end()

    def _poll(self) -> None:
        """Subscribe to what has appeared since the last look, and ask new nodes for their parameters."""
        self._polls += 1
        if self._polls == QUICK_POLLS:
            self._poll_timer.timer_period_ns = int(SLOW_POLL_S * 1e9)
        self._recording.guard(self._listener.look)
        self._survey.look()

    def _hears(self, name: str, types: Sequence[str]) -> bool:
        return self._chosen.wants(name, types) or (self._sim_time is not None and name == CLOCK)

    def _take(self) -> list[ReceivedMessage]:
        heard = self._listener.take()
        return heard if self._sim_time is None else self._sim_time.stamped(heard)

    def _offered(self, offer: DiscoveredTopic) -> None:
        if self._sim_time is not None and is_transient_local(offer.profiles):
            self._sim_time.keep(offer.name)
        if self._chosen.wants(offer.name):
            self._recording.session.add_topic(*offer)

    def _refused(self, name: str, reason: str) -> None:
        self.get_logger().info(f"not recorded: {name} {reason}")

    def _settled(self, nodes: Sequence[str]) -> bool:
        """Whether the nodes have told their parameters: a short run may be over before."""
        return self._survey.has_heard(nodes)

    def _learn(self, name: str, parameters: dict[str, Any]) -> None:
        self._recording.guard(lambda: self._run_context.node(name, parameters, self._listener.context_ns()))

    def _mark(self) -> str:
        """Publish an event on /events, which is recorded as every topic is."""
        self._recording.demand_take()
        if not self._events.get_subscription_count():
            raise Refusal("the recorder does not hear /events: not yet, or it is told to exclude it")
        text = str(self.get_parameter("event").value)
        self._events.publish(message_class(topics.EVENTS)(data=text))
        return f"marked: {text}"


def main(args: list[str] | None = None) -> int:
    """Entry point of the console script."""
    return run_node(RecorderNode, args)


if __name__ == "__main__":
    sys.exit(main())
