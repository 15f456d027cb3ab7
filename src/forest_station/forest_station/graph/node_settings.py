"""Parameters of the graph's nodes: what they are, may be, and are set to."""

import math
from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import ParameterType, SetParametersResult
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python

from forest_station.graph.service_calls import NoAnswer, ServiceCalls

NODES = ("controller", "valve_driver", "simulator")
HIDDEN = ("qos_overrides.", "start_type_description_service", "use_sim_time")
TYPES = {
    ParameterType.PARAMETER_BOOL: "bool",
    ParameterType.PARAMETER_INTEGER: "int",
    ParameterType.PARAMETER_DOUBLE: "float",
    ParameterType.PARAMETER_STRING: "str",
    ParameterType.PARAMETER_BOOL_ARRAY: "bool[]",
    ParameterType.PARAMETER_INTEGER_ARRAY: "int[]",
    ParameterType.PARAMETER_DOUBLE_ARRAY: "float[]",
    ParameterType.PARAMETER_STRING_ARRAY: "str[]",
}
CHOICES = "allowed: one of "  # begins a descriptor's constraints, see `node_parameters`


class NodeSettings:
    """Parameters of the nodes in `NODES`.

    Args:
        calls: services of the graph.
    """

    def __init__(self, calls: ServiceCalls) -> None:
        self._calls = calls
        self._described: dict[str, dict[str, dict[str, Any]]] = {}

    async def read(self, node: str) -> dict[str, dict[str, Any]]:
        """Return a node's parameters: `value`, `type`, `range`, `choices`, `live`, `text` of each.

        Raises:
            NoAnswer: the node is not there.
        """
        if node not in self._described:
            self._described[node] = await self._describe(node)
        told = self._described[node]
        request = GetParameters.Request(names=list(told))
        answer = await self._calls.call(GetParameters, f"{node}/get_parameters", request)
        values = map(parameter_value_to_python, answer.values)
        return {
            name: {**told[name], "value": _plain(value)} for name, value in zip(told, values, strict=True)
        }

    async def set(self, node: str, name: str, value: Any) -> str:
        """Set a node's parameter; return a sentence.

        Raises:
            NoAnswer: the node is not one of ours, is not there, or refuses the value.
        """
        if node not in NODES:
            raise NoAnswer(f"Node is {node!r}; allowed: {', '.join(NODES)}.")
        if name not in (self._described.get(node) or await self.read(node)):
            raise NoAnswer(f"{node} has no parameter {name!r}.")
        try:
            parameter = Parameter(name, value=_typed(self._described[node][name]["type"], value))
            told = parameter.to_parameter_msg()
        except (TypeError, ValueError, AssertionError) as error:
            kind = self._described[node][name]["type"]
            raise NoAnswer(f"{node}: {name} is {value!r}; allowed: a value of type {kind}.") from error
        request = SetParameters.Request(parameters=[told])
        answer = await self._calls.call(SetParameters, f"{node}/set_parameters", request)
        result: SetParametersResult = answer.results[0]
        if not result.successful:
            raise NoAnswer(f"{node} refuses {name} = {value!r}: {result.reason}")
        return f"{node}: {name} is {value!r}."

    def forget(self, node: str) -> None:
        """Forget what a node is: it has gone."""
        self._described.pop(node, None)

    async def _describe(self, node: str) -> dict[str, dict[str, Any]]:
        listed = await self._calls.call(ListParameters, f"{node}/list_parameters", ListParameters.Request())
        names = sorted(name for name in listed.result.names if not name.startswith(HIDDEN))
        request = DescribeParameters.Request(names=names)
        answer = await self._calls.call(DescribeParameters, f"{node}/describe_parameters", request)
        return {told.name: _described(told) for told in answer.descriptors if told.type in TYPES}


def _described(told: Any) -> dict[str, Any]:
    """Return what a descriptor tells."""
    ranges: Sequence[Any] = told.floating_point_range or told.integer_range
    limits = [ranges[0].from_value, ranges[0].to_value] if ranges else []
    constraint: str = told.additional_constraints
    choices = constraint.removeprefix(CHOICES).split(", ") if constraint.startswith(CHOICES) else None
    return {
        "type": TYPES[told.type],
        "text": told.description,
        "range": [limit if math.isfinite(limit) else None for limit in limits] or None,
        "choices": choices,
        "live": not told.read_only,
    }


def _typed(kind: str, value: Any) -> Any:
    """Return a value of JSON, which does not tell 2 from 2.0, in a parameter's type.

    Raises:
        ValueError: it has another type.
    """
    if kind.endswith("[]"):
        if not isinstance(value, list):
            raise ValueError(value)
        return [_typed(kind.removesuffix("[]"), item) for item in value]
    if kind == "float" and type(value) in (int, float):
        return float(value)
    if type(value).__name__ != kind:
        raise ValueError(value)
    return value


def _plain(value: Any) -> Any:
    """Return a value that JSON can hold."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else [_plain(item) for item in value]
