"""`forest-bag recover`: a bag that every reader accepts, from what a killed recorder or a full disk left."""

from __future__ import annotations

import argparse
from pathlib import Path

from forest_msgs_py.bag_files import BagError, bag_files


def add_parser(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the verb and its flags."""
    text = "make a whole bag of what is readable in a damaged one"
    parser = verbs.add_parser("recover", help=text, description=text.capitalize() + ".")
    parser.set_defaults(command=run)
    parser.add_argument("bag", type=Path, help="a bag's directory, or an .mcap file; it is left as it is")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="to be made (default: BAG_recovered)"
    )


def run(options: argparse.Namespace) -> int:
    """Recover; return the exit code."""
    bag_files(options.bag)
    raise BagError("recover is being written")
