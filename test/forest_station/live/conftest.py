"""A graph with the simulator, and a station that has joined it, for all tests of a module."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

rclpy = pytest.importorskip("rclpy")

from crane_ears import CraneEars
from graph_processes import nodes_of
from rclpy.node import Node
from running_graph import free_port, running, wait_for_text


class Crane(NamedTuple):
    """A running graph with a station."""

    address: str
    port: int
    ears: CraneEars
    pids: dict[str, int]  # of the nodes


@pytest.fixture(scope="module")
def crane(tmp_path_factory, session_domain_id):
    folder, port = tmp_path_factory.mktemp("station"), free_port()
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=session_domain_id)
    node = Node("ears", context=context, enable_rosout=False, start_parameter_services=False)
    graph_log, station_log = folder / "graph.log", folder / "station.log"
    options = ("--join", "--port", str(port), "--no-browser")
    try:
        with (
            running("forest_bringup.graph", graph_log, session_domain_id) as graph,
            running("forest_station.station", station_log, session_domain_id, *options) as station,
        ):
            wait_for_text(station, station_log, "the page is at")
            wait_for_text(graph, graph_log, "waiting for a joystick")
            pids = nodes_of(graph) | nodes_of(station)
            yield Crane(f"http://127.0.0.1:{port}", port, CraneEars(node), pids)
    finally:
        node.destroy_node()
        context.try_shutdown()
