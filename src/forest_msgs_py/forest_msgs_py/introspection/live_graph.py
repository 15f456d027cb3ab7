"""A graph that is running, from outside: who is there, what it says, and its nodes' parameters.

Calls wait for their answer, and spin a node of their own meanwhile: none of the caller's callbacks runs.
"""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import rclpy
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.runtime.environment import prepare_environment
from forest_msgs_py.runtime.node import NodeFailure, subscription
from forest_msgs_py.runtime.publishers import UNKNOWN, publishers_of

LOOK = 3.0  # [s] for a node to be found, and to answer
SETTLE = 0.5  # [s] in which who is there is found
AGAIN = 0.5  # [s] after which a question without an answer is put once more
LATCHED = 0.3  # [s] for what was said before to arrive, once its speaker is known
POLL = 0.02  # [s]


class NoAnswer(NodeFailure):
    """Something that was asked for is not there, or was refused; the text is one sentence."""


class LiveGraph:
    """Nodes of one namespace.

    Args:
        namespace: of the graph, "/" or "/name".
        name: of the node that asks, hidden from lists.
    """

    def __init__(self, namespace: str, name: str = "_asker") -> None:
        prepare_environment()
        self._namespace = namespace
        self._context = rclpy.Context()
        rclpy.init(context=self._context, args=[], signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node(
            name,
            context=self._context,
            namespace=namespace,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)

    @property
    def place(self) -> str:
        """Where this graph is, in words."""
        return f"ROS domain {os.environ.get('ROS_DOMAIN_ID') or '0'}, namespace {self._namespace}"

    def has(self, name: str) -> bool:
        """Whether a node of this name is known now."""
        return (name, self._namespace) in self._node.get_node_names_and_namespaces()

    def wait_for(self, name: str) -> bool:
        """Whether a node of this name is found within `LOOK`."""
        return self._until(lambda: self.has(name), LOOK)

    def get(self, node: str, names: Sequence[str]) -> dict[str, Any]:
        """Return some of a node's parameters.

        Raises:
            NoAnswer: the node does not answer, or has no such parameter.
        """
        answer = self._call(node, "get_parameters", GetParameters, GetParameters.Request(names=list(names)))
        found = dict(zip(names, map(parameter_value_to_python, answer.values), strict=False))
        missing = [name for name in names if found.get(name) is None]
        if missing:
            raise NoAnswer(f"{node} has no parameter {missing[0]}; it is none of this project's, or old")
        return found

    def set(self, node: str, values: Mapping[str, Any]) -> None:
        """Set some of a node's parameters.

        Raises:
            NoAnswer: the node does not answer, or refuses.
        """
        told: list[ParameterMessage] = [
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
        ]
        answer = self._call(node, "set_parameters", SetParameters, SetParameters.Request(parameters=told))
        for name, result in zip(values, answer.results, strict=True):
            if not result.successful:
                raise NoAnswer(f"{node} refuses {name} = {values[name]!r}: {result.reason}")

    def trigger(self, node: str, service: str) -> str:
        """Call a Trigger service of a node, and return what it says; it may be called more than once.

        Raises:
            NoAnswer: the node does not answer, or refuses.
        """
        answer = self._call(node, service, Trigger, Trigger.Request())
        if not answer.success:
            raise NoAnswer(answer.message)
        return str(answer.message)

    def wait_for_message(self, topic: Topic, enough: Callable[[Any], bool], seconds: float) -> Any:
        """Return the first message of a topic that is enough, or None if none comes within some time [s]."""
        heard: list[Any] = []
        self._listen(topic, heard, lambda: any(map(enough, heard)), seconds)
        return next(filter(enough, heard), None)

    def has_message(self, topic: Topic) -> bool:
        """Whether something is said on a topic within `LOOK`."""
        heard: list[Any] = []
        self._listen(topic, heard, lambda: bool(heard), LOOK)
        return bool(heard)

    def is_stopped(self) -> bool:
        """Whether a node tells that it stands still after an emergency stop."""
        heard: list[Any] = []
        self._listen(topics.EMERGENCY_STOPPED, heard, lambda: any(said.data for said in heard), LATCHED)
        return any(said.data for said in heard)

    def publishers_of(self, topic: Topic) -> list[str]:
        """Return the names of the nodes that publish on a topic, once those there are were found."""
        self._until(lambda: False, SETTLE)
        self._until(lambda: UNKNOWN not in publishers_of(self._node, topic), LOOK)
        return publishers_of(self._node, topic)

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown(timeout_sec=0.0)
        self._node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    def _listen(self, topic: Topic, heard: list[Any], enough: Callable[[], bool], seconds: float) -> None:
        made = subscription(self._node, topic, heard.append)
        self._until(lambda: bool(made.get_publisher_count()), LOOK)
        self._until(enough, seconds)
        self._node.destroy_subscription(made)

    def _call(self, node: str, service: str, kind: Any, request: Any) -> Any:
        client = self._node.create_client(kind, f"{self._namespace.rstrip('/')}/{node}/{service}")
        try:
            if not self._until(client.service_is_ready, LOOK):
                raise NoAnswer(f"no node {node} answers in {self.place}")
            # A question is lost if the node has not found the asker yet, and so is an answer. To set a
            # parameter twice does no harm.
            asked: list[Any] = []
            for _ in range(round(LOOK / AGAIN)):
                asked.append(client.call_async(request))
                if self._until(lambda: any(future.done() for future in asked), AGAIN):
                    return next(future.result() for future in asked if future.done())
            raise NoAnswer(f"{node} did not answer within {LOOK:g} s")
        finally:
            self._node.destroy_client(client)

    def _until(self, condition: Callable[[], bool], seconds: float) -> bool:
        """Spin until a condition holds, at most so long; tell whether it does."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                return False
            self._executor.spin_once(timeout_sec=POLL)
        return True
