"""A graph with the simulator, and a station that has joined it, for all tests of this folder."""

from typing import NamedTuple

import pytest

rclpy = pytest.importorskip("rclpy")

from crane_ears import CraneEars
from graph_processes import nodes_of
from rclpy.node import Node
from running_graph import free_port, running, wait_for_text
from stall import Stall

BEGINS_S, SHUTS_S = 0.1, 0.25
MACHINE = "c180_hoses"  # the page and its hands are judged, not how long a crane rocks on its oil


LAST = "test_stations_end.py"  # it kills the station


def pytest_collection_modifyitems(items):
    """Run last what leaves no station behind, whatever else is chosen."""
    items.sort(key=lambda item: item.path.name == LAST)


class Crane(NamedTuple):
    """A running graph with a station."""

    address: str
    port: int
    ears: CraneEars
    pids: dict[str, int]  # of the nodes
    node: Node  # of the tests

    def stall(self):
        """What the host takes away from the nodes and from the test, from now on."""
        return Stall(*self.pids.values())

    def assert_it_stopped(self, stall):
        """The newest stop began and ended in time."""
        stop, lost = self.ears.stop(), stall.seconds()
        assert stop.released - stop.heartbeat < BEGINS_S + lost
        assert stop.shut - stop.released < SHUTS_S + lost


@pytest.fixture(scope="session")
def crane(tmp_path_factory, session_domain_id):
    folder, port = tmp_path_factory.mktemp("station"), free_port()
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=session_domain_id)
    node = Node("ears", context=context, enable_rosout=False, start_parameter_services=False)
    graph_log, station_log = folder / "graph.log", folder / "station.log"
    options = ("--join", "--port", str(port), "--no-browser", "--machine", MACHINE)
    cycles = ("--cycles", str(folder / "cycles"), "--machine", MACHINE)
    try:
        with (
            running("forest_bringup.graph", graph_log, session_domain_id, *cycles) as graph,
            running("forest_station.station", station_log, session_domain_id, *options) as station,
        ):
            wait_for_text(station, station_log, "the page is at")
            wait_for_text(graph, graph_log, "waiting for a joystick")
            pids = nodes_of(graph) | nodes_of(station)
            yield Crane(f"http://127.0.0.1:{port}", port, CraneEars(node), pids, node)
    finally:
        node.destroy_node()
        context.try_shutdown()
