"""Asks every node of a graph for its parameters, once, without waiting for any of them."""

import math
import time
from collections.abc import Callable, Collection
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

PATIENCE = 10.0  # [s] for a node to offer its parameters and to answer
ASK_AGAIN = 1.0  # [s]; who does not know us yet, as a busy machine is slow to tell, cannot answer


class ParameterSurvey:
    """Looks for nodes and asks them.

    Args:
        node: that asks; its own parameters are told, too.
        told: called in the node's executor with a node's resolved name and its parameters.
    """

    def __init__(self, node: Node, told: Callable[[str, dict[str, Any]], None]) -> None:
        self._node, self._told = node, told
        own = {name: given.value for name, given in node.get_parameters_by_prefix("").items()}
        self._told(node.get_fully_qualified_name(), plain(own))
        self._known = {node.get_fully_qualified_name()}
        self._open: list[_ParameterRequest] = []

    def has_heard(self, names: Collection[str]) -> bool:
        """Whether these nodes (as in this namespace) have answered, or will not."""
        namespace = self._node.get_namespace().rstrip("/")
        asked = {f"{namespace}/{name}" for name in names}
        return asked <= self._known and not asked & {question.name for question in self._open}

    def look(self) -> None:
        """Ask those who have appeared; forget those who do not answer."""
        for name, namespace in self._node.get_node_names_and_namespaces():
            whole = f"{namespace.rstrip('/')}/{name}"
            if whole not in self._known and not name.startswith("_"):
                self._known.add(whole)
                self._open.append(_ParameterRequest(self._node, whole, self._told))
        for question in self._open:
            question.go_on()
        self._open = [question for question in self._open if not question.over]


class _ParameterRequest:
    """Which parameters a node has, and then what they are."""

    def __init__(self, node: Node, name: str, told: Callable[[str, dict[str, Any]], None]) -> None:
        self.over = False
        self._node, self.name, self._told = node, name, told
        self._end = time.monotonic() + PATIENCE
        self._names = node.create_client(ListParameters, f"{name}/list_parameters")
        self._values = node.create_client(GetParameters, f"{name}/get_parameters")
        self._asked = -math.inf

    def go_on(self) -> None:
        """Ask when the node is there, and now and then again; give up when it does not answer."""
        now = time.monotonic()
        if self.over:
            return
        if now > self._end:
            self._finish()
        elif (
            now - self._asked > ASK_AGAIN
            and self._names.service_is_ready()
            and self._values.service_is_ready()
        ):
            self._asked = now
            self._names.call_async(ListParameters.Request()).add_done_callback(self._listed)

    def _listed(self, answer: Any) -> None:
        if self.over:
            return
        names = list(answer.result().result.names)
        request = GetParameters.Request(names=names)
        self._values.call_async(request).add_done_callback(lambda values: self._got(names, values))

    def _got(self, names: list[str], answer: Any) -> None:
        if not self.over:
            values = map(parameter_value_to_python, answer.result().values)
            self._finish()
            self._told(self.name, plain(dict(zip(names, values, strict=False))))

    def _finish(self) -> None:
        self.over = True
        self._node.destroy_client(self._names)
        self._node.destroy_client(self._values)


def plain(parameters: dict[str, Any]) -> dict[str, Any]:
    """Parameters as YAML can hold them: arrays become lists, those without a value are left out."""
    return {
        name: value if isinstance(value, (bool, int, float, str)) else list(value)
        for name, value in parameters.items()
        if value is not None
    }
