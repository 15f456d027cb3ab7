"""The live graph by ROS's own launch: the nodes of `scripts/graph.sh`, with the same choices.

    ros2 launch forest_bringup graph.launch.py scheme:=coordinated joystick:=thesis record:=/tmp/bag

A node that ends takes the others with it, but for joystick source, recorder and viewers. The supervisor of
`scripts/graph.sh` does more: it claims the domain, watches for other talkers, gives the nodes of the control
loop precedence, and says zero voltage itself when the valve driver dies. Prefer it where iron moves.
"""

from __future__ import annotations

from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from forest_bringup.graph import graph_nodes, parse_options
from forest_bringup.supervisor import NodeSpec
from launch import LaunchContext, LaunchDescription

VALUES = ("machine", "scheme", "namespace", "profile", "joystick", "cycles", "foxglove", "record")
FLAGS = ("no_simulator", "shadow", "viewer")
END_WITH_LAUNCH = (
    "setpriv --pdeathsig TERM"  # of util-linux: no orphan commands a crane after `kill -9` of launch
)


def generate_launch_description() -> LaunchDescription:
    """Return the launch arguments, which are the options of `scripts/graph.sh`, and the nodes."""
    values = [DeclareLaunchArgument(name, default_value="") for name in VALUES]
    flags = [DeclareLaunchArgument(name, default_value="false", choices=["true", "false"]) for name in FLAGS]
    return LaunchDescription([*values, *flags, OpaqueFunction(function=_nodes)])


def _nodes(context: LaunchContext) -> list[Node]:
    given = {name: LaunchConfiguration(name).perform(context) for name in (*VALUES, *FLAGS)}
    words = [word for name in VALUES if given[name] for word in (f"--{name}", given[name])]
    words += [f"--{name.replace('_', '-')}" for name in FLAGS if given[name] == "true"]
    options = parse_options(words)
    return [_node(spec, options.namespace) for spec in graph_nodes(options)]


def _node(spec: NodeSpec, namespace: str) -> Node:
    package, executable = spec.module.split(".")
    ends_the_graph = spec.needed and spec.name != "joystick"
    return Node(
        package=package,
        executable=executable,
        namespace=namespace,
        ros_arguments=[*spec.arguments],
        prefix=END_WITH_LAUNCH,
        output="screen",
        on_exit=Shutdown(reason=f"{spec.name} ended") if ends_the_graph else None,
    )
