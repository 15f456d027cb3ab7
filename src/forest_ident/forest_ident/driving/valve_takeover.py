"""Take the valves over from a running graph for an experiment, and give them back afterwards.

| node | parameter | during an experiment |
|---|---|---|
| valve_driver | compensate | false: the valve gets the commanded voltage |
| controller | hands_off | true: it commands nothing, and is disarmed |
"""

from collections.abc import Collection
from typing import Any

from forest_msgs_py.interfaces import topics
from forest_msgs_py.introspection.live_graph import LiveGraph, NoAnswer
from forest_msgs_py.runtime.publishers import UNKNOWN

DRIVER, CONTROLLER = "valve_driver", "controller"
WANTED: dict[str, dict[str, Any]] = {DRIVER: {"compensate": False}, CONTROLLER: {"hands_off": True}}


class ValveTakeover:
    """The nodes' parameters as they were found, and the way back to them.

    Args:
        graph: that is running. A controller need not be there.

    Raises:
        NoAnswer: there is no valve driver, or a node does not know the parameter.
    """

    def __init__(self, graph: LiveGraph) -> None:
        self._graph = graph
        self.found: dict[str, dict[str, Any]] = {}
        self._include(DRIVER)
        if CONTROLLER in graph.publishers_of(topics.VALVE_COMMANDS):
            self._include(CONTROLLER)

    def _include(self, node: str) -> None:
        """Remember a node's parameters, if it answers and knows them."""
        self.found[node] = self._graph.get(node, list(WANTED[node]))

    def apply(self) -> None:
        """Set the parameters for an experiment, the controller's first.

        Raises:
            NoAnswer: a node does not answer, or refuses; what was set is put back.
        """
        try:
            for node in reversed(self.found):
                self._graph.set(node, WANTED[node])
        except NoAnswer:
            self.restore()
            raise

    def close(self) -> None:
        """Put back what was found, and leave the graph.

        Raises:
            NoAnswer: something could not be put back.
        """
        failed = self.restore()
        self._graph.close()
        if failed:
            raise NoAnswer(failed)

    def is_alone(self, name: str, publishers: Collection[str], begun: bool) -> bool:
        """Tell whether only the operator commands the valves; a controller that came late is taken off.

        Args:
            name: the operator's.
            publishers: names of the nodes that publish valve commands.
            begun: whether the experiment has begun.

        Raises:
            NoAnswer: another node publishes valve commands that cannot be taken off.
        """
        others = [node for node in publishers if node not in (name, *self.found)]
        if others == [CONTROLLER] and not begun:
            self._include(CONTROLLER)
            self.apply()
        elif others and (begun or UNKNOWN not in others):
            raise NoAnswer(f"{others[0]} publishes valve_commands, too; stop it first")
        return not others

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
