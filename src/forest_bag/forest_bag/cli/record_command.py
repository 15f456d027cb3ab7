"""`forest-bag record`: every topic, or the chosen ones, as raw bytes into a bag, until Ctrl-C."""

import argparse
import json
import re
import time
from pathlib import Path
from typing import Any

from forest_bag.record.topic_choice import ChoiceError, compiled
from forest_bag.storage.mcap_chunk import COMPRESSIONS
from forest_msgs_py.runtime.command_line import Subcommands, number

NODE = "bag_recorder"  # not the name of a graph's own recorder: both may record
SERVICES = f"While it records, the services /{NODE}/start, stop, split, snapshot and mark act on it."


def add_parser(verbs: Subcommands) -> None:
    """Add the verb and its flags."""
    text = "record topics into a bag until Ctrl-C"
    parser = verbs.add_parser("record", help=text, description=f"{text[0].upper()}{text[1:]}. {SERVICES}")
    parser.set_defaults(command=run)
    _add_choice(parser)
    add = parser.add_argument
    add("-o", "--output", type=Path, metavar="DIR", help="to be made (default: rosbag2_ and the time)")
    add(
        "--compression",
        choices=COMPRESSIONS,
        default="zstd",
        help="compression of chunks (default: %(default)s)",
    )
    add("-d", "--max-duration", "--max-bag-duration", type=number(0.0, 1e9), metavar="S",
        help="begin another file after this time (default: 3600; 0: never)")  # fmt: skip
    add(
        "--max-size",
        type=number(0.0, 1e9),
        metavar="MB",
        help="begin another file before one exceeds this size",
    )
    add("-b", "--max-bag-size", type=number(0.0, 1e9), metavar="BYTES", help="as --max-size, in bytes")
    add("--snapshot-seconds", type=number(0.0, 1e9), metavar="S",
        help=f"keep the last S seconds in memory; /{NODE}/snapshot writes them")  # fmt: skip
    add("--qos-profile-overrides-path", type=Path, metavar="FILE.yaml",
        help="QoS of the subscriptions (default: what suits all publishers)")  # fmt: skip
    add("--use-sim-time", action="store_true",
        help="take log times from /clock; recording begins with its first message")  # fmt: skip
    add("--start-paused", action="store_true", help=f"begin to record at /{NODE}/start")
    add(
        "--node-name",
        type=_name,
        default=NODE,
        metavar="NAME",
        help="name of the node (default: %(default)s)",
    )
    add(
        "--namespace",
        type=_namespace,
        default="",
        metavar="NS",
        help="namespace of relative names (default: /)",
    )


def _add_choice(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("names", nargs="*", metavar="TOPIC", help="topics to record (default: all); as --topics")
    add("--topics", nargs="+", default=[], metavar="TOPIC", help="topics to record (default: all)")
    add("-e", "--regex", type=_regex, help="record topics whose name contains this")
    add("-a", "--all", action="store_true", help="record every topic (the default)")
    add("-x", "--exclude", nargs="+", type=_regex, default=[], metavar="TOPIC",
        help="topics to leave out: names, or regular expressions that a name contains")  # fmt: skip


def _name(text: str) -> str:
    if not re.fullmatch(r"[A-Za-z_]\w*", text, re.ASCII):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: letters, digits and _, not a digit first")
    return text


def _namespace(text: str) -> str:
    return "/" + "/".join(map(_name, text.strip("/").split("/"))) if text.strip("/") else ""


def _regex(text: str) -> str:
    try:
        compiled(text)
    except ChoiceError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def parameters(options: argparse.Namespace) -> dict[str, Any]:
    """Return the recorder's parameters that the flags ask for."""
    topics = [] if options.all else [*options.names, *options.topics]
    size = options.max_size
    if size is None and options.max_bag_size is not None:
        size = options.max_bag_size * 1e-6
    asked = {
        "output": str(options.output or time.strftime("rosbag2_%Y_%m_%d-%H_%M_%S")),
        "topics": topics or None,
        "regex": None if options.all else options.regex,
        "exclude": options.exclude or None,
        "everything": True,
        "compression": options.compression,
        "max_duration": options.max_duration,
        "max_size": size,
        "snapshot_seconds": options.snapshot_seconds,
        "start_paused": options.start_paused or None,
        "qos_profile_overrides_path": options.qos_profile_overrides_path
        and str(options.qos_profile_overrides_path.resolve()),
        "use_sim_time": options.use_sim_time or None,
    }
    return {name: value for name, value in asked.items() if value is not None}


def run(options: argparse.Namespace) -> int:
    """Record; return the recorder's exit code."""
    from forest_bag import recorder_node

    arguments = ["--ros-args", "-r", f"__node:={options.node_name}"]
    for name, value in parameters(options).items():  # rcl reads them as YAML, of which JSON is one
        arguments += ["-p", f"{name}:={json.dumps(value)}"]
    if options.namespace:
        arguments += ["-r", f"__ns:={options.namespace}"]
    return recorder_node.main(arguments)
