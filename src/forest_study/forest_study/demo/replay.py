"""`forest-study replay`: nodes fed from a bag in lockstep, and whether they answer as they did.

A bag that was recorded in lockstep holds all that its nodes heard, and, attached, their parameters. Fed
with the same, the same nodes say the same, bit by bit; a changed gain shows as a difference with its place.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from forest_bag.cli import main
from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_bringup import graph, lockstep_run
from forest_bringup.graph_lock import GraphError
from forest_bringup.supervisor import NodeSpec
from forest_msgs_py.interfaces.stamps import STAMPED
from forest_msgs_py.interfaces.topics import DIAGNOSTICS, EMERGENCY_STOPPED, find
from forest_msgs_py.interfaces.yaml_text import parsed
from forest_msgs_py.types import PERIOD_NS
from forest_study.results import new_directory

MODULES = {
    "controller": "forest_control.controller_node",
    "valve_driver": "forest_control.valve_driver_node",
    "simulator": "forest_sim.simulator_node",
}
SHARED = (DIAGNOSTICS, EMERGENCY_STOPPED)  # topics on which several nodes speak
RUN_OWN = ("lockstep", "lockstep_guard", "steps", "wait_for_recorder")  # of a run, not of a node
MOST_STEPS = 200 * 86_400  # a day; stamps of the wall clock are far beyond


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("bag", type=Path, help="bag, recorded in lockstep")
    parser.add_argument(
        "--nodes",
        nargs="+",
        choices=tuple(MODULES),
        default=["controller"],
        help="nodes to run (default: controller), the rest from the bag; simulator: all but the joystick run",
    )
    parser.add_argument(
        "--tolerance",
        nargs="*",
        default=[],
        metavar="T",
        help="tolerances, as of `forest-bag compare` (default: 0)",
    )
    parser.add_argument(
        "--set",
        nargs="*",
        default=[],
        type=change,
        metavar="NODE.PARAMETER=VALUE",
        help="parameter that differs from the recorded run",
    )


def change(text: str) -> tuple[str, str]:
    """Return node and ROS argument of a changed parameter.

    Raises:
        argparse.ArgumentTypeError: not of the form.
    """
    name, equals, value = text.partition("=")
    node, dot, parameter = name.partition(".")
    if not (equals and dot and node in MODULES and parameter):
        raise argparse.ArgumentTypeError(
            f"{text!r}; allowed: NODE.PARAMETER=VALUE with a node of {', '.join(MODULES)}"
        )
    return node, f"{parameter}:={value}"


def run(options: argparse.Namespace) -> int:
    """Replay, and compare; return 0 when nothing differs, 1 otherwise.

    Raises:
        GraphError: the bag cannot be used, or a node failed.
        StudyError: the directory is not empty.
    """
    bag, out, names = options.bag, options.out, list(dict.fromkeys(options.nodes))
    new_directory(out)
    if "simulator" in names:
        names = list(MODULES)
    for node, _ in options.set:
        if node not in names:
            raise GraphError(
                f"--set {node}: this node is not run; allowed: {', '.join(names)}, or --nodes {node}"
            )
    try:
        with BagReader(bag) as reader:
            last = reader.span[1]
            topics = list(reader.channels)
            attached = {a.name: a.data for file in reader.files for a in file.attachments}
    except (BagError, OSError) as error:
        raise GraphError(str(error)) from error
    steps, rest = divmod(last, PERIOD_NS)
    if rest or not 0 < steps < MOST_STEPS:
        raise GraphError(f"{bag} was not recorded in lockstep; allowed: a bag whose log times are k*0.005 s")
    nodes = [_node(bag, name, attached, options.set, out) for name in names]
    if "simulator" in names:
        nodes.insert(0, graph.joystick(str(bag.resolve()), 0.0, 0))
    else:
        nodes.append(_player(bag, topics, names))
    lockstep_run.run([*nodes, graph.recorder(out / "bag")], steps, out / "log")
    # Of these everybody says a part: without those who are not there they cannot be the same.
    alone = "simulator" not in names
    shared = [name for name in topics if alone and find(name) in SHARED]
    ignored = ["--ignore", *shared] if shared else []
    allowed = [word for text in options.tolerance for word in ("--tolerance", text)]
    return main.main(["compare", str(bag), str(out / "bag"), *ignored, *allowed])


def _node(
    bag: Path, name: str, attached: Mapping[str, bytes], changes: Sequence[tuple[str, str]], out: Path
) -> NodeSpec:
    """Return a node with the parameters that it had, but for the changes."""
    label = next((label for label in attached if label.endswith(f"/{name}.yaml")), None)
    if label is None:
        raise GraphError(f"{bag} does not hold the parameters of {name}; allowed: a bag of this recorder")
    own = out / f"{name}.yaml"
    parameters = next(iter(parsed(attached[label].decode()).values()))["ros__parameters"]
    for node, text in changes:
        if node == name and (wanted := text.partition(":=")[0]) not in parameters:
            known = ", ".join(sorted(set(parameters) - set(RUN_OWN)))
            raise GraphError(f"the bag's {name} has no parameter {wanted!r}; allowed: {known}")
    kept = {key: value for key, value in parameters.items() if key not in RUN_OWN}
    own.write_text(yaml.safe_dump({"/**": {"ros__parameters": kept}}), encoding="utf-8")
    changed = [word for node, text in changes if node == name for word in ("-p", text)]
    return NodeSpec(name, MODULES[name], ("--params-file", str(own.resolve()), *changed))


def _player(bag: Path, topics: Sequence[str], nodes: Sequence[str]) -> NodeSpec:
    """Return what says the rest: every topic of the bag that the nodes do not say."""
    rows = [row for row in map(find, topics) if row is not None]
    spoken = [row for row in rows if row.type in STAMPED and row != DIAGNOSTICS]
    answers = [row.name for row in spoken if set(row.publishers) & set(nodes)]
    if not answers:
        raise GraphError(f"{bag} holds no topic of {', '.join(nodes)}; there are {', '.join(topics)}")
    told = (*graph.parameter("bag", str(bag.resolve())), *graph.parameter("answers", answers))
    return NodeSpec("step_player", "forest_bag.step_player_node", told)
