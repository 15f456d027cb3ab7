"""What a running node lets others do to it: Trigger services, and parameters that act when they are set."""

import importlib
from collections.abc import Callable, Mapping
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger


def offer_triggers(node: Node, actions: Mapping[str, Callable[[], tuple[bool, str]]]) -> None:
    """Offer services ``~/NAME``; an action gives success and a sentence."""
    for name, act in actions.items():
        node.create_service(Trigger, f"~/{name}", _answer(act))


def offer_services(
    node: Node, package: str, services: Mapping[str, tuple[str, Callable[[Any, Any], Any]]]
) -> bool:
    """Offer services ``~/NAME`` of a package's types; return whether it is installed.

    Args:
        node: that offers them.
        package: with the types.
        services: type, and what fills a request's response in and returns it, by name.
    """
    try:
        types = importlib.import_module(f"{package}.srv")
    except ImportError:
        return False
    for name, (kind, answer) in services.items():
        node.create_service(getattr(types, kind), f"~/{name}", answer)
    return True


def _answer(act: Callable[[], tuple[bool, str]]) -> Callable[[Any, Any], Any]:
    def answer(_request: Any, response: Any) -> Any:
        response.success, response.message = act()
        return response

    return answer


def offer_parameters(
    node: Node,
    values: Mapping[str, float],
    texts: Mapping[str, str],
    highest: Mapping[str, float],
    refuse: Callable[[str, Any], str],
    apply: Callable[[str, Any], None],
) -> None:
    """Declare numbers that may be set while the node runs; 2 is as good as 2.0.

    Args:
        node: whose parameters they are.
        values: at the start.
        texts: description of each.
        highest: of each; the lowest is 0.
        refuse: says why a parameter may not have a value; "" if it may.
        apply: acts on a value that was set.
    """
    for name, value in values.items():
        descriptor = ParameterDescriptor(description=texts[name], dynamic_typing=True)
        descriptor.floating_point_range = [FloatingPointRange(from_value=0.0, to_value=highest[name])]
        node.declare_parameter(name, value, descriptor)

    def check(parameters: list[Parameter]) -> SetParametersResult:
        problems = [refuse(parameter.name, parameter.value) for parameter in parameters]
        return SetParametersResult(successful=not any(problems), reason="; ".join(filter(None, problems)))

    def act(parameters: list[Parameter]) -> None:
        for parameter in parameters:
            apply(parameter.name, parameter.value)

    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(act)
