"""The station as a node: a server of pages beside the graph, in a thread and loop of its own."""

import asyncio
import sys
import threading

from rclpy.node import Node

from forest_description.machine import load_machine
from forest_msgs_py.runtime.node import NodeFailure, run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_station.graph.crane_graph import CraneGraph
from forest_station.server.app import serve
from forest_station.server.entrance import entrance
from forest_station.server.server_state import Station
from forest_station.server.station_parameters import StationParameters


class StationNode(Node):
    """Shell around `CraneGraph` and the server."""

    def __init__(self) -> None:
        super().__init__("station")
        machine = load_machine(declare(self, MachineParameter).machine)
        self._options = declare(self, StationParameters)
        self._entrance = entrance(self._options)
        self._graph = CraneGraph(self, machine)

    def run(self, stopping: threading.Event) -> None:
        """Serve until told to stop."""
        p = self._options
        try:
            asyncio.run(self._serve(stopping))
        except OSError as error:
            text = f"port {p.port} of {p.host!r} cannot be had: {error.strerror}; allowed: one that is free"
            raise NodeFailure(text) from error

    async def _serve(self, stopping: threading.Event) -> None:
        await serve(Station(self._graph, self._options), self._entrance, lambda: _set(stopping))


async def _set(event: threading.Event) -> None:
    """Wait until a thread has set an event."""
    await asyncio.to_thread(event.wait)


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(StationNode))


if __name__ == "__main__":
    main()
