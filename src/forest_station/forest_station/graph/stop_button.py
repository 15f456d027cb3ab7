"""The emergency stop as the station presses, sees and resets it."""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topics import message_class
from forest_msgs_py.runtime.node import publisher
from forest_station.graph.service_calls import NoAnswer, ServiceCalls

PART = "emergency stop"  # of a node's diagnostics
PRESSED = "pressed"  # value of that part
RESETS = {
    "controller": "reset_emergency_stop",
    "valve_driver": "valve_driver/reset_emergency_stop",
    "simulator": "simulator/reset_emergency_stop",
}


class StopButton:
    """Presses and resets the emergency stop, and knows every node's state.

    Args:
        node: of the station.
        calls: services of the graph.
        changed: is called in the executor's thread when a node's state has changed.
    """

    def __init__(self, node: Node, calls: ServiceCalls, changed: Callable[[], None]) -> None:
        self.sources: dict[str, bool] = {}  # whether a node stands still, by its name
        self._calls, self._changed = calls, changed
        self._command: Any = publisher(node, topics.EMERGENCY_STOP)
        self._message = message_class(topics.EMERGENCY_STOP)

    @property
    def active(self) -> bool:
        """Whether any node stands still after an emergency stop."""
        return any(self.sources.values())

    def press(self) -> str:
        """Stop everything; return who hears it, in a sentence.

        Raises:
            NoAnswer: nobody does.
        """
        self._command.publish(self._message(data=True))
        if self._command.get_subscription_count() == 0:
            raise NoAnswer("Nobody hears the emergency stop: neither controller nor valve driver is there.")
        return "The emergency stop is pressed."

    async def reset(self) -> str:
        """Reset the emergency stop; return a sentence.

        Raises:
            NoAnswer: a node refuses, or nobody is there to be asked.
        """
        there = [name for name in RESETS if name in self.sources]
        if not there:
            raise NoAnswer("No node tells of an emergency stop.")
        for name in there:
            answer = await self._calls.call(Trigger, RESETS[name], Trigger.Request())
            if not answer.success:
                raise NoAnswer(f"{name}: {answer.message}.")
        return "The emergency stop is reset."

    def hear(self, source: str, values: dict[str, str]) -> None:
        """Take in what a node's diagnostics tell of its emergency stop."""
        pressed = values.get(PRESSED) == "true"
        if self.sources.get(source) != pressed:
            self.sources = {**self.sources, source: pressed}
            self._changed()

    def forget(self, source: str) -> None:
        """Forget a node that has fallen silent: a stop that it knew of is not ours to keep."""
        if source in self.sources:
            self.sources = {name: pressed for name, pressed in self.sources.items() if name != source}
            self._changed()
