"""What a running node lets others do to it: services, an action, parameters that act when they are set."""

import importlib
from collections.abc import Callable, Mapping
from typing import Any, Protocol

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
    types = _types(f"{package}.srv")
    if types is None:
        return False
    for name, (kind, answer) in services.items():
        node.create_service(getattr(types, kind), f"~/{name}", answer)
    return True


class Goal:
    """A goal of an action, accepted and under way until the node ends it."""

    def __init__(self, kind: Any, handle: Any) -> None:
        self._kind, self._handle = kind, handle

    @property
    def request(self) -> Any:
        """What was asked for: a message of the action's Goal."""
        return self._handle.request

    def tell(self, fill: Callable[[Any], None]) -> None:
        """Publish the feedback that `fill` has filled in."""
        feedback = self._kind.Feedback()
        fill(feedback)
        self._handle.publish_feedback(feedback)

    def end(self, success: bool, **result: Any) -> None:
        """End it with a result's values; without success, one that a client has cancelled is cancelled."""

        def answer(handle: Any) -> Any:
            failed = handle.canceled if handle.is_cancel_requested else handle.abort
            (handle.succeed if success else failed)()
            return self._kind.Result(**result)

        self._handle.execute(answer)


class Goals(Protocol):
    """What a node does with the goals of an action."""

    def begin(self, request: Any) -> bool:
        """Begin what is asked for; False: it is refused."""

    def accept(self, goal: Goal) -> None:
        """Keep what has just begun, until it ends."""

    def cancel(self) -> bool:
        """Begin to end what is under way; False: there is nothing."""


def offer_action(node: Node, package: str, kind: str, name: str, goals: Goals) -> bool:
    """Offer an action ``~/NAME`` of a package's type; return whether it is installed.

    No callback waits for a goal's end: rclpy's executors never rest while one does.
    """
    types = _types(f"{package}.action")
    if types is None:
        return False
    from rclpy.action import ActionServer, CancelResponse, GoalResponse

    action = getattr(types, kind)
    ActionServer(
        node,
        action,
        f"~/{name}",
        execute_callback=lambda _: action.Result(),
        goal_callback=lambda request: GoalResponse.ACCEPT if goals.begin(request) else GoalResponse.REJECT,
        handle_accepted_callback=lambda handle: goals.accept(Goal(action, handle)),
        cancel_callback=lambda _: CancelResponse.ACCEPT if goals.cancel() else CancelResponse.REJECT,
    )
    return True


def _types(module: str) -> Any:
    """Return a module of message types; None: its package is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        return None


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
