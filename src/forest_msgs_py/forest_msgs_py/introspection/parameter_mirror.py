"""The parameters of all nodes of a graph as they are, and a way to set them."""

from collections.abc import Callable, Mapping
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import qos_profile_parameter_events

from forest_msgs_py.introspection.parameter_survey import ParameterSurvey, plain
from forest_msgs_py.runtime.parameter_table import converted


class ParameterMirror:
    """Asks each node once, and follows /parameter_events from then on; in the thread of the executor.

    Args:
        node: that asks.
        changed: called with the parameters that have another value, as in `values`.
    """

    def __init__(self, node: Node, changed: Callable[[dict[str, Any]], object]) -> None:
        self.values: dict[str, Any] = {}
        """By `/NODE.NAME`; the mapping is replaced, never changed, so that another thread may read it."""
        self._node, self._changed = node, changed
        self._clients: dict[str, Any] = {}
        self._survey = ParameterSurvey(node, self._told)
        node.create_subscription(
            ParameterEvent, "/parameter_events", self._on_event, qos_profile_parameter_events
        )

    def look(self) -> None:
        """Ask the nodes that have appeared."""
        self._survey.look()

    def set(self, values: Mapping[str, Any], refused: Callable[[str], object]) -> None:
        """Ask nodes to set parameters; what they set comes by `changed`.

        Args:
            values: by `/NODE.NAME`.
            refused: called with one sentence for each that is not set.
        """
        for key, given in values.items():
            if key not in self.values:
                refused(f"no node has told a parameter {key}")
                continue
            value = converted(self.values[key], given)
            if value is None:
                kind = type(self.values[key]).__name__
                refused(f"{key} is {given!r}; allowed: a value of type {kind}")
                continue
            self._ask(key, value, refused)

    def _ask(self, key: str, value: Any, refused: Callable[[str], object]) -> None:
        node, _, name = key.partition(".")
        if node not in self._clients:
            self._clients[node] = self._node.create_client(SetParameters, f"{node}/set_parameters")
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])

        def answered(future: Any) -> None:
            (result,) = future.result().results
            if not result.successful:
                refused(f"{node} refuses {name} = {value!r}: {result.reason}")

        self._clients[node].call_async(request).add_done_callback(answered)

    def _on_event(self, event: Any) -> None:
        told = [*event.new_parameters, *event.changed_parameters]
        self._told(event.node, plain({one.name: parameter_value_to_python(one.value) for one in told}))

    def _told(self, node: str, parameters: dict[str, Any]) -> None:
        told = {f"{node}.{name}": value for name, value in parameters.items()}
        new = {key: value for key, value in told.items() if self.values.get(key) != value}
        self.values = self.values | new
        if new:
            self._changed(new)
