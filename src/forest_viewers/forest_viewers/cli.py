"""`forest-viewers`: bags for viewers, and where the layouts are.

Exit codes: 0 well, 1 failed, 2 wrong arguments, 130 stopped.
"""

import argparse
import sys
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from forest_bag.storage.bag_files import BagError
from forest_description.config.parameter import MachineError
from forest_msgs_py.runtime import command_line
from forest_msgs_py.runtime.command_line import subcommand
from forest_viewers.recorded.bag_frames import with_frames

PROGRAM = "forest-viewers"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; return its exit code."""
    options = _parser().parse_args(arguments)
    return command_line.run(PROGRAM, options, (BagError, MachineError))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=PROGRAM, description="Open graph and bags in other tools.")
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    text = "write a bag again with all joints and frames, to be dragged into Foxglove or Lichtblick"
    frames = subcommand(verbs, "frames", text, _frames)
    frames.add_argument("bag", type=Path, help="directory or file of the bag, which is not changed")
    frames.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="directory to be made"
    )
    frames.add_argument("--machine", default="", help="shipped machine or a file (default: the bag's own)")
    text = "print the paths of the layouts and of the other tools' files"
    subcommand(verbs, "layouts", text, _layouts)
    return parser


def _frames(options: argparse.Namespace) -> int:
    count = with_frames(options.bag, options.output, options.machine)
    print(f"{count} poses added: {options.output}")
    return 0


def _layouts(_options: argparse.Namespace) -> int:
    print("\n".join(sorted(str(file) for file in files("forest_viewers").joinpath("layouts").iterdir())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
