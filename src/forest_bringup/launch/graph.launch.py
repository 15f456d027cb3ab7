"""The live graph by ROS's own launch: the nodes of `scripts/graph.sh`, with the same choices.

    ros2 launch forest_bringup graph.launch.py scheme:=coordinated joystick:=thesis record:=/tmp/bag

A node that ends takes the others with it, but for joystick source, recorder and viewers. The supervisor of
`scripts/graph.sh` does more: it claims the domain, watches for other talkers, gives the nodes of the control
loop precedence, and says zero voltage itself when the valve driver dies. Prefer it where iron moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from forest_bringup.graph import graph_nodes, parse_options
from forest_bringup.graph_command import part_of
from forest_bringup.launch_description import launch_description
from forest_bringup.supervisor import NodeSpec

if TYPE_CHECKING:
    from launch import LaunchDescription

VALUES = ("machine", "scheme", "namespace", "profile", "joystick", "cycles", "foxglove", "record", "only")
FLAGS = ("no_simulator", "shadow", "viewer", "twist", "monitor")


def generate_launch_description() -> LaunchDescription:
    """Return the launch arguments, which are the options of `scripts/graph.sh`, and the nodes."""
    return launch_description(VALUES, FLAGS, _nodes)


def _nodes(words: Sequence[str]) -> tuple[str, list[NodeSpec]]:
    options = parse_options(words)
    return options.namespace, part_of(graph_nodes(options), options.only)
