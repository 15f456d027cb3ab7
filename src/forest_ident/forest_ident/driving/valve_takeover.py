"""What an experiment changes in a graph that is running, and puts back: who commands the valves, and how.

| node | parameter | during an experiment |
|---|---|---|
| valve_driver | compensate | false: what is commanded is what the valve gets |
| controller | hands_off | true: it commands nothing, and is disarmed |
"""

from __future__ import annotations

from typing import Any

from forest_msgs_py.interfaces import topics
from forest_msgs_py.introspection.live_graph import LiveGraph, NoAnswer

DRIVER, CONTROLLER = "valve_driver", "controller"
WANTED: dict[str, dict[str, Any]] = {DRIVER: {"compensate": False}, CONTROLLER: {"hands_off": True}}


class Switches:
    """The parameters as they were found, and the way back to them.

    Args:
        graph: that is running. A controller need not be there.

    Raises:
        NoAnswer: there is no valve driver, or a node does not know the parameter.
    """

    def __init__(self, graph: LiveGraph) -> None:
        self._graph = graph
        self.found: dict[str, dict[str, Any]] = {}
        self.include(DRIVER)
        if CONTROLLER in graph.publishers_of(topics.VALVE_COMMANDS):
            self.include(CONTROLLER)

    def include(self, node: str) -> None:
        """Remember how a node is found.

        Raises:
            NoAnswer: it does not answer, or does not know the parameter.
        """
        self.found[node] = self._graph.get(node, list(WANTED[node]))

    def throw(self) -> None:
        """Set what an experiment needs, the controller first.

        Raises:
            NoAnswer: a node does not answer, or refuses.
        """
        for node in reversed(self.found):
            self._graph.set(node, WANTED[node])

    def restore(self) -> str:
        """Put back what was found, the driver first; return what could not be, "" if all could."""
        failed = [self._put_back(node, values) for node, values in self.found.items()]
        return "; ".join(filter(None, failed))

    def _put_back(self, node: str, values: dict[str, Any]) -> str:
        try:
            self._graph.set(node, values)
        except NoAnswer as error:
            told = ", ".join(f"{name} = {value}" for name, value in values.items())
            return f"{node}: {told} could not be put back ({error})"
        return ""
