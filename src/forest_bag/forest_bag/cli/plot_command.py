"""`forest-bag plot`: the demo's pictures of any bag of this project's topics."""

import argparse
import logging
import math
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_msgs_py.interfaces.topics import JOINTS, ROBOT_DESCRIPTION, find
from forest_msgs_py.runtime.command_line import Subcommands, subcommand


def add_parser(verbs: Subcommands) -> None:
    """Add the verb and its flags."""
    text = "draw the demo's pictures of a bag: tip path, tip error, joints, voltages, hydraulics"
    parser = subcommand(verbs, "plot", text, run)
    parser.add_argument("bag", type=Path, metavar="BAG", help="directory, .mcap or .db3 file")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="directory of the pictures (default: BAG_pictures)"
    )


def run(options: argparse.Namespace) -> int:
    """Draw; return the exit code."""
    from forest_bag.plots.standard_plots import draw_all
    from forest_bag.read.timeseries import read_bag

    logging.basicConfig(format="forest-bag: %(message)s", stream=sys.stderr)
    with BagReader(options.bag, lenient=True) as reader:
        limits = joint_limits(reader)
    output = options.output or options.bag.parent / f"{options.bag.resolve().name}_pictures"
    if output.exists() and not output.is_dir():
        raise BagError(f"{output} is a file; allowed: a directory for the pictures")
    drawn = draw_all(read_bag(options.bag), output, limits)
    if not drawn:
        raise BagError(
            f"no picture of {options.bag}: it holds none of the topics that are drawn "
            "(docs/reference/topics.md)"
        )
    for path in drawn:
        print(path)
    return 0


def joint_limits(reader: BagReader) -> dict[str, tuple[float, float]]:
    """Joint limits [rad] of the robot description in a bag; {} without one."""
    names = {name for name in reader.channels if find(name) == ROBOT_DESCRIPTION}
    message = next(reader.messages(names), None) if names else None
    if message is None:
        return {}
    start = message.data.find(b"<")
    try:
        robot = ET.fromstring(message.data[start:].rstrip(b"\0").decode("utf-8", "replace"))
    except ET.ParseError:
        return {}
    limits = {}
    for joint in robot.iter("joint"):
        limit = joint.find("limit")
        if joint.get("name") in JOINTS and limit is not None:
            low, high = _number(limit.get("lower")), _number(limit.get("upper"))
            if math.isfinite(low) and math.isfinite(high):
                limits[str(joint.get("name"))] = (low, high)
    return limits


def _number(text: str | None) -> float:
    """A number; NaN where there is none."""
    try:
        return float(text or "")
    except ValueError:
        return math.nan
