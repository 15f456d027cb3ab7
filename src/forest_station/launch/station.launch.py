"""Graph and operator's page by ROS's own launch: the nodes of `scripts/station.sh`, with the same choices.

    ros2 launch forest_station station.launch.py port:=9000 bags:=/tmp/bags
    ros2 launch forest_station station.launch.py join:=true

The station logs the page's address; nobody opens it. What the supervisor of `scripts/station.sh` does more is
told in forest_bringup's `graph.launch.py`. Prefer it where iron moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from forest_bringup.graph_command import part_of
from forest_bringup.launch_description import launch_description
from forest_bringup.supervisor import NodeSpec
from forest_station.station import parse_options, station_nodes

if TYPE_CHECKING:
    from launch import LaunchDescription

VALUES = (
    "machine",
    "scheme",
    "namespace",
    "profile",
    "host",
    "port",
    "bags",
    "cycles",
    "certificate",
    "key",
    "only",
)
FLAGS = ("join",)


def generate_launch_description() -> LaunchDescription:
    """Return the launch arguments, which are the options of `scripts/station.sh`, and the nodes."""
    return launch_description(VALUES, FLAGS, _nodes)


def _nodes(words: Sequence[str]) -> tuple[str, list[NodeSpec]]:
    options = parse_options(words)
    return options.namespace, part_of(station_nodes(options), options.only)
