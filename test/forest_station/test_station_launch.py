"""The launch file offers what `scripts/station.sh` offers; ROS's own launch is on no package index."""

import pytest
from launch_files import SOURCES, arguments_of, is_installed, launched, options_of

from forest_station.station import parse_options, station_nodes

FILE = SOURCES / "forest_station" / "launch" / "station.launch.py"
BROWSER = {"no-browser"}  # launch opens none
NODES = station_nodes(parse_options([]))


def test_the_arguments_are_the_options_of_station_sh(capsys):
    assert arguments_of(FILE) == options_of(parse_options, capsys) - BROWSER


@pytest.mark.parametrize("spec", NODES, ids=lambda spec: spec.name)
def test_each_node_is_an_executable_of_its_package(spec):
    assert is_installed(spec)


def test_launch_starts_the_nodes_of_station_sh():
    assert launched(FILE, {}) == [spec.module.split(".")[1] for spec in NODES]
    assert launched(FILE, {"join": "true"}) == ["station_node"]
