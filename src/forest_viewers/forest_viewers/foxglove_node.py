"""The graph for Foxglove and Lichtblick: topics, parameters and services over the Foxglove protocol.

It listens on the loopback address only: the protocol knows no password. A topic is subscribed to
while a client wants it. Of what clients publish it takes one thing, true on /emergency_stop; to
reset is a service, which answers why not. Levers are not taken: nothing here judges whether a hand
still holds them.
"""

import sys
from collections.abc import Callable, Sequence
from functools import partial

from rclpy.node import Node

from forest_msgs_py.interfaces import topics
from forest_msgs_py.introspection.graph_listener import GraphListener
from forest_msgs_py.introspection.parameter_mirror import ParameterMirror
from forest_msgs_py.introspection.raw_publishers import is_installed
from forest_msgs_py.introspection.raw_services import RawServices
from forest_msgs_py.runtime.node import NodeFailure, publisher, run_node, timer
from forest_msgs_py.runtime.node_parameters import declare
from forest_viewers.server import client_requests
from forest_viewers.server.client_requests import ClientRequests, Request
from forest_viewers.server.client_stop_button import StopButton
from forest_viewers.server.client_view import ClientView, ServerError
from forest_viewers.server.frame_channels import FrameChannels
from forest_viewers.server.server_parameters import ServerParameters

TURN, LOOK = 0.02, 0.25  # [s] between two hand-overs of messages, and between two looks at the graph


class FoxgloveNode(Node):
    """Shell around `ClientView`."""

    def __init__(self) -> None:
        super().__init__("foxglove")
        p = declare(self, ServerParameters)
        self._read_only = p.read_only
        self._mirror: ParameterMirror
        self._requests = ClientRequests(lambda: self._mirror.values)
        self._view = ClientView(self._requests, p.read_only)
        self._mirror = ParameterMirror(self, self._view.tell_parameters)
        self._calls = RawServices(self)
        self._frames = FrameChannels(self.resolve_topic_name, not is_installed(topics.TF.type))
        self._listener = GraphListener(self, self._wanted, lambda _offer: None, self._refused)
        stop, pressed = publisher(self, topics.EMERGENCY_STOP), topics.message_class(topics.EMERGENCY_STOP)
        self._button = StopButton(stop.topic_name, partial(stop.publish, pressed(data=True)), self._view.warn)
        self._told: set[str] = set()
        timer(self, TURN, self._turn)
        timer(self, LOOK, self._look)
        try:
            self._view.open(p.port)
        except ServerError as error:
            self.destroy_node()  # its listeners would be at work while the process ends
            raise NodeFailure(str(error)) from error
        self.get_logger().info(f"Foxglove and Lichtblick: open ws://127.0.0.1:{self._view.port}")

    def stop(self) -> None:
        """End the server, and with it every client's connection."""
        self._view.close()

    def _look(self) -> None:
        """Offer what there is."""
        found = self.get_topic_names_and_types()
        shown = {name: types[0] for name, types in found if len(types) == 1 and "/_" not in name}
        shown |= self._frames.offered(shown)
        for name in self._view.offer(shown):
            self._refused(name, f"is of {shown[name]}, which is not installed here")
        self._view.offer_services(self._calls.look())
        self._mirror.look()
        self._listener.look()

    def _turn(self) -> None:
        """Do what was asked, hand over what was said."""
        for request in self._requests.taken():
            self._do(request)
        for message in self._listener.take():
            self._view.say(message.name, message.data, message.received_ns)
            for name, data in self._frames.answer(message.name, message.data):
                self._view.say(name, data, message.received_ns)

    def _wanted(self, name: str, _types: Sequence[str] = ()) -> bool:
        return any(map(self._view.wanted, (name, *self._frames.made_from(name))))

    def _do(self, request: Request) -> None:
        match request:
            case client_requests.Subscribed(topic):
                self._view.want(topic)
                self._forget(topic, self._listener.is_latched)  # what was said before is heard anew
                self._listener.look()
            case client_requests.Unsubscribed(topic):
                self._view.leave(topic)
                self._forget(topic, lambda name: not self._wanted(name))
            case client_requests.ParametersSet() if self._read_only:
                self._view.warn("this server is read-only: no parameter is set")
            case client_requests.ParametersSet(values):
                self._mirror.set(values, self._view.warn)
            case client_requests.ServiceCalled(name, data, answer):
                self._calls.call(name, data, answer.set_result, request.fail)
            case client_requests.Published():
                self._button.hear(request)

    def _forget(self, topic: str, due: Callable[[str], bool]) -> None:
        for name in (topic, *self._frames.sources(topic)):
            if due(name):
                self._listener.forget(name)

    def _refused(self, name: str, reason: str) -> None:
        if name not in self._told:
            self._told.add(name)
            self.get_logger().info(f"not shown: {name} {reason}")


def main(args: list[str] | None = None) -> int:
    """Entry point of the console script."""
    return run_node(FoxgloveNode, args)


if __name__ == "__main__":
    sys.exit(main())
