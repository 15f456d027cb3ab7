"""A program's nodes for ROS's own launch, which is on no package index and imported where it is used."""

from collections.abc import Callable, Sequence
from typing import Any

from forest_bringup.supervisor import NodeSpec

# Of util-linux: no orphan commands a crane after `kill -9` of launch.
END_WITH_LAUNCH = "setpriv --pdeathsig TERM"
Nodes = Callable[[Sequence[str]], tuple[str, Sequence[NodeSpec]]]


def launch_description(values: Sequence[str], flags: Sequence[str], nodes: Nodes) -> Any:
    """Return the launch arguments, which are options of a program, and its nodes.

    Args:
        values: names of the options that take a value; empty: not given.
        flags: names of those that take none; true or false.
        nodes: gives namespace and nodes for a program's arguments.
    """
    from launch.actions import DeclareLaunchArgument, OpaqueFunction
    from launch.substitutions import LaunchConfiguration

    from launch import LaunchDescription

    def started(context: Any) -> list[Any]:
        given = {name: LaunchConfiguration(name).perform(context) for name in (*values, *flags)}
        words = [word for name in values if given[name] for word in (_option(name), given[name])]
        words += [_option(name) for name in flags if given[name] == "true"]
        namespace, specs = nodes(words)
        return [_node(spec, namespace) for spec in specs]

    arguments = [DeclareLaunchArgument(name, default_value="") for name in values]
    arguments += [
        DeclareLaunchArgument(name, default_value="false", choices=["true", "false"]) for name in flags
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=started)])


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _node(spec: NodeSpec, namespace: str) -> Any:
    from launch.actions import Shutdown
    from launch_ros.actions import Node

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
