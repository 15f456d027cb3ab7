"""`scripts/graph.sh`: the live graph until Ctrl-C."""

import argparse
import json
import re
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from forest_bringup.graph_command import run_command
from forest_bringup.profile_choice import add_profile_option, profile_for
from forest_bringup.supervisor import NodeSpec, Supervisor
from forest_control.config.joystick_file import AUTO
from forest_control.servo.schemes import LABELS, Scheme

DEVICE = "device"  # a joystick's source: the only gamepad that is plugged in
LEADERS = ("simulator", "step_player")  # in lockstep: nodes that begin each step

HIGHEST_PORT = 65535


def add_graph_options(parser: argparse.ArgumentParser) -> None:
    """Add what demo and live graph have in common."""
    parser.add_argument(
        "--machine", default="c180", help="shipped machine, or a machine file (default: c180)"
    )
    parser.add_argument(
        "--scheme",
        choices=LABELS,
        default=Scheme.COORDINATED.label,
        help="control scheme (default: %(default)s)",
    )
    parser.add_argument(
        "--namespace", type=ros_namespace, default="/", help="ROS namespace of the graph (default: /)"
    )
    add_profile_option(parser)


def add_part_option(parser: argparse.ArgumentParser) -> None:
    """Add what starts a part of a graph, whose other part runs on another host."""
    parser.add_argument(
        "--only",
        type=lambda text: text.split(","),
        default=(),
        metavar="NODE[,NODE...]",
        help="start these nodes only: another host starts the others (FOREST_NETWORK names it)",
    )


def ros_namespace(text: str) -> str:
    """Return a namespace with its leading slash.

    Raises:
        argparse.ArgumentTypeError: not a ROS namespace.
    """
    name = "/" + text.strip("/")
    if name != "/" and not re.fullmatch(r"(/[A-Za-z_][A-Za-z0-9_]*)+", name):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a ROS namespace: letters, digits and _, not a digit first"
        )
    return name


def source_path(text: str) -> str:
    """Return `thesis`, or the absolute path of a CSV file or a bag.

    Raises:
        argparse.ArgumentTypeError: neither.
    """
    if text == "thesis":
        return text
    path = Path(text)
    if not path.exists():
        raise argparse.ArgumentTypeError(f"{text!r} is neither 'thesis' nor a CSV file or bag that exists")
    return str(path.resolve())


def joystick_source(text: str) -> str:
    """Return what `source_path` does, or a device: `device`, a path below /dev, or that of a mapping file.

    Raises:
        argparse.ArgumentTypeError: none of them.
    """
    if text == DEVICE or text.startswith("/dev/"):  # which may be plugged in later
        return text
    return source_path(text)


def is_device(source: str | None) -> bool:
    """Tell whether a joystick's source is a device under a hand."""
    return source is not None and (source == DEVICE or source.startswith("/dev/") or source.endswith(".yaml"))


def machine_arguments(machine: str) -> tuple[str, ...]:
    """Return the ROS arguments that name the machine; every node that knows the machine gets them."""
    return parameter("machine", str(Path(machine).resolve() if Path(machine).suffix else machine))


def parameter(name: str, value: Any) -> tuple[str, str]:
    """Return the ROS arguments for a parameter; rcl reads them as YAML, of which JSON is a part."""
    return "-p", f"{name}:={json.dumps(value)}"


def parameters(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the ROS arguments for several parameters."""
    return tuple(word for name, value in values.items() for word in parameter(name, value))


def joystick(
    source: str, duration: float, listeners: int, faults: str = "", interpolate: bool = True
) -> NodeSpec:
    """Return the joystick source, with what goes wrong with it."""
    values = {"source": source, "duration": duration, "wait_for_subscribers": listeners, "faults": faults}
    arguments = parameters({**values, "interpolate": interpolate})
    return NodeSpec("joystick", "forest_control.joystick_node", arguments, urgent=True)


def device_joystick(source: str) -> NodeSpec:
    """Return the joystick that reads a device."""
    device = parameter("device", AUTO if source == DEVICE else source)
    return NodeSpec("joystick", "forest_control.joystick_node", device, urgent=True)


def control(
    machine: str, scheme: str, shadow: bool, describe: bool, profile: Mapping[str, Any] | None = None
) -> tuple[NodeSpec, NodeSpec]:
    """Return controller and valve driver.

    Args:
        machine: shipped one, or a file.
        scheme: of the controller.
        shadow: the driver publishes no voltage.
        describe: the controller publishes the URDF (there is no simulator).
        profile: parameters of the controller that are its operator's.
    """
    known = machine_arguments(machine)
    choices = parameters({"scheme": scheme, "publish_description": describe, **(profile or {})})
    driver = (*known, *parameter("shadow", shadow))
    return (
        NodeSpec("controller", "forest_control.controller_node", (*known, *choices), urgent=True),
        NodeSpec("valve_driver", "forest_control.valve_driver_node", driver, urgent=True),
    )


def simulator(machine: str, loads: str = "") -> NodeSpec:
    """Return the simulated machine, with a schedule of the logs in its head."""
    arguments = machine_arguments(machine) + (parameter("loads", loads) if loads else ())
    return NodeSpec("simulator", "forest_sim.simulator_node", arguments, urgent=True)


def recorder(bag: Path) -> NodeSpec:
    """Return the recorder."""
    output = parameter("output", str(bag.resolve()))
    return NodeSpec("recorder", "forest_bag.recorder_node", output, needed=False)


def taught_work(machine: str, folder: Path) -> NodeSpec:
    """Return the player of taught work; without it the crane obeys its levers."""
    arguments = (*machine_arguments(machine), *parameter("directory", str(folder.resolve())))
    return NodeSpec("cycle", "forest_control.cycle_node", arguments, needed=False)


def program_velocity() -> NodeSpec:
    """Return the node by which a program's velocity moves the tip."""
    return NodeSpec("twist", "forest_control.twist_node", (), needed=False)


def monitor(machine: str) -> NodeSpec:
    """Return the node that tells on /diagnostics what is wrong with the machine."""
    return NodeSpec("monitor", "forest_ident.monitor_node", machine_arguments(machine), needed=False)


def viewer(machine: str) -> NodeSpec:
    """Return the node that draws the crane for viewers."""
    return NodeSpec("viewer", "forest_viewers.viewer_node", machine_arguments(machine), needed=False)


def foxglove(port: int) -> NodeSpec:
    """Return the server for Foxglove and Lichtblick."""
    return NodeSpec("foxglove", "forest_viewers.foxglove_node", parameter("port", port), needed=False)


def tcp_port(text: str) -> int:
    """Return a TCP port.

    Raises:
        argparse.ArgumentTypeError: not a port.
    """
    if not text.isdecimal() or not 1 <= int(text) <= HIGHEST_PORT:
        raise argparse.ArgumentTypeError(f"{text!r} is not a port; allowed: 1 to {HIGHEST_PORT}")
    return int(text)


def parse_options(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the live graph."""
    parser = argparse.ArgumentParser(prog="scripts/graph.sh", description="Run the live graph until Ctrl-C.")
    add_graph_options(parser)
    add_part_option(parser)
    parser.add_argument("--no-simulator", action="store_true", help="a real crane is behind the topics")
    parser.add_argument("--shadow", action="store_true", help="compute everything, publish no voltage")
    parser.add_argument(
        "--joystick",
        type=joystick_source,
        metavar="thesis|FILE.csv|BAG|device|/dev/input/…|FILE.yaml",
        help="thesis' input, CSV or bag, played once; or a gamepad, a device, or those of a mapping file "
        "(default: another node publishes /joy)",
    )
    parser.add_argument(
        "--viewer", action="store_true", help="publish all joints, frames and markers for RViz and the like"
    )
    parser.add_argument(
        "--foxglove",
        type=tcp_port,
        metavar="PORT",
        help="--viewer, and serve Foxglove and Lichtblick at ws://127.0.0.1:PORT (usual: 8765)",
    )
    parser.add_argument("--record", type=Path, metavar="DIR", help="record a bag into this directory")
    parser.add_argument("--cycles", type=Path, metavar="DIR", help="directory of taught cycles")
    parser.add_argument(
        "--twist", action="store_true", help="follow a program's velocity commands on delta_twist_cmds"
    )
    parser.add_argument("--monitor", action="store_true", help="report faults of the machine on /diagnostics")
    return parser.parse_args(arguments)


def graph_nodes(options: argparse.Namespace) -> list[NodeSpec]:
    """Return the nodes of the live graph, in the order in which they are to be stopped."""
    profile = profile_for(options.joystick, options.profile)
    nodes = [*control(options.machine, options.scheme, options.shadow, options.no_simulator, profile)]
    if options.joystick:
        source = options.joystick
        nodes.insert(0, device_joystick(source) if is_device(source) else joystick(source, 0.0, 1))
    if not options.no_simulator:
        nodes.append(simulator(options.machine))
    if options.cycles:
        nodes.insert(0, taught_work(options.machine, options.cycles))
    if options.twist:
        nodes.insert(0, program_velocity())
    if options.monitor:
        nodes.append(monitor(options.machine))
    if options.viewer or options.foxglove:
        nodes.append(viewer(options.machine))
    if options.foxglove:
        nodes.append(foxglove(options.foxglove))
    if options.record:
        nodes.append(recorder(options.record))
    return nodes


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the graph; return 0 after a stop on request, 1 after a failure."""
    options = parse_options(arguments)
    records = options.record and (not options.only or "recorder" in options.only)  # here, not elsewhere
    if records and options.record.exists():
        print(
            f"graph: {options.record} exists already; choose another --record or remove it", file=sys.stderr
        )
        return 2
    plays = bool(options.joystick) and not is_device(options.joystick)
    return run_command(
        "graph",
        graph_nodes(options),
        options.namespace,
        partial(_run, plays=plays),
        only=options.only,
        may_publish=not options.shadow,
        on_log_line=lambda line: print(line, flush=True),
    )


def _run(graph: Supervisor, plays: bool) -> None:
    """Run the graph; where a joystick's source plays, say when it has ended."""
    if plays:
        graph.run(until="joystick")
        print("the joystick source has played to its end; Ctrl-C stops the graph", flush=True)
    graph.run()


if __name__ == "__main__":
    sys.exit(main())
