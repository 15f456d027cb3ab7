"""The launch file offers what `scripts/graph.sh` offers; ROS's own launch is on no package index."""

import pytest
from launch_files import SOURCES, arguments_of, is_installed, launched, options_of

from forest_bringup.graph import graph_nodes, parse_options

FILE = SOURCES / "forest_bringup" / "launch" / "graph.launch.py"
GIVEN = {"joystick": "thesis", "foxglove": "8765", "record": "bag", "cycles": "cycles"}
NODES = graph_nodes(parse_options([word for name, value in GIVEN.items() for word in (f"--{name}", value)]))


def test_the_arguments_are_the_options_of_graph_sh(capsys):
    assert arguments_of(FILE) == options_of(parse_options, capsys)


@pytest.mark.parametrize("spec", NODES, ids=lambda spec: spec.name)
def test_each_node_is_an_executable_of_its_package(spec):
    assert is_installed(spec)


def test_launch_starts_the_nodes_of_graph_sh():
    assert launched(FILE, GIVEN) == [spec.module.split(".")[1] for spec in NODES]
