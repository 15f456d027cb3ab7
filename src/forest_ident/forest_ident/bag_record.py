"""`forest-bag record`: every topic, or the chosen ones, as raw bytes into a bag, until Ctrl-C."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path


def add_parser(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the verb and its flags."""
    text = "record topics into a bag until Ctrl-C"
    parser = verbs.add_parser("record", help=text, description=text.capitalize() + ".")
    parser.set_defaults(command=run)
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="to be made (default: rosbag2_ and the time)"
    )
    parser.add_argument("--exclude", nargs="+", default=[], metavar="TOPIC", help="topics not to record")


def run(options: argparse.Namespace) -> int:
    """Record; return the recorder's exit code."""
    from forest_ident import recorder_node

    output = options.output or Path(time.strftime("rosbag2_%Y_%m_%d-%H_%M_%S"))
    told = ["-p", f"output:={json.dumps(str(output))}"]
    if options.exclude:
        told += ["-p", f"exclude:={json.dumps(options.exclude)}"]
    return recorder_node.main(["--ros-args", *told])
